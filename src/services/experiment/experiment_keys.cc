#include "experiment/experiment_keys.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>
#include <variant>

#include "experiment/experiment_file.h"
#include "render/layout.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Whether a figure or picture is made.
Key show_key(const std::string& table, std::string meaning, bool& field) {
  return make_key(table, "show", "", std::move(meaning), field);
}

std::vector<Key> keys_of_texts(Experiment& e) {
  return {
      make_key("experiment", "name", "", "title of the report, one line", e.name),
      make_key("experiment", "description", "", "a paragraph for the reader of the report", e.description),
  };
}

/// What differs from main ensemble to main ensemble.
std::vector<Key> keys_of_scan(Experiment& e) {
  KeyRange frictions = friction_range();
  frictions.fewest = 1;
  frictions.longest = most_friction_values;
  return {
      make_key(
          "friction", "mu", "",
          "friction coefficients of the contacts of beads; [] where only studies are wanted: 0, which costs nothing",
          e.mu, frictions),

      make_key(
          "scan", "parameter", "",
          "what differs from main ensemble to main ensemble: mu, bead_weight or lambda (law polytope) of the beads, "
          "disorder of "
          "the q-model or of stochastic OSL, middle, noise or share of the three-leg model, opened_share of diluted "
          "beads; empty: the first of these that the piles depend on",
          e.scan.parameter),
      make_key("scan", "values", "", "its values; none: friction.mu, or the one that the model's table has",
               e.scan.values, KeyRange{.least = 0, .longest = most_friction_values, .ascending = true}),
  };
}

std::vector<Key> keys_of_results(Experiment& e) {
  const std::string claims = "claims", precision = "precision", profiles = "figures.response_profiles";
  const KeyRange standard_error =
      KeyRange{.or_zero = true, .why = "it is no standard error to draw for"}.within(1e-9, 1);
  return {
      make_key(
          precision, "c", "",
          "largest standard error wanted of the slope c: at each mu response.samples is multiplied by 3/2 until it "
          "is reached; 0: not asked for",
          e.precision.c, standard_error),
      make_key(precision, "D", "bead diameters", "the same for the slope D; both together: until both are reached",
               e.precision.D, standard_error),
      make_key(precision, "most_samples", "piles",
               "most piles per friction coefficient; where they do not reach the precision, the report says so",
               e.precision.most_samples, KeyRange{}.within(1, most_samples)),

      make_key(claims, "decisive_chi2", "",
               "double-peak: difference in chi squared that decides between two peaks and one (25: five standard "
               "deviations)",
               e.claims.decisive_chi2,
               KeyRange{.why = "below 9 (three standard deviations) noise makes peaks, and beyond 1e6 nothing is ever "
                               "decided (25 is usual)"}
                   .within(9, 1e6)),
      make_key(
          claims, "highest_mu", "",
          "double-peak, linear-time: friction that friction.mu, or the counted work, must reach for a claim up to 1.7",
          e.claims.highest_mu, friction_range()),
      make_key(claims, "largest_remainder", "",
               "two-gaussians: share of the response that two Gaussians which describe it well may leave out",
               e.claims.largest_remainder,
               KeyRange{.why = "it is not a share that a response could leave out or not"}.above(0).below(1)),
      make_key(claims, "exponent_tolerance", "",
               "exponents of z, N and the number of beads: standard error granted to them for the finite range",
               e.claims.exponent_tolerance,
               KeyRange{.why = "three times it must stay below 20 % of the exponent 1/2, or nothing is left to decide"}
                   .within(0, 0.03)),

      show_key(
          "figures.bead_forces",
          "plot one bead of the force-chain pile with its contacts and cones, at figures.response_profiles.mu (Fig. 1)",
          e.figures.bead_forces),
      show_key(profiles, "plot the response at a few layers with its fits (the paper's Fig. 2)",
               e.figures.response_profiles),
      make_key(profiles, "mu", "",
               "friction coefficient shown, one of friction.mu; of another scan the value, or else the last",
               e.figures.profile_mu),
      make_key(profiles, "layers", "layers", "layers shown", e.figures.profile_layers,
               KeyRange{.least = 0, .ascending = true}),
      show_key("figures.transport_with_depth", "plot c and D against depth (Fig. 3)", e.figures.transport_with_depth),
      show_key("figures.propagation_against_diffusion", "plot c against D (Fig. 4)",
               e.figures.propagation_against_diffusion),
      show_key("figures.scaling_with_friction", "plot D against mu, from slopes and from ratios",
               e.figures.scaling_with_friction),
      show_key("figures.propagation_and_thrust", "plot c beside the speed that follows from the thrust ratio",
               e.figures.propagation_and_thrust),
  };
}

std::vector<Key> keys_of_scenes(Experiment& e) {
  const std::string chains = "scenes.force_chains";
  return {
      show_key(chains, "render the force chains of one pile (Fig. 1)", e.force_chains.show),
      make_key(chains, "columns", "beads", "beads per layer of that pile, all shown", e.force_chains.columns,
               KeyRange{.least = fewest_columns}),
      make_key(chains, "layers", "layers", "layers shown; 20 more are computed below them", e.force_chains.layers,
               KeyRange{.least = 1}),
      make_key(chains, "mu", "", "friction coefficient of that pile", e.force_chains.mu, friction_range()),
      make_key(chains, "sample", "", "number of that pile under sampling.seed", e.force_chains.sample,
               KeyRange{.least = 0}),
      make_key(
          chains, "width_px", "pixels",
          "width of the picture of forces; mm = 25.4 width_px / dpi. The others of that pile are at most 57 mm wide",
          e.force_chains.scene.width_px),
      make_key(chains, "dpi", "pixels per inch", "resolution of the picture; its text is laid out in points",
               e.force_chains.scene.dpi, KeyRange{}.within(least_dpi, most_dpi)),
      make_key(chains, "colour_map", "", "colour map of the forces", e.force_chains.scene.colour_map),
      make_key(chains, "backend", "",
               "how OpenGL is reached, auto: by what is there; none: the processor paints the same pixels",
               e.force_chains.scene.backend, KeyRange{.names = {"auto", "osmesa", "egl", "none"}}),
      make_key(chains, "skip_invisible", "", "leave out contacts that cannot change a pixel",
               e.force_chains.scene.skip_invisible),
      show_key("scenes.weight", "render the weights of the beads of scenes.force_chains, darker where larger",
               e.force_chains.weight),
      show_key("scenes.friction",
               "render how much of its friction each contact of scenes.force_chains mobilises, |T| / (mu N)",
               e.force_chains.friction),
      show_key("scenes.response",
               "render how those weights change with the overload, every bead keeping its random number",
               e.force_chains.response),
      show_key(
          "scenes.response_field",
          "render the mean response over the plane, at figures.response_profiles.mu, with the fitted rays and widths",
          e.response_field.show),

      make_key("report", "pdf", "", "also write report.pdf, if WeasyPrint is installed", e.report.pdf),
      make_key("report", "headline", "", "what page 1 says, in place of sentences made from the numbers",
               e.report.headline),
      make_key("report", "about", "",
               "study that page 1 is about: the ID of its table [studies.ID]; empty: the exponents of c and D, or a "
               "study where there are none",
               e.report.about),
      make_key("report", "key_figure", "",
               "id of the figure on page 1 (\"dispersion\"); empty: the first one of what page 1 is about",
               e.report.key_figure),
  };
}

}  // namespace

std::string nearest_to_top(const std::vector<Key>& keys, const std::string& name) {
  std::string path;
  for (const Key& key : keys) {
    const bool nearer = path.empty() || std::ranges::count(key.table, '.') + 1 < std::ranges::count(path, '.');
    if (key.name == name && name != "show" && nearer) path = key.path();
  }
  return path;
}

std::vector<Key> keys_of(Experiment& experiment) {
  std::vector<Key> all;
  const auto append = [&all](std::vector<Key> keys) { std::move(keys.begin(), keys.end(), std::back_inserter(all)); };
  append(keys_of_texts(experiment));
  std::vector<Key> lattice = keys_of(experiment.lattice);
  std::ranges::find(lattice, "layers", &Key::name)->range.least = bottom_margin_of(experiment.sampling.model) + 4;
  append(std::move(lattice));
  append(keys_of_scan(experiment));
  append(keys_of(experiment.sampling));
  append(keys_of(experiment.response));
  append(keys_of(experiment.fit));
  append(keys_of_results(experiment));
  append(keys_of(experiment.sampling.model));
  for (const auto& study : experiment.studies) append(study->keys());
  append(keys_of_scenes(experiment));
  return all;
}

std::vector<Key> picture_keys(Experiment& e, const std::string& name) {
  PictureSpec& picture = e.pictures.at(name);
  const std::string table = fmt::format("{}.{}", pictures_table, name);
  return {
      make_key(table, "scene", "",
               "one more picture of the pile of scenes.force_chains: forces, weight, friction, response",
               picture.scene),
      make_key(table, "window", "bead diameters, layers",
               "part shown: x0, x1 from the middle, first and last layer, both included; none: all that is shown",
               picture.window),
      make_key(table, "range", "as the scene",
               "ends of the colour scale, so that pictures compare; none: from what is shown", picture.range),
      make_key(table, "colour_map", "",
               "grey, viridis or cividis, or diverging for the scene response; empty: the scene's own",
               picture.colour_map),
      make_key(table, "width_px", "pixels", "width of the picture, at scenes.force_chains.dpi", picture.width_px),
  };
}

namespace {

/// How many bytes at the beginning are a control character or a mark that turns the direction of text; 0: none.
std::size_t hidden_bytes(std::string_view text) {
  for (std::size_t bytes = 1; bytes <= std::min<std::size_t>(3, text.size()) && text[0] != ' '; ++bytes) {
    if (single_line(text.substr(0, bytes)).empty()) return bytes;
  }
  return 0;
}

/// A TOML basic string on one line, in which nothing is hidden.
std::string quote(std::string_view text) {
  std::string quoted = "\"";
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const std::size_t hidden = hidden_bytes(text.substr(at));
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (hidden > 0) {
      unsigned code = static_cast<unsigned char>(c) & (hidden == 1 ? 0x7FU : hidden == 2 ? 0x1FU : 0x0FU);
      for (std::size_t k = 1; k < hidden; ++k) code = (code << 6U) | (static_cast<unsigned char>(text[++at]) & 0x3FU);
      quoted += fmt::format("\\u{:04X}", code);
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

/// The shortest TOML float that reads back to the same double.
std::string print_number(double number) {
  const std::string text = exact(number);
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

template <class List, class Print>
std::string print_list(const List& list, Print print) {
  std::string text;
  for (const auto& element : list) text += (text.empty() ? "" : ", ") + print(element);
  return "[" + text + "]";
}

}  // namespace

std::string print_value(const KeyValue& value) {
  struct Visitor {
    std::string operator()(bool on) const { return on ? "true" : "false"; }
    std::string operator()(std::int64_t number) const { return std::to_string(number); }
    std::string operator()(double number) const { return print_number(number); }
    std::string operator()(const std::string& text) const { return quote(text); }
    std::string operator()(const std::vector<std::int64_t>& numbers) const {
      return print_list(numbers, [](std::int64_t number) { return std::to_string(number); });
    }
    std::string operator()(const std::vector<double>& numbers) const { return print_list(numbers, print_number); }
    std::string operator()(const NumberPairs& pairs) const {
      return print_list(pairs, [](const std::array<double, 2>& pair) { return print_list(pair, print_number); });
    }
  };
  return std::visit(Visitor{}, value);
}

std::string print_experiment(const Experiment& experiment) {
  std::string text;
  std::string table;
  std::vector<Key> keys = keys_to_read(experiment);
  for (const auto& [name, picture] : experiment.pictures) {
    for (Key& key : picture_keys(const_cast<Experiment&>(experiment), name)) keys.push_back(std::move(key));
  }
  for (const Key& key : keys) {
    if (key.table != table) {
      text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", key.table);
      table = key.table;
    }
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    text += fmt::format("# {}{}\n{} = {}\n", key.meaning, unit, key.name, print_value(key.get()));
  }
  text += fmt::format("\n[{}]\n# {}\n", expected_verdicts_table, expected_verdicts_meaning);
  for (const auto& [claim, verdict] : experiment.expected_verdicts) {
    text += fmt::format("{} = {}\n", is_plain(claim, "-_") ? claim : quote(claim), quote(verdict));
  }
  return text;
}

std::string print_changes(const Experiment& experiment) {
  const auto tables_of = [](const std::string& text) {
    std::map<std::string, std::set<std::string>> tables;
    std::istringstream lines(text);
    std::string table;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with('[')) table = line;
      tables[table].insert(line);
    }
    return tables;
  };
  const auto defaults = tables_of(print_experiment(Experiment{}));
  std::istringstream lines(print_experiment(experiment));
  std::string text, table, pending;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      table = line;
      pending = (text.empty() ? "" : "\n") + line + "\n";
      continue;
    }
    const auto same = defaults.find(table);
    if (line.empty() || line.starts_with('#') || (same != defaults.end() && same->second.contains(line))) continue;
    text += std::exchange(pending, "") + line + "\n";
  }
  return text;
}

std::string describe_experiment_keys() {
  Experiment defaults;
  defaults.pictures.try_emplace("<name>");
  const std::vector<std::string_view> first{
      "friction.mu",     "lattice.columns", "lattice.layers",     "lattice.angle",    "sampling.law",
      "sampling.seed",   "model.name",      "response.estimator", "response.samples", "response.overload",
      "fit.first_layer", "fit.last_layer",  "fit.scaling_window", "precision.c",      "figures.response_profiles.mu"};
  std::string text = fmt::format("Fifteen that you will change first: `{}`.\n", fmt::join(first, "`, `"));
  std::string table;
  const auto begin_table = [&](const std::string& name, const std::string& example) {
    table = name;
    text += fmt::format(
        "\n### [{0}]\n\n```toml\n[{0}]\n{1}\n```\n\n| key | default | unit | range | meaning "
        "|\n|---|---|---|---|---|\n",
        name, example);
  };
  const auto add_rows = [&](const std::vector<Key>& keys) {
    for (const Key& key : keys) {
      const KeyValue value = key.get();
      if (key.table != table) {
        std::string shown = print_value(value);
        // What is off by default is shown as it is asked for.
        if (shown == "[]") shown = key.range.least > 1 ? "[30, 45, 60]" : "[0.15, 0.2, 0.3]";
        if (shown == "false") shown = "true";
        if (shown == "0" || shown == "0.0") shown = shown == "0" ? "256" : "0.001";
        begin_table(key.table, fmt::format("{} = {}", key.name, shown));
      }
      text += fmt::format("| `{}` | `{}` | {} | {} | {} |\n", key.path(), print_value(value), key.unit,
                          describe(key.range, value), backslashed(key.meaning, "|"));
    }
  };
  add_rows(keys_of(defaults));
  add_rows(picture_keys(defaults, "<name>"));
  begin_table(expected_verdicts_table, "c-of-mu = \"not reproduced\"");
  text += fmt::format("| `{}.<claim>` | none |  |  | {} |\n", expected_verdicts_table, expected_verdicts_meaning);
  return text;
}

}  // namespace granuscope
