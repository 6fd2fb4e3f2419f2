#include "experiment/experiment_keys.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "experiment/experiment_file.h"
#include "render/layout.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Whether a figure or picture is made.
Key show_key(const std::string& table, std::string meaning, bool& field) {
  return make_key(table, "show", "", std::move(meaning), field).formerly_at(table + ".draw");
}

std::vector<Key> keys_of_main_line(Experiment& e) {
  const std::string lattice = "lattice";
  const std::string sampling = "sampling";
  const std::string response = "response";
  const std::string fit = "fit";
  const std::string claims = "claims";
  const std::string precision = "precision";
  const std::string parameters = fmt::format("{}", fmt::join(names_of_scan_parameters(), ", "));
  const std::string profiles = "figures.response_profiles";
  KeyRange frictions = friction_range();
  frictions.fewest = 1;
  frictions.longest = most_friction_values;
  const KeyRange standard_error =
      KeyRange{.or_zero = true, .why = "it is no standard error to draw for"}.within(1e-9, 1);
  return {
      make_key("experiment", "name", "", "title of the report, one line", e.name),
      make_key("experiment", "description", "", "a paragraph for the reader of the report", e.description),

      make_key(lattice, "columns", "beads", "beads per layer, periodic in x; even or odd", e.lattice.columns,
               KeyRange{}.within(fewest_columns, most_columns)),
      make_key(lattice, "layers", "layers",
               "layers computed; the lowest 20 of beads (5 of diluted ones) follow another law, since no failure below "
               "reaches up into them, and are not used",
               e.lattice.layers, KeyRange{}.within(4, most_layers)),

      make_key("friction", "mu", "", "friction coefficients of the contacts of beads", e.mu, frictions),

      make_key(
          "scan", "parameter", "",
          "what differs from main ensemble to main ensemble: mu or lambda (law polytope) of the beads, disorder of "
          "the q-model or of stochastic OSL, middle, noise or share of the three-leg model, opened_share of diluted "
          "beads; empty: the first of these that the piles depend on",
          e.scan.parameter),
      make_key("scan", "values", "", "its values; none: friction.mu, or the one that the model's table has",
               e.scan.values, KeyRange{.least = 0, .longest = most_friction_values, .ascending = true}),

      make_name_key(
          sampling, "law",
          "what a random pile means: granusolve, polytope (small piles), or eloy-clement and rejection (tiny piles)",
          e.sampling.law, law_named),
      make_key(sampling, "seed", "", "together with the sample's number the key of every random number",
               e.sampling.seed, KeyRange{.least = 0}),
      make_key(sampling, "load_angle", "degrees",
               "of the load on every top bead from the vertical, to the right > 0: a tilted pile; responses are still "
               "averaged over mirror images",
               e.sampling.load_angle, KeyRange{}.above(-load_angle_limit).below(load_angle_limit)),
      make_key(sampling, "load_offset", "bead radii",
               "how far to the right of their centres the loads act on the top beads: a torque, handed down with "
               "alternating sign",
               e.sampling.load_offset, KeyRange{}.within(-2, 2)),
      make_key(sampling, "bead_weight", "loads of one top bead",
               "of every bead by itself: gravity, so that the mean weight grows with depth; responses are those to a "
               "load at the top, as without it",
               e.sampling.bead_weight, KeyRange{}.within(0, most_bead_weight)),
      make_key(sampling, "effort", "solutions per bead",
               "granusolve, eloy-clement: a pile counts as failed, by name, after this many bead solutions per bead",
               e.sampling.effort, KeyRange{}.within(least_effort, most_effort)),
      make_key(sampling, "max_tries", "piles", "rejection: a pile counts as failed, by name, after this many tries",
               e.sampling.max_tries, KeyRange{}.within(1, most_tries)),
      make_key(
          sampling, "lambda", "",
          "polytope: piles have the density of the product of length^-lambda over the intervals of all beads; 0 is the "
          "flat measure, 1 the law rejection",
          e.sampling.lambda, KeyRange{}.within(0, 1)),
      make_key(
          sampling, "burn_in", "sweeps",
          "polytope: from the start of a chain to the first of its eight piles; 0: four times the autocorrelation time "
          "that a pilot chain measures",
          e.sampling.burn_in, KeyRange{}.within(0, most_sweeps)),
      make_key(sampling, "thinning", "sweeps",
               "polytope: from one of the eight piles of a chain to the next; 0: half that time", e.sampling.thinning,
               KeyRange{}.within(0, most_sweeps)),
      make_name_key(
          sampling, "layer_order",
          "random start and direction in each layer, or fixed (breaks the mirror symmetry: for comparison only)",
          e.sampling.order, layer_order_named),
      make_name_key(sampling, "repair_rules",
                    "granusolve: all, or without some of the rules that repair a failing bead (no-pair, no-arcs, "
                    "backtrack-only: other laws, for comparison only)",
                    e.sampling.rules, repair_rules_named)
          .formerly_at("sampling.mending_rules"),

      make_name_key(
          response, "estimator",
          "point: overloaded piles minus the uniform load; paired: each pile solved with and without the overload, "
          "keeping its random numbers; multiplexed: all top loads varied at random, the linear response by "
          "correlation; "
          "fluctuation: no load, the linear response from how fluctuations travel down (needs deeper piles)",
          e.response.estimator, estimator_named),
      make_key(response, "overload", "loads of one top bead", "extra force on the middle top bead (point, paired)",
               e.response.overload, KeyRange{}.within(least_overload, most_overload)),
      make_key(response, "epsilon", "loads of one top bead",
               "by how much each top load is raised or lowered (multiplexed)", e.response.epsilon,
               KeyRange{}.within(least_epsilon, epsilon_limit).below(epsilon_limit)),
      make_key(
          response, "opposite", "",
          "multiplexed: draw each pile once more with all variations reversed, from the same random numbers, and take "
          "half the difference; twice the work, and worth it at small epsilon or mu",
          e.response.opposite),
      make_key(response, "sign_run", "beads",
               "multiplexed: so many neighbouring top beads, or one more, are raised or lowered together (1: each by "
               "itself); 2 or 3 measure peaks wider than a bead better",
               e.response.sign_run, KeyRange{.least = 1}),
      make_key(
          response, "reference_lag", "layers",
          "fluctuation: layers from a base layer down to the reference layer, from which the deeper ones are followed",
          e.response.reference_lag, KeyRange{}.within(0, most_reference_lag)),
      make_key(response, "first_base", "layer",
               "fluctuation: shallowest base layer; 0: where fluctuations are saturated, 0.6/mu^2, at least 60 and at "
               "most 2000, or of three legs that push twice the deepest lag",
               e.response.first_base, KeyRange{}.within(0, most_first_base)),
      make_key(response, "base_step", "layers", "fluctuation: distance of the base layers", e.response.base_step,
               KeyRange{}.within(1, most_base_step)),
      make_key(response, "samples", "piles", "piles per friction coefficient, at least eight per block",
               e.response.samples, KeyRange{}.within(group_size * min_blocks, most_samples)),
      make_key(response, "blocks", "blocks", "blocks of the jackknife, each of whole groups of eight piles",
               e.response.blocks, KeyRange{}.within(min_blocks, most_blocks)),

      make_key(fit, "first_layer", "layer", "first layer of the window over which the slopes c and D are taken",
               e.fit.first_layer, KeyRange{.least = 0}),
      make_key(fit, "last_layer", "layer", "last layer of that window, at most lattice.layers - 21", e.fit.last_layer,
               KeyRange{.least = 0}),
      make_key(fit, "layer_step", "layers",
               "distance of the fitted layers; an odd one alternates the two kinds of rows", e.fit.layer_step,
               KeyRange{.least = 1}),
      make_key(fit, "shallow_layer", "layer", "from here down to the window layers are fitted for the figures only",
               e.fit.shallow_layer, KeyRange{.least = 0}),
      make_key(fit, "min_identifiable_width", "bead diameters", "below it the size of a bead hides the width of a peak",
               e.fit.min_identifiable_width, KeyRange{}.within(least_identifiable_width, most_identifiable_width)),
      make_key(fit, "scaling_window", "",
               "range of mu, or of what is scanned, both ends included, of the exponents beta, gamma and alpha",
               e.fit.scaling_window, KeyRange{.least = 0}),
      make_key(fit, "other_scaling_windows", "", "further ranges of mu whose exponents are shown beside it",
               e.fit.other_scaling_windows, KeyRange{.least = 0}),

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
      show_key("figures.scaling_with_friction", "plot D and c0 - c against mu, from slopes and from ratios",
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
      make_key(chains, "width_px", "pixels", "width of the picture; mm = 25.4 width_px / dpi",
               e.force_chains.scene.width_px, KeyRange{}.within(min_image_px, max_image_px)),
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

std::vector<Key> keys_of(Experiment& experiment) {
  std::vector<Key> all;
  const auto append = [&all](std::vector<Key> keys) { std::move(keys.begin(), keys.end(), std::back_inserter(all)); };
  append(keys_of_main_line(experiment));
  append(keys_of(experiment.sampling.model));
  for (const auto& study : experiment.studies) {
    std::vector<Key> keys = study->keys();
    for (Key& key : keys) {  // where all of them stood before they were called studies
      if (key.formerly.empty()) key.formerly = fmt::format("figures.{}.{}", study->id(), key.name);
    }
    append(std::move(keys));
  }
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

/// A TOML basic string on one line.
std::string quote(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(byte));
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

bool is_bare_key(std::string_view name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string escape_table_cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
  return escaped;
}

}  // namespace

std::string print_experiment(const Experiment& experiment) {
  std::string text;
  std::string table;
  Experiment copy = experiment;  // keys could set what they print
  std::vector<Key> keys = keys_of(copy);
  for (const auto& [name, picture] : experiment.pictures) {
    for (Key& key : picture_keys(copy, name)) keys.push_back(std::move(key));
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
    text += fmt::format("{} = {}\n", is_bare_key(claim) ? claim : quote(claim), quote(verdict));
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
  std::string text = "| key | default | unit | range | meaning |\n|---|---|---|---|---|\n";
  const auto add_rows = [&text](const std::vector<Key>& keys) {
    for (const Key& key : keys) {
      const KeyValue value = key.get();
      text += fmt::format("| `{}` | `{}` | {} | {} | {} |\n", key.path(), print_value(value), key.unit,
                          describe(key.range, value), escape_table_cell(key.meaning));
    }
  };
  add_rows(keys_of(defaults));
  add_rows(picture_keys(defaults, "<name>"));
  text += fmt::format("| `{}.<claim>` | none | | | {} |\n", expected_verdicts_table, expected_verdicts_meaning);
  return text;
}

}  // namespace granuscope
