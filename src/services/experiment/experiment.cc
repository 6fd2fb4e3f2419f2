#include "experiment/experiment.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "analysis/claims.h"
#include "analysis/double_gaussian.h"
#include "analysis/transport.h"
#include "experiment/experiment_keys.h"
#include "render/layout.h"
#include "render/palette.h"
#include "render/scene.h"
#include "support/error.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
Experiment::Experiment() = default;

EnsembleSpec Experiment::main_ensemble(double value) const {
  EnsembleSpec spec;
  spec.sampler = sampler_at(value);
  spec.lattice = lattice;
  spec.response = response;
  const bool profiles_wanted = figures.response_profiles && value == shown_value(figures.profile_mu);
  spec.layers = layers_to_record(fit, profiles_wanted ? figures.profile_layers : std::vector<int>{});
  return spec;
}

SceneSpec PictureSpec::scene_like(const ForceChainSpec& chains, double angle) const {
  SceneSpec spec = chains.scene;
  spec.scene = scene;
  spec.colour_map = colour_map;
  spec.width_px = width_px;
  const double half = 0.5 * chains.columns * BeadGeometry(angle).twice_sine;
  spec.window = {{-half, half, 0.0, static_cast<double>(chains.layers - 1)}};
  if (!window.empty()) {
    if (window.size() != 4) {
      throw InputError("a window has four numbers, not {}; write [x0, x1, first layer, last layer]", window.size());
    }
    std::copy(window.begin(), window.end(), spec.window->begin());
  }
  if (!range.empty()) {
    if (range.size() != 2) throw InputError("a colour scale has two ends, not {}; write [low, high]", range.size());
    spec.range = {{range[0], range[1]}};
  }
  return spec;
}

int edit_distance(std::string_view a, std::string_view b) {
  // Of the first i letters of a and the first j of b.
  std::vector<std::vector<int>> distance(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      int& least = distance[i][j] = static_cast<int>(i + j);
      if (i == 0 || j == 0) continue;
      least = std::min(
          {distance[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1), distance[i - 1][j] + 1, distance[i][j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) least = std::min(least, distance[i - 2][j - 2] + 1);
    }
  }
  return distance.back().back();
}

std::optional<std::string> nearest_name(std::string_view mistyped, const std::vector<std::string>& known) {
  if (mistyped.size() > 200) return {};  // no typing error
  std::optional<std::string> best;
  int least = std::max(1, static_cast<int>(mistyped.size()) / 3) + 1;
  for (const std::string& name : known) {
    if (lower_case(name) == lower_case(std::string(mistyped))) return name;
    const int distance = edit_distance(mistyped, name);
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return best;
}

namespace {

bool has_control_character(const std::string& text, bool newlines_allowed) {
  return std::any_of(text.begin(), text.end(), [&](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte < 0x20 && !(newlines_allowed && (c == '\n' || c == '\t'))) || byte == 0x7f;
  });
}

Problem find_text_problem(const Experiment& e) {
  if (e.name.find_first_not_of(" \t") == std::string::npos)
    return problem("experiment.name", "the name is empty, but it titles the report; give one");
  if (e.name.size() > 200 || has_control_character(e.name, false)) {
    return problem("experiment.name",
                   "the name is longer than 200 bytes or holds control characters, but it must fit on one line; "
                   "shorten it and put the rest into experiment.description");
  }
  if (e.description.size() > 10'000 || has_control_character(e.description, true)) {
    return problem("experiment.description",
                   "the description is longer than 10000 bytes or holds control characters, but the report shows it "
                   "as one paragraph; shorten it");
  }
  return {};
}

/// What the block sums of a main ensemble need, in bytes: larger ones are drawn block by block and read layer by layer.
double sums_memory(const Experiment& e) {
  constexpr double most_at_once = 50e6, copies_of_layer = 8;
  const double layers_recorded = static_cast<double>(e.lattice.layers) / std::max(1, e.fit.layer_step);
  const double numbers_per_column = e.response.estimator == EstimatorName::fluctuation ? 2 : 1;
  const double layer = 8.0 * e.response.blocks * e.lattice.columns * numbers_per_column;
  return std::min(most_at_once, 3 * layer * layers_recorded) + copies_of_layer * layer;
}

Problem find_parameter_problem(const Experiment& e) {
  try {
    e.scanned();
  } catch (const InputError& error) {
    return problem("scan.parameter", "{}", error.what());
  }
  return {};
}

Problem find_scan_problem(const Experiment& e) {
  if (auto found = find_parameter_problem(e)) return found;
  const ScanParameter& scanned = e.scanned();
  const bool beads = e.sampling.model.has_contacts();
  if (beads && &scanned != &friction_parameter() && e.mu.size() != 1) {
    return problem("friction.mu",
                   "{} friction coefficients, while {} is what differs from ensemble to ensemble; give one",
                   e.mu.size(), scanned.name);
  }
  for (const double value : e.scan_values()) {
    const SamplerSpec sampler = e.sampler_at(value);
    Problem found = find_problem(sampler);
    const double limit = BeadGeometry(e.lattice.angle).cotangent;
    if (!found && sampler.model.has_contacts() && !(sampler.mu >= 0 && sampler.mu < limit)) {
      found = problem("mu", "friction lies between 0 and {:.4g}, where the cone reaches the horizontal", limit);
    }
    if (!found && !sampler.model.is_beads()) {
      found = find_problem(sampler.model, e.lattice);
      found = in_table(found && found->key == "columns" ? "lattice" : "model", found);
    }
    if (!found) continue;
    if (e.scan.values.empty()) return found->key == "mu" ? problem("friction.mu", "{}", found->message) : found;
    return problem("scan.values", "with {} = {} no pile can be drawn: {}", scanned.name, value, found->message);
  }
  if (beads) return {};
  if (e.force_chains.friction || !e.pictures.empty()) {
    return problem(e.force_chains.friction ? "scenes.friction.show" : std::string(pictures_table),
                   "the model {} has no contacts of beads, of which alone this picture is; leave it out",
                   name_of(e.sampling.model.name));
  }
  return {};
}

/// What of the main ensembles makes no sense; their parts have been looked at.
Problem find_ensemble_problem(const Experiment& e) {
  for (const double value : e.scan_values()) {
    EnsembleSpec spec = e.main_ensemble(value);
    spec.response.samples = std::max<std::uint64_t>(spec.response.samples, group_size);
    const Problem found = find_problem(spec);
    if (!found) continue;
    // The layers of the window are lags of the estimator fluctuation.
    const bool of_lattice = found->key == "layers" || found->key == "angle";
    const char* const table = of_lattice                                            ? "lattice."
                              : found->key == "mu"                                  ? "friction."
                              : found->key == "load_angle" || found->key == "drawn" ? "sampling."
                                                                                    : "response.";
    return problem(table + found->key, "{}", found->message);
  }
  return {};
}

/// A pile that the experiment's law would never complete; `whose` says where its size stands.
Problem find_law_problem(const Experiment& e, const char* whose, int columns, int layers, double mu) {
  const bool rejection = e.sampling.law == Law::rejection;
  const double most = rejection ? most_beads_by_rejection : static_cast<double>(most_polytope_beads);
  if (mu == 0 || (!rejection && e.sampling.law != Law::polytope) || 1.0 * columns * layers <= most) return {};
  return problem("sampling.law",
                 "the work of the law {} grows much faster than the number of beads, so that with the {} x {} beads of "
                 "{} it would never finish; use granusolve, or at most {} beads",
                 name_of(e.sampling.law), columns, layers, whose, most);
}

/// Before the sizes, which cannot be mended then.
Problem find_rejection_problem(const Experiment& e) {
  if (e.sampling.law == Law::rejection && e.sampling.model.has_contacts() && !e.mu.empty() && e.mu.back() > 0) {
    return problem(
        "sampling.law",
        "the law rejection completes at most {} beads, and a response needs more; take granusolve, or polytope, which "
        "draws the same law on at most {} beads, or look at small piles with granuscope sample",
        most_beads_by_rejection, most_polytope_beads);
  }
  return {};
}

Problem find_sampling_problem(const Experiment& e) {
  SamplerSpec sampler = e.sampling;
  if (!e.mu.empty()) sampler.mu = e.mu.front();
  if (auto found = in_table("sampling", find_problem(sampler))) return found;
  if (!e.sampling.model.is_beads() && e.sampling.law != SamplerSpec{}.law) {
    return problem("sampling.law", "the model {} has a law of its own; leave this out", name_of(e.sampling.model.name));
  }
  if (!e.sampling.model.has_contacts()) return {};
  if (auto found = find_law_problem(e, "[lattice]", e.lattice.columns, e.lattice.layers, e.mu.back())) return found;
  if (!e.force_chains.show) return {};
  return find_law_problem(e, "scenes.force_chains, some of them computed below the layers shown,",
                          e.force_chains.columns, e.force_chains.computed_layers(), e.force_chains.mu);
}

/// What is given of a model that the piles are not of.
std::vector<KeyProblem> find_model_problems(const Experiment& e) {
  std::string own = "model." + name_of(e.sampling.model.name);
  std::ranges::replace(own, '-', '_');
  const Experiment usual;
  const std::vector<Key> keys = keys_to_read(e);
  std::vector<KeyProblem> problems;
  for (const Key& key : keys_to_read(usual)) {
    if (!key.table.starts_with("model.") || key.table == own) continue;
    if (std::ranges::find(keys, key.path(), &Key::path)->get() == key.get()) continue;
    problems.push_back(
        {key.path(), fmt::format("it would change nothing under model.name = \"{}\"; leave it out, or give the "
                                 "model that has it",
                                 name_of(e.sampling.model.name))});
  }
  return problems;
}

/// In experiments every block holds a whole group, also the last one.
Problem find_block_problem(const Experiment& e) {
  const auto least = group_size * static_cast<std::uint64_t>(e.response.blocks);
  if (e.response.samples >= least) return {};
  return problem("response.samples",
                 "{} in {} blocks: each block needs a whole group of eight, which share "
                 "the start and direction of their layers; give {} to {}, or fewer blocks",
                 how_many(e.response.samples, "sample"), e.response.blocks, least, most_samples);
}

Problem find_response_problem(const Experiment& e) {
  ResponseSpec filled = e.response;
  filled.samples = std::max(filled.samples, group_size * static_cast<std::uint64_t>(e.response.blocks));
  if (auto found = in_table("response", find_problem(filled, e.lattice))) return found;
  return in_table("response", find_gravity_problem(e.sampling, e.response));
}

Problem find_precision_problem(const Experiment& e) {
  const PrecisionSpec& asked = e.precision;
  if (!asked.asked()) return {};
  if (asked.most_samples < e.response.samples || asked.most_samples > most_samples) {
    return problem("precision.most_samples",
                   "{} piles: the ensembles begin with response.samples = {} and grow from there; give {} to {}",
                   asked.most_samples, e.response.samples, e.response.samples, most_samples);
  }
  return {};
}

std::vector<KeyProblem> find_figure_problems(const Experiment& e) {
  const FigureSpec& figures = e.figures;
  std::vector<KeyProblem> problems;
  if (!figures.response_profiles) return problems;
  const int last_usable = e.lattice.layers - bottom_margin_of(e.sampling.model) - 1;
  const bool of_friction = &e.scanned() == &friction_parameter();
  if (of_friction && std::find(e.mu.begin(), e.mu.end(), figures.profile_mu) == e.mu.end()) {
    problems.push_back(
        {"figures.response_profiles.mu",
         fmt::format("{} is not one of friction.mu = [{}], so that there is no response to plot; choose one of them "
                     "or set figures.response_profiles.show = false",
                     figures.profile_mu, fmt::join(e.mu, ", "))});
  }
  const char* const layers = "figures.response_profiles.layers";
  if (figures.profile_layers.empty() || figures.profile_layers.size() > 8) {
    problems.push_back(
        {layers, fmt::format("{} layers cannot be shown in one figure; give 1 to 8", figures.profile_layers.size())});
  }
  for (const int layer : figures.profile_layers) {
    if (layer <= last_usable) continue;
    problems.push_back(
        {layers,
         fmt::format(
             "layer {} is not usable: with lattice.layers = {} the usable ones are 0 to {}; choose among them or "
             "compute {} layers",
             layer, e.lattice.layers, last_usable, std::int64_t{layer} + e.lattice.layers - last_usable)});
  }
  return problems;
}

// The two peaks run apart on either side and would meet again behind the ring. Up to c0 they stay clear of each other
// by four widths each; where friction makes them faster, by two each: the fit knows their images on the ring, but not
// which of two that coincide is which.
Problem find_ring_problem(const Experiment& e) {
  int deepest = e.fit.last_layer;
  if (e.figures.response_profiles) deepest = std::max(deepest, e.figures.profile_layers.back());
  const SamplerSpec widest = like_at_30(e.sampler_at(e.scan_values().back()), e.lattice.angle);
  const auto needed = [&](int layer) { return columns_needed(widest, layer); };
  if (e.lattice.columns > needed(deepest)) return {};
  int layer = deepest;
  while (layer > 0 && e.lattice.columns <= needed(layer - 1)) --layer;
  const bool by_figure = deepest > e.fit.last_layer;
  const int shallowest = e.fit.first_layer + (least_window_depths - 1) * e.fit.layer_step;
  return problem("lattice.columns",
                 "with {} columns the two peaks of the response at {} = {} meet behind the ring from "
                 "layer {} on, but layer {} is used ({}), and the fit would take one for the other; give more than {} "
                 "columns{}",
                 e.lattice.columns, e.scanned().name, e.scan_values().back(), layer, deepest,
                 by_figure ? "figures.response_profiles.layers" : "fit.last_layer", std::floor(needed(deepest)),
                 layer > (by_figure ? 0 : shallowest) ? fmt::format(" or stop at layer {}", layer - 1) : "");
}

Problem find_scene_problem(const Experiment& e) {
  const ForceChainSpec& chains = e.force_chains;
  if (!chains.show) return {};
  const bool beads = e.sampling.model.has_contacts();
  if (auto found = find_lattice_problem(
          "scenes.force_chains.columns", chains.columns, "scenes.force_chains.layers", chains.layers, 1,
          pile_memory(chains.columns, static_cast<double>(chains.layers) + bottom_margin))) {
    return found;
  }
  if (chains.friction && !(chains.mu > 0)) {
    return problem(
        "scenes.friction.show",
        "without friction, as scenes.force_chains.mu = 0 says, there is none to be mobilised; write false, or "
        "a mu above 0");
  }
  if (auto found = find_problem(e.sampling.model, {chains.columns, chains.computed_layers()})) {
    return problem("scenes.force_chains.columns", "{}", found->message);
  }
  // What the picture itself refuses, hours before it would be rendered.
  try {
    const ColourScale scale(Palette::builtin(), chains.scene.colour_map);
  } catch (const InputError& error) {
    return problem("scenes.force_chains.colour_map", "{}", error.what());
  }
  try {
    const Lattice lattice({chains.columns, chains.layers, e.lattice.angle});
    const double half = lattice.half_width();
    const Extent extent{-half, half, 0, lattice.z(chains.layers - 1) + 0.5};
    std::vector<std::string> titles;
    if (beads) titles.push_back(key_title_of("forces"));
    if (chains.weight) titles.push_back(key_title_of("weight"));
    if (chains.friction) titles.push_back(key_title_of("friction"));
    if (chains.response && e.sampling.model.is_beads()) titles.push_back(key_title_of("response"));
    plot_size(chains.scene_beside(), extent, titles);  // the narrower ones: one message for all
    plot_size(chains.scene, extent, titles);
  } catch (const InputError& error) {
    return problem("scenes.force_chains.width_px", "{}", error.what());
  }
  return {};
}

Problem find_picture_problem(const Experiment& e, const std::string& name, const PictureSpec& picture) {
  const std::string table = fmt::format("{}.{}", pictures_table, name);
  if (name.size() > 60 || !is_plain(name, "-_")) {
    return KeyProblem{table,
                      "the name of a picture becomes that of a file; write up to 60 letters, digits, - "
                      "and _"};
  }
  if (!e.force_chains.show) {
    return KeyProblem{table,
                      "there is no pile to render it of, because scenes.force_chains.show is false; write "
                      "true there, or leave this table out"};
  }
  try {
    check_drawable(Lattice({e.force_chains.columns, e.force_chains.computed_layers(), e.lattice.angle}),
                   e.force_chains.mu, picture.scene_like(e.force_chains, e.lattice.angle));
  } catch (const InputError& error) {
    return KeyProblem{table, error.what()};
  }
  return {};
}

/// What other angles than 30 degrees do not go with, beside what their ensembles do not.
Problem find_angle_problem(const Experiment& e) {
  if (e.lattice.angle == usual_angle) return {};
  for (const auto& study : e.studies) {
    if (!study->asked() || study->suits_any_angle()) continue;
    return problem("studies." + study->id(),
                   "this study is made for contacts at 30 degrees, and lattice.angle = {}; leave the study out, or the "
                   "angle at 30",
                   e.lattice.angle);
  }
  const double limit = BeadGeometry(e.lattice.angle).cotangent;
  if (!e.force_chains.show || e.force_chains.mu < limit) return {};
  return problem("scenes.force_chains.mu",
                 "{} with contacts at {} degrees, where friction stays below {:.4g}; give less", e.force_chains.mu,
                 e.lattice.angle, limit);
}

/// Rules across keys of a study, if it is asked for.
Problem find_study_problem(const Experiment& e, const Study& study) {
  if (!study.asked()) return {};
  if (auto found = study.find_problem(e)) return found;
  for (const StudyEnsemble& one : study.ensembles(e)) {
    if (const auto found = find_problem(one.spec)) {
      return problem("studies." + study.id(), "its ensemble \"{}\" cannot be drawn: {}: {}", one.label, found->key,
                     found->message);
    }
  }
  return {};
}

Problem find_about_problem(const Experiment& e) {
  if (e.report.about.empty()) return {};
  bool measured = false;
  std::vector<std::string> tell;  // of those that are measured
  for (const auto& study : e.studies) {
    if (!study->asked()) continue;
    measured = measured || study->id() == e.report.about;
    if (has_template(fmt::format("studies/{}.page_1.html", study->id()))) tell.push_back(study->id());
  }
  if (std::ranges::count(tell, e.report.about) > 0) return {};
  return problem("report.about", "\"{}\" {}, so that page 1 would have nothing to tell; {}", e.report.about,
                 measured ? "has a table and no sentence for page 1" : "is no study of this experiment",
                 tell.empty() ? "leave this empty: no study of it tells anything there"
                              : fmt::format("write one of {}, or leave it empty", fmt::join(tell, ", ")));
}

/// A figure that the program does not know. One that it knows and this run does not make is told in the report.
Problem find_key_figure_problem(const Experiment& e) {
  if (e.report.key_figure.empty()) return {};
  // Where the id is not the name of the captions; "": that of none.
  const std::map<std::string, std::string> other = {
      {"weight", "bead-weights"},         {"law-thrust", "law-comparison"},
      {"response", "pile-response"},      {"free", ""},
      {"friction", "mobilised-friction"}, {"model-pile", ""}};
  std::vector<std::string> known;
  for (const EmbeddedFile& file : embedded_files()) {
    const std::filesystem::path path(file.name);
    const auto folder = path.parent_path();
    if (path.extension() != ".captions" || (folder != "plot" && folder != "pictures" && folder != "studies")) continue;
    std::string id = path.stem().string();
    std::ranges::replace(id, '_', '-');
    if (const auto found = other.find(id); found != other.end()) id = found->second;
    if (!id.empty()) known.push_back(id);
  }
  for (const auto& [name, picture] : e.pictures) known.push_back("picture-" + name);
  if (std::ranges::count(known, e.report.key_figure) > 0 || e.report.key_figure.starts_with("pile-of-")) return {};
  const auto meant = nearest_name(e.report.key_figure, known);
  return problem("report.key_figure", "there is no figure \"{}\", so that page 1 would have none; {}",
                 e.report.key_figure,
                 meant ? fmt::format("did you mean {}?", *meant) : fmt::format("known are {}", fmt::join(known, ", ")));
}

std::vector<KeyProblem> find_gate_problems(const Experiment& e) {
  std::vector<KeyProblem> problems;
  std::vector<std::string> known = claim_ids();
  for (const auto& study : e.studies) {
    for (const Claim& claim : study->claims(e.claims)) known.push_back(claim.id);
  }
  for (const auto& [claim, verdict] : e.expected_verdicts) {
    if (std::find(known.begin(), known.end(), claim) == known.end()) {
      const auto meant = nearest_name(claim, known);
      problems.push_back({"gate.expect." + claim,
                          fmt::format("nothing that is asked for tests such a claim; leave the line out, or {}",
                                      meant ? fmt::format("did you mean {}?", *meant)
                                            : fmt::format("name one of {}", fmt::join(known, ", ")))});
    } else if (std::find(all_verdicts.begin(), all_verdicts.end(), verdict) == all_verdicts.end()) {
      problems.push_back({"gate.expect." + claim, fmt::format("\"{}\" is not a verdict; write one of {}", verdict,
                                                              fmt::join(all_verdicts, ", "))});
    }
  }
  return problems;
}

}  // namespace

double estimate_memory(const Experiment& e) {
  double pile =
      std::max(pile_memory(e.lattice.columns, e.lattice.layers),
               pile_memory(e.force_chains.columns, static_cast<double>(e.force_chains.layers) + bottom_margin));
  for (const StudyEnsemble& one : e.studies.ensembles(e)) {
    pile = std::max(pile, pile_memory(one.spec.lattice.columns, one.spec.lattice.layers));
  }
  for (const auto& study : e.studies) {
    if (study->asked()) pile = std::max(pile, study->memory());
  }
  return pile + sums_memory(e);
}

namespace {

/// Problems in the order in which they are looked for; of each key the first.
class KeyProblems {
 public:
  /// Whether there was none.
  bool add(Problem found) {
    if (!found) return true;
    const bool known = std::ranges::any_of(all, [&](const KeyProblem& one) { return one.key == found->key; });
    if (!known) all.push_back(std::move(*found));
    return false;
  }
  /// The ranges of all keys of one table, or of those of all tables ("").
  bool add_ranges(const Experiment& e, const std::string& table = "") {
    bool good = true;
    for (const Key& key : keys_to_read(e)) {
      if (table.empty() || key.table == table) good = add(granuscope::find_range_problem(key)) && good;
    }
    return good;
  }

  std::vector<KeyProblem> all;
};

Problem find_size_problem(const Experiment& e) {
  if (e.lattice.columns < fewest_columns) {
    return problem("lattice.columns",
                   "{} too few for two peaks; leave this out: as many as the window needs are taken then",
                   how_many(e.lattice.columns, "column is", "columns are"));
  }
  return find_lattice_problem("lattice.columns", e.lattice.columns, "lattice.layers", e.lattice.layers,
                              bottom_margin_of(e.sampling.model) + 4,
                              pile_memory(e.lattice.columns, e.lattice.layers) + sums_memory(e));
}

}  // namespace

std::vector<KeyProblem> find_value_problems(const Experiment& e) {
  KeyProblems problems;
  problems.add(find_size_problem(e));
  problems.add_ranges(e);
  return problems.all;
}

std::vector<KeyProblem> find_problems(const Experiment& e) {
  KeyProblems problems;
  problems.add(find_text_problem(e));
  if (!problems.add(find_rejection_problem(e))) return problems.all;
  const bool sized = problems.add(find_size_problem(e));
  bool good = problems.add_ranges(e, "friction") && sized;
  good = problems.add_ranges(e, "scan") && good;
  // Where a room knows its limits, it says best what is wrong; then what is left.
  if (good) {
    for (const auto find : {find_sampling_problem, find_response_problem, find_scan_problem})
      good = problems.add(find(e)) && good;
  }
  if (sized)
    good = problems.add(in_table("fit", find_problem(e.fit, e.lattice, bottom_margin_of(e.sampling.model)))) && good;
  if (!problems.add_ranges(e) || !sized) return problems.all;
  good = problems.add(find_block_problem(e)) && good;
  bool shown = problems.add(find_parameter_problem(e));
  if (shown) {
    for (KeyProblem& one : find_figure_problems(e)) shown = problems.add(std::move(one)) && shown;
  }
  if (good && shown) good = problems.add(find_ensemble_problem(e));  // it records the layers of figures
  if (good) good = problems.add(find_angle_problem(e));
  problems.add(find_precision_problem(e));
  if (good) {
    for (const auto& study : e.studies) problems.add(find_study_problem(e, *study));
    if (shown) problems.add(find_ring_problem(e));
  }
  problems.add(find_scene_problem(e));
  for (const auto& [name, picture] : e.pictures) problems.add(find_picture_problem(e, name, picture));
  for (KeyProblem& one : find_model_problems(e)) problems.add(std::move(one));
  problems.add(find_about_problem(e));
  problems.add(find_key_figure_problem(e));
  for (KeyProblem& one : find_gate_problems(e)) problems.add(std::move(one));
  return problems.all;
}

std::string note_of_idle_keys(const Experiment& e) {
  if (e.sampling.model.has_contacts() || std::ranges::any_of(e.studies, [](const auto& one) { return one->asked(); }))
    return {};
  const Experiment usual;
  const std::vector<Key> keys = keys_to_read(e);
  std::vector<std::string> idle;
  for (const char* path : {"friction.mu", "sampling.drawn", "sampling.effort", "sampling.layer_order",
                           "sampling.max_tries", "scenes.force_chains.mu"}) {
    const auto value_in = [&](const std::vector<Key>& of) { return std::ranges::find(of, path, &Key::path)->get(); };
    if (value_in(keys) != value_in(keys_to_read(usual))) idle.emplace_back(path);
  }
  if (idle.empty()) return {};
  return fmt::format("Without effect under model.name = \"{}\", whose piles have no contacts of beads: {}.",
                     name_of(e.sampling.model.name), fmt::join(idle, ", "));
}

std::string note_of_short_window(const Experiment& e) {
  const SamplerSpec widest = like_at_30(e.sampler_at(e.scan_values().back()), e.lattice.angle);
  const int last = e.fit.last_layer, usable = e.lattice.layers - bottom_margin_of(e.sampling.model) - 1;
  if (last < usable && e.lattice.columns <= columns_needed(widest, last + 1)) {
    return fmt::format(
        "The window of the fit ends at layer {} of {}: further down the two peaks would meet behind the ring of {} "
        "columns, and {} would hold them all.",
        last, usable, e.lattice.columns, std::floor(columns_needed(widest, usable)) + 1);
  }
  if (last >= shallow_response) return {};
  return fmt::format(
      "The window of the fit is layers {} to {}, where peaks are hardly wider than a bead, so that c and D may stay "
      "unknown: give more lattice.layers{}.",
      e.fit.first_layer, last,
      e.response.estimator == EstimatorName::fluctuation ? " or a smaller response.first_base" : "");
}

}  // namespace granuscope
