#include "ensemble/ensemble_spec.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <sstream>

#include "ensemble/estimator.h"
#include "sampling/polytope.h"
#include "sampling/random_key.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr Names<Load, 2> load_names{{{Load::uniform, "uniform"}, {Load::point, "point"}}};
constexpr Names<EstimatorName, 4> estimator_names{{{EstimatorName::point, "point"},
                                                   {EstimatorName::paired, "paired"},
                                                   {EstimatorName::multiplexed, "multiplexed"},
                                                   {EstimatorName::fluctuation, "fluctuation"}}};

}  // namespace

std::string name_of(Load load) { return name_in(load_names, load); }
Load load_named(const std::string& name) { return named_in(load_names, name, "load"); }
std::string name_of(EstimatorName estimator) { return name_in(estimator_names, estimator); }
EstimatorName estimator_named(const std::string& name) { return named_in(estimator_names, name, "estimator"); }

std::vector<Key> keys_of(ResponseSpec& spec) {
  const std::string table = "response", estimator = "estimator", multiplexed = name_of(EstimatorName::multiplexed),
                    fluctuation = name_of(EstimatorName::fluctuation);
  const std::vector<std::string> point = {name_of(EstimatorName::point)};
  const std::vector<std::string> loaded = {name_of(EstimatorName::point), name_of(EstimatorName::paired)};
  return {
      make_name_key(table, estimator,
                    "point: overloaded piles minus the uniform load; paired: each pile solved with and without the "
                    "overload, keeping its random numbers; multiplexed: all top loads varied at random, the linear "
                    "response by correlation; fluctuation: no load, the linear response from how fluctuations travel "
                    "down (needs deeper piles)",
                    spec.estimator, estimator_named),
      make_key(
          table, "overload", "loads of one top bead", "extra force on the middle top bead (point, paired)",
          spec.overload,
          KeyRange{.why =
                       "the response is divided by the overload, and the load of its neighbours is 1 (the paper has 1)"}
              .within(1e-6, 1e6))
          .only_under(estimator, loaded, Elsewhere::ignored),
      make_key(table, "overloads", "",
               "point: so many top beads carry the overload, evenly spaced; 0: as many as stand far enough apart",
               spec.overloads, KeyRange{}.within(0, most_overloads))
          .only_under(estimator, point),
      make_key(table, "coupled", "",
               "point: the eight piles of a group share their random numbers, and what they share is taken off; their "
               "overloads stand on different beads. The same expectation, from fewer piles",
               spec.coupled)
          .only_under(estimator, point),
      make_key(table, "epsilon", "loads of one top bead",
               "by how much each top load is raised or lowered (multiplexed)", spec.epsilon,
               KeyRange{.why = "some top beads carry 1 - epsilon, and one without load has no solution beside loaded "
                               "ones at small friction, while the response is divided by epsilon (0.25 is usual)"}
                   .within(least_epsilon, epsilon_limit)
                   .below(epsilon_limit))
          .only_under(estimator, {multiplexed}, Elsewhere::ignored),
      make_key(table, "opposite", "",
               "multiplexed: draw each pile once more with all variations reversed, from the same random numbers, and "
               "take half the difference; twice the work, and worth it at small epsilon or mu",
               spec.opposite)
          .only_under(estimator, {multiplexed}),
      make_key(table, "sign_run", "beads",
               "multiplexed: so many neighbouring top beads, or one more, are raised or lowered together (1: each by "
               "itself); 2 or 3 measure peaks wider than a bead better",
               spec.sign_run, KeyRange{.least = 1})
          .only_under(estimator, {multiplexed}),
      make_key(
          table, "reference_lag", "layers",
          "fluctuation: layers from a base layer down to the reference layer, from which the deeper ones are followed",
          spec.reference_lag, KeyRange{.why = "24 is usual, fewer than 12 are biased"}.within(0, most_reference_lag))
          .only_under(estimator, {fluctuation}, Elsewhere::left_out),
      make_key(table, "first_base", "layer",
               "fluctuation: shallowest base layer; 0: where fluctuations are saturated, 0.6/mu^2, at least 60 and at "
               "most 2000, or of three legs that push twice the deepest lag",
               spec.first_base, KeyRange{}.within(0, most_first_base))
          .only_under(estimator, {fluctuation}, Elsewhere::left_out),
      make_key(table, "base_step", "layers", "fluctuation: distance of the base layers", spec.base_step,
               KeyRange{.why = "6 is usual"}.within(1, most_base_step))
          .only_under(estimator, {fluctuation}, Elsewhere::left_out),
      make_key(table, "samples", "piles", "piles per friction coefficient, at least eight per block", spec.samples,
               KeyRange{}.within(group_size * min_blocks, most_samples)),
      make_key(
          table, "blocks", "blocks", "blocks of the jackknife, each of whole groups of eight piles", spec.blocks,
          KeyRange{.why =
                       "fewer than 8 give no reliable standard error, and more than 10000 no better one (32 is usual)"}
              .within(min_blocks, most_blocks)),
  };
}

std::vector<Key> keys_of(EnsembleSpec& spec) {
  std::vector<Key> keys = keys_of(spec.sampler);
  // Behind the others, as the chain of the law polytope came later than they did.
  std::stable_partition(keys.begin(), keys.end(), [](const Key& key) {
    return key.only.names != std::vector<std::string>{name_of(Law::polytope)};
  });
  const auto behind_law = keys.begin() + 1;
  keys.insert(behind_law, make_key("friction", "mu", "", "friction coefficient, 0 <= mu < sqrt(3)", spec.sampler.mu));
  const auto append = [&](std::vector<Key> more) { std::move(more.begin(), more.end(), std::back_inserter(keys)); };
  append(keys_of(spec.lattice));
  append({make_name_key("response", "load", "uniform: 1 on every top bead; point: 1 + overload on the middle one",
                        spec.load, load_named)});
  append(keys_of(spec.response));
  return keys;
}

SampleRange samples_of(const EnsembleSpec& spec, std::uint64_t group) {
  const auto from = [&](std::uint64_t number) { return std::min(number * group_size, spec.response.samples); };
  return {from(group), from(group + 1)};
}

std::uint64_t groups_of(const EnsembleSpec& spec) {
  return spec.response.samples / group_size + (spec.response.samples % group_size != 0 ? 1 : 0);
}

std::uint64_t group_of_block(const EnsembleSpec& spec, int block, std::uint64_t from) {
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks), at = static_cast<std::uint64_t>(block);
  return from + (at + blocks - from % blocks) % blocks;
}

std::uint64_t samples_in_block(const EnsembleSpec& spec, int block, std::uint64_t groups) {
  const auto blocks = static_cast<std::uint64_t>(spec.response.blocks);
  std::uint64_t samples = 0;
  for (std::uint64_t group = group_of_block(spec, block, 0); group < groups; group += blocks)
    samples += samples_of(spec, group).size();
  return samples;
}

std::vector<int> recorded_layers(const EnsembleSpec& spec) {
  std::vector<int> layers = spec.layers;
  if (layers.empty()) {
    layers.resize(static_cast<std::size_t>(spec.lattice.layers));
    std::iota(layers.begin(), layers.end(), 0);
  } else if ((!loads_one_bead(spec.response.estimator) || moves_loads(spec)) && layers.front() != 0) {
    layers.insert(layers.begin(), 0);
  }
  return layers;
}

namespace {

Problem find_fluctuation_problem(const EnsembleSpec& spec) {
  if (auto found = find_gravity_problem(spec.sampler, spec.response)) return found;
  const FluctuationPlan plan = fluctuation_plan(spec);
  if (plan.lags.size() < 2) return problem("layers", "there is no lag to measure; name layers beside layer 0");
  if (!plan.bases.empty()) return {};
  constexpr int usual = 179;  // layers of response, those of 200 layers under loads
  const int unused = bottom_margin_of(spec.sampler.model), last = plan.lags.back();
  const int response = last < shallow_response ? usual : last, beside = plan.layers_needed - last;
  return problem("layers",
                 "{} too few for the estimator fluctuation: {} of saturated fluctuations, a reference of "
                 "{}, {} of response and {} at the bottom need {}; give so many, and {} more for each base beyond the "
                 "first one, or name a shallower first base by response.first_base",
                 how_many(spec.lattice.layers, "layer is", "layers are"), beside - plan.reference - unused - 1,
                 plan.reference, response, unused + 1, beside + response, spec.response.base_step);
}

constexpr double most_mu_of_several = 0.5;  ///< for which several overloads were held against one
constexpr int beyond_cone = 32;             ///< beads that repairs carry influence beyond it

/// The deepest layer in which a response is looked for.
int deepest_response(const EnsembleSpec& spec) {
  const int deepest = spec.lattice.layers - 1 - bottom_margin_of(spec.sampler.model);
  return std::clamp(spec.layers.empty() ? deepest : spec.layers.back(), 0, std::max(0, deepest));
}

/// Columns that each of several overloads needs for itself.
double columns_of_overload(const EnsembleSpec& spec) {
  const int deepest = deepest_response(spec), cone = deepest + 1;
  if (!spec.sampler.model.is_beads()) return std::max(1.0 * cone, columns_needed(like_at_30(spec), deepest));
  return std::max(cone + 2.0 * beyond_cone, columns_needed(like_at_30(spec), deepest));
}

bool may_have_several(const EnsembleSpec& spec) {
  return spec.sampler.law == Law::granusolve && like_at_30(spec).mu <= most_mu_of_several;
}

}  // namespace

double columns_of_overloads(const EnsembleSpec& spec) {
  const ResponseSpec& response = spec.response;
  if (!moves_loads(spec) || response.overloads <= 1 || !may_have_several(spec)) return 0;
  return response.overloads * std::ceil(columns_of_overload(spec));
}

namespace {

Problem find_overload_problem(const EnsembleSpec& spec) {
  const ResponseSpec& response = spec.response;
  if (response.coupled && spec.sampler.law == Law::polytope) {
    return problem("coupled", "a chain of the law polytope belongs to one load; leave coupled out");
  }
  if (!moves_loads(spec) || response.overloads <= 1) return {};
  if (spec.lattice.columns % response.overloads != 0) {
    return problem("overloads",
                   "{} overloads do not stand evenly on {} columns; give a divisor, or 0 for as many as fit",
                   response.overloads, spec.lattice.columns);
  }
  if (!may_have_several(spec)) {
    return problem("overloads",
                   "several overloads in a pile were held against one of the law granusolve up to mu = {} only; beyond "
                   "it influence goes around the ring; give 1, or 0 for as many as fit",
                   most_mu_of_several);
  }
  const double needed = columns_of_overloads(spec);
  if (spec.lattice.columns >= needed) return {};
  return problem("overloads",
                 "{} overloads on {} columns: down to layer {} they need {:.0f} columns, or their responses meet; give "
                 "0 for as many as fit, or lattice.columns = {:.0f}",
                 response.overloads, spec.lattice.columns, deepest_response(spec), needed, needed);
}

/// What of the estimators makes no sense with a model other than the beads.
Problem find_model_problem(const EnsembleSpec& spec) {
  const ModelSpec& model = spec.sampler.model;
  if (model.is_beads()) return {};
  if (auto found = find_problem(model, spec.lattice)) return found;
  const EstimatorName estimator = spec.response.estimator;
  if (estimator == EstimatorName::paired) {
    return problem(
        "estimator",
        "the estimator paired keeps the split of each bead, which the model {} does not have; choose another",
        name_of(model.name));
  }
  if (estimator == EstimatorName::fluctuation && model.has_contacts()) {
    return problem("estimator",
                   "the estimator fluctuation averages over layers of deep piles that are alike, while those of {} are "
                   "small and solved as a whole; choose point or multiplexed",
                   name_of(model.name));
  }
  return {};
}

}  // namespace

Problem find_gravity_problem(const SamplerSpec& sampler, const ResponseSpec& response) {
  if (sampler.bead_weight == 0 || response.estimator != EstimatorName::fluctuation) return {};
  return problem("estimator",
                 "the estimator fluctuation averages over layers that are alike, which those of beads of weight {} are "
                 "not: their mean weight grows with depth; choose point, paired or multiplexed",
                 sampler.bead_weight);
}

namespace {

/// What other angles than 30 degrees do not go with.
Problem find_angle_problem(const EnsembleSpec& spec) {
  const SamplerSpec& sampler = spec.sampler;
  const double angle = spec.lattice.angle, limit = BeadGeometry(angle).cotangent;
  if (angle == usual_angle) return {};
  if (!sampler.model.is_beads()) {
    return problem("angle", "the model {} is made for 30 degrees only; leave lattice.angle at that",
                   name_of(sampler.model.name));
  }
  if (sampler.load_angle != 0 || sampler.load_offset != 0) {
    return problem("load_angle",
                   "loads that lean or act beside the centres have their limits at 30 degrees only; leave load_angle "
                   "and load_offset at 0, or lattice.angle at 30");
  }
  if (sampler.drawn != DrawnVariable::force) {
    return problem("drawn", "what else than a force is drawn is known at 30 degrees only; leave it at force");
  }
  if (sampler.mu < limit) return {};
  return problem("mu",
                 "mu = {} with contacts at {} degrees: at 1/tan(angle) = {:.4g} the cone of admissible forces reaches "
                 "the horizontal; give less",
                 sampler.mu, angle, limit);
}

}  // namespace

Problem find_problem(const EnsembleSpec& spec) {
  if (auto found = find_problem(spec.lattice)) return found;
  if (auto found = find_angle_problem(spec)) return found;
  if (auto found = find_problem(spec.sampler)) return found;
  if (auto found = find_problem(spec.response, spec.lattice)) return found;
  if (auto found = find_model_problem(spec)) return found;
  if (auto found = find_overload_problem(spec)) return found;
  const EstimatorName estimator = spec.response.estimator;
  if (estimator != EstimatorName::point && spec.load != Load::point) {
    return problem("load", "the estimator {} brings its own loads; leave the load at point", name_of(estimator));
  }
  if (spec.record_H && (estimator != EstimatorName::multiplexed || is_scalar(spec.sampler.model))) {
    return problem("record_H", "the response of H is recorded by the estimator multiplexed, of models that have an H");
  }
  if (spec.record_forces && (estimator != EstimatorName::point || spec.load != Load::uniform)) {
    return problem("record_forces", "forces are counted by the estimator point, of piles under a uniform load");
  }
  if (std::adjacent_find(spec.layers.begin(), spec.layers.end(), std::greater_equal<>()) != spec.layers.end()) {
    return problem("layers", "the recorded layers are not ascending: each may be named once, from the top down");
  }
  for (const int layer : spec.layers) {
    if (layer < 0 || layer >= spec.lattice.layers) {
      return problem("layers", "layer {} is outside the lattice of {} layers (0 to {})", layer, spec.lattice.layers,
                     spec.lattice.layers - 1);
    }
  }
  if (estimator == EstimatorName::fluctuation) return find_fluctuation_problem(spec);
  return {};
}

void validate(const EnsembleSpec& spec) { refuse(find_problem(spec)); }

namespace {

/// Of loads and beads that most ensembles do not have: left out where it is 0.
bool is_tilt(const Key& key) {
  return key.name == "load_angle" || key.name == "load_offset" || key.name == "bead_weight";
}

bool is_of_moved_loads(const Key& key) { return key.name == "overloads" || key.name == "coupled"; }

/// Counted up when the sums of an estimator came to hold more.
std::string versions_of_sums(const EnsembleSpec& spec) {
  return std::string(spec.response.estimator == EstimatorName::paired ? "paired_sums=4\n" : "") +
         (spec.record_H ? "multiplexed_sums=2\n" : "") + (spec.record_forces ? "force_counts=1\n" : "") +
         (is_flat(spec.sampler) ? "flat_tests=1\n" : "");
}

}  // namespace

std::string configuration_text(const EnsembleSpec& spec) {
  EnsembleSpec copy = spec;  // keys could set what they print
  copy.response.overloads = overloads_of(spec);
  const std::vector<Key> keys = keys_of(copy);
  std::string text = fmt::format("sampling_version={}\n{}", sampling_version, configuration_text(spec.sampler.model));
  for (const Key& key : keys) {
    const bool counting = counts(key, keys) && !(key.name == "overload" && spec.load != Load::point);
    if (!counting && key.only.elsewhere == Elsewhere::left_out) continue;
    if (is_tilt(key) && std::get<double>(key.get()) == 0) continue;
    if (key.name == "lean_excess" && !spec.sampler.lean_excess) continue;
    if (key.name == "drawn" && spec.sampler.drawn == DrawnVariable::force) continue;
    if (key.name == "angle" && spec.lattice.angle == usual_angle) continue;
    if (is_of_moved_loads(key) && !moves_loads(spec)) continue;
    if (key.name == "samples") text += versions_of_sums(spec);
    // What an estimator ignores changes no number.
    text += fmt::format("{}={}\n", key.name, !counting && key.only.elsewhere == Elsewhere::ignored ? "0" : key.text());
  }
  return text +
         fmt::format("recorded_layers={}\nprofiles={}\n", fmt::join(recorded_layers(spec), ","), spec.record_profiles);
}

EnsembleSpec ensemble_configured(const std::string& configuration) {
  EnsembleSpec spec;
  const std::vector<Key> keys = keys_of(spec);
  for (std::size_t at = 0, end = 0; (end = configuration.find('\n', at)) != std::string::npos; at = end + 1) {
    const std::size_t equals = std::min(configuration.find('=', at), end);
    const std::string name = configuration.substr(at, equals - at);
    const std::string value = equals == end ? "" : configuration.substr(equals + 1, end - equals - 1);
    try {
      if (read_configuration(spec.sampler.model, name, value)) continue;
      if (const Key* key = find_key(keys, name)) {
        if (key->only.elsewhere != Elsewhere::ignored || counts(*key, keys)) key->read(value);
      } else if (name == "recorded_layers") {
        std::istringstream numbers(value);
        for (std::string layer; std::getline(numbers, layer, ',');)
          key_fields::from_text(spec.layers.emplace_back(), layer);
      } else if (name == "profiles") {
        key_fields::from_text(spec.record_profiles, value);
      } else if (name == "multiplexed_sums") {
        spec.record_H = true;
      } else if (name == "force_counts") {
        spec.record_forces = true;
      }
    } catch (const InputError& error) {
      throw InputError("{}: {}", name, error.what());
    }
  }
  return spec;
}

std::vector<double> top_load(const EnsembleSpec& spec, int bead) {
  const int columns = spec.lattice.columns, overloads = overloads_of(spec);
  std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
  if (spec.load != Load::point || !loads_one_bead(spec.response.estimator)) return load;
  for (int n = 0; n < overloads; ++n) {
    load[static_cast<std::size_t>((bead + n * (columns / overloads)) % columns)] += spec.response.overload;
  }
  return load;
}

std::vector<double> top_load(const EnsembleSpec& spec) { return top_load(spec, Lattice(spec.lattice).middle()); }

double expected_width(double mu, double z) { return std::sqrt(1 + 2.2 * std::pow(mu, 2.5) * z); }

double expected_speed(double mu) { return mu > 1 ? tan30 + 0.8 * std::pow(mu - 1, 2) : tan30; }

// Up to tan30 the peaks stay clear of each other by four widths each; where friction makes them faster, by two each:
// the fit knows their images on the ring, but not which of two that coincide is which.
double columns_needed(double mu, int layer) {
  const double z = Lattice::depth(layer), width = expected_width(mu, z);
  return std::max(2 * tan30 * z + 8 * width, 2 * expected_speed(mu) * z + 4 * width);
}

// Other models hand nothing on faster than c0, and are no wider than positive legs or the one peak of the q-model.
double columns_needed(const SamplerSpec& sampler, int layer) {
  if (sampler.model.has_contacts()) return columns_needed(sampler.mu, layer);
  constexpr double widest = 0.3;
  const double z = rows_of(sampler.model).depth(layer);
  return 2 * tan30 * z + 8 * std::sqrt(widest * z + 1);
}

SamplerSpec like_at_30(SamplerSpec sampler, double angle) {
  const BeadGeometry geometry(angle);
  if (sampler.mu >= 0 && sampler.mu < geometry.cotangent) sampler.mu = FrictionCone(sampler.mu, geometry).mu_at_30();
  return sampler;
}

int overloads_of(const EnsembleSpec& spec) {
  if (spec.response.estimator != EstimatorName::point) return 1;
  if (spec.response.overloads > 0) return spec.response.overloads;
  if (!may_have_several(spec)) return 1;
  const int columns = spec.lattice.columns;
  int overloads = std::clamp(static_cast<int>(columns / columns_of_overload(spec)), 1, most_overloads);
  while (columns % overloads != 0) --overloads;
  return overloads;
}

int response_columns(const EnsembleSpec& spec) { return spec.lattice.columns / overloads_of(spec); }

bool moves_loads(const EnsembleSpec& spec) {
  return spec.response.estimator == EstimatorName::point && spec.load == Load::point &&
         (spec.response.coupled || overloads_of(spec) > 1);
}

std::uint64_t numbers_of(const EnsembleSpec& spec, std::uint64_t sample) {
  return moves_loads(spec) && spec.response.coupled ? sample - sample % group_size : sample;
}

int overloaded_bead(const EnsembleSpec& spec, std::uint64_t sample) {
  if (!moves_loads(spec) || !spec.response.coupled) return Lattice(spec.lattice).middle();
  return RandomKey(spec.sampler.seed, sample).loaded_bead(response_columns(spec));
}

namespace {

/// " --load-angle=-3", " --opposite"; nothing for a switch that is off.
std::string flag_with_value(const Key& key) {
  const std::string value = key.text();
  if (std::holds_alternative<bool>(key.get())) return value == "true" ? " " + flag_of(key) : "";
  return fmt::format(" {}{}{}", flag_of(key), value.starts_with('-') ? "=" : " ", value);
}

}  // namespace

std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample) {
  constexpr std::array always = {"law", "mu", "columns", "layers", "seed"};
  constexpr std::array of_many = {"estimator", "samples", "blocks"};  // and not of one pile
  EnsembleSpec copy = spec, usual;                                    // keys could set what they print
  copy.response.overloads = overloads_of(spec);
  const std::vector<Key> keys = keys_of(copy), usual_keys = keys_of(usual), of_model = keys_of(copy.sampler.model);
  std::string command = "granuscope sample";
  if (!spec.sampler.model.is_beads()) {  // of the models whose piles can fail
    command += fmt::format(" --model {}", name_of(spec.sampler.model.name));
    for (const char* name : {"opened_share", "least_slack"}) command += flag_with_value(*find_key(of_model, name));
  }
  for (const Key& key : keys) {
    const auto one_of = [&](const auto& names) { return std::ranges::find(names, key.name) != names.end(); };
    if (key.name == "load") {
      command +=
          " --load " + (spec.response.estimator == EstimatorName::point         ? name_of(spec.load)
                        : spec.response.estimator == EstimatorName::fluctuation ? name_of(Load::uniform)
                                                                                : name_of(spec.response.estimator));
    }
    if (key.name == "load" || (key.name == "law" && !spec.sampler.model.is_beads()) || one_of(of_many)) continue;
    const bool idle = key.name == "overload" && spec.load == Load::uniform;
    const bool usual_value = idle || key.text() == find_key(usual_keys, key.name)->text();
    if (key.only.elsewhere == Elsewhere::left_out || !counts(key, keys) || (usual_value && !one_of(always))) continue;
    command += flag_with_value(key);
  }
  return command + fmt::format(" --sample {} --out pile.h5", sample);
}

int longest_run(const LatticeSpec& lattice) { return std::max(1, lattice.columns / 8); }

ResponseSpec on_ring(ResponseSpec spec, const LatticeSpec& lattice) {
  spec.sign_run = std::min(spec.sign_run, longest_run(lattice));
  return spec;
}

Problem find_problem(const ResponseSpec& spec, const LatticeSpec& lattice) {
  ResponseSpec copy = spec, usual;  // keys could set what they check
  const std::vector<Key> keys = keys_of(copy);
  if (auto found = find_idle_problem(keys, keys_of(usual))) return found;
  if (auto found = find_range_problem(keys, {"samples"})) return found;
  if (spec.sign_run > longest_run(lattice)) {
    return problem("sign_run",
                   "{} beads: a run has at least one, and where fewer than eight runs fit into a ring of {} columns "
                   "the long waves meet hardly any load that differs; give 1 to {} (1 to 3 is usual)",
                   spec.sign_run, lattice.columns, longest_run(lattice));
  }
  const std::uint64_t least = group_size * static_cast<std::uint64_t>(spec.blocks - 1) + 1;
  if (spec.samples > most_samples) {
    return problem("samples", "{} samples are too many; give {} to {}, or divide them among seeds", spec.samples, least,
                   most_samples);
  }
  if (spec.samples < least) {
    return problem("samples", "{} too few: each of the {} blocks needs at least one group of {}; give {} or more",
                   how_many(spec.samples, "sample is", "samples are"), spec.blocks, group_size, least);
  }
  return {};
}

}  // namespace granuscope
