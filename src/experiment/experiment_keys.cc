#include "experiment/experiment_keys.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "support/describe_bytes.h"
#include "support/error.h"

namespace granuscope {
namespace {

KeyValue to_value(bool field) { return field; }
KeyValue to_value(int field) { return std::int64_t{field}; }
KeyValue to_value(std::uint64_t field) { return static_cast<std::int64_t>(field); }
KeyValue to_value(double field) { return field; }
KeyValue to_value(const std::string& field) { return field; }
KeyValue to_value(const std::vector<double>& field) { return field; }
KeyValue to_value(const std::vector<int>& field) { return std::vector<std::int64_t>(field.begin(), field.end()); }
KeyValue to_value(const std::array<double, 2>& field) { return std::vector<double>(field.begin(), field.end()); }
KeyValue to_value(const NumberPairs& field) { return field; }
KeyValue to_value(Law field) { return name_of(field); }
KeyValue to_value(LayerOrder field) { return name_of(field); }
KeyValue to_value(MendingRules field) { return name_of(field); }
KeyValue to_value(EstimatorName field) { return name_of(field); }

int to_int(std::int64_t number) {
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max()) {
    constexpr double bytes_per_bead = 96;  // four forces, and what a solver keeps beside them
    throw InputError(
        fmt::format("{} is beyond what this key can hold ({} at most; so many beads in a row would need {} of memory); "
                    "give a smaller "
                    "number",
                    number, std::numeric_limits<int>::max(),
                    describe_bytes(bytes_per_bead * std::abs(static_cast<double>(number)))));
  }
  return static_cast<int>(number);
}

// The plain alternatives need no conversion.
template <class Field>
void from_value(Field& field, const KeyValue& value) {
  field = std::get<Field>(value);
}
void from_value(int& field, const KeyValue& value) { field = to_int(std::get<std::int64_t>(value)); }
void from_value(std::uint64_t& field, const KeyValue& value) {
  const auto number = std::get<std::int64_t>(value);
  if (number < 0) throw InputError(fmt::format("{} is negative; give 0 or more", number));
  field = static_cast<std::uint64_t>(number);
}
void from_value(std::vector<int>& field, const KeyValue& value) {
  std::vector<int> numbers;
  for (const auto number : std::get<std::vector<std::int64_t>>(value)) numbers.push_back(to_int(number));
  field = std::move(numbers);
}
void from_value(std::array<double, 2>& field, const KeyValue& value) {
  const auto& numbers = std::get<std::vector<double>>(value);
  if (numbers.size() != 2) {
    throw InputError(
        fmt::format("a window needs two ends but {} numbers are given; write [low, high]", numbers.size()));
  }
  field = {numbers[0], numbers[1]};
}
void from_value(Law& field, const KeyValue& value) { field = law_named(std::get<std::string>(value)); }
void from_value(LayerOrder& field, const KeyValue& value) { field = layer_order_named(std::get<std::string>(value)); }
void from_value(MendingRules& field, const KeyValue& value) {
  field = mending_rules_named(std::get<std::string>(value));
}
void from_value(EstimatorName& field, const KeyValue& value) { field = estimator_named(std::get<std::string>(value)); }

/// `access` returns a reference to the field of the experiment it is given, const or not.
template <class Access>
ExperimentKey key(std::string table, std::string name, std::string unit, std::string meaning, Access access) {
  return {std::move(table),
          std::move(name),
          std::move(unit),
          std::move(meaning),
          [access](const Experiment& experiment) { return to_value(access(experiment)); },
          [access](Experiment& experiment, const KeyValue& value) { from_value(access(experiment), value); }};
}

std::vector<ExperimentKey> make_keys() {
  const std::string lattice = "lattice";
  const std::string sampling = "sampling";
  const std::string response = "response";
  const std::string fit = "fit";
  const std::string claims = "claims";
  const std::string precision = "precision";
  const std::string profiles = "figures.response_profiles";
  const std::string redrawn = "figures.redrawn_beads";
  const std::string work = "figures.counted_work";
  const std::string small = "figures.small_friction";
  const std::string loads = "figures.nonlinearity";
  const std::string errors = "figures.error_against_time";
  const std::string chains = "scenes.force_chains";
  return {
      key(
          "experiment", "name", "", "title of the report, one line", [](auto& e) -> auto& { return e.name; }),
      key(
          "experiment", "description", "", "a paragraph for the reader of the report",
          [](auto& e) -> auto& { return e.description; }),

      key(
          lattice, "columns", "beads", "beads per layer, periodic in x; even or odd, at least 4",
          [](auto& e) -> auto& { return e.lattice.columns; }),
      key(
          lattice, "layers", "layers",
          "layers computed; the lowest 20 follow another law, since no failure below reaches up into them, and are not "
          "used",
          [](auto& e) -> auto& { return e.lattice.layers; }),

      key(
          "friction", "mu", "", "friction coefficients of the contacts, each at least 0 and below sqrt(3)",
          [](auto& e) -> auto& { return e.mu; }),

      key(
          sampling, "law", "",
          "what a random pile means: granusolve, polytope (small piles), or eloy-clement and rejection (tiny piles)",
          [](auto& e) -> auto& { return e.sampling.law; }),
      key(
          sampling, "seed", "", "together with the sample's number the key of every random number",
          [](auto& e) -> auto& { return e.sampling.seed; }),
      key(
          sampling, "effort", "solutions per bead",
          "granusolve, eloy-clement: a pile counts as failed, by name, after this many bead solutions per bead",
          [](auto& e) -> auto& { return e.sampling.effort; }),
      key(
          sampling, "max_tries", "piles", "rejection: a pile counts as failed, by name, after this many tries",
          [](auto& e) -> auto& { return e.sampling.max_tries; }),
      key(
          sampling, "lambda", "",
          "polytope: piles have the density of the product of length^-lambda over the intervals of all beads; 0 is the "
          "flat measure, 1 the law rejection",
          [](auto& e) -> auto& { return e.sampling.lambda; }),
      key(
          sampling, "burn_in", "sweeps",
          "polytope: from the start of a chain to the first of its eight piles; 0: four times the autocorrelation time "
          "that a pilot chain measures",
          [](auto& e) -> auto& { return e.sampling.burn_in; }),
      key(
          sampling, "thinning", "sweeps",
          "polytope: from one of the eight piles of a chain to the next; 0: half that time",
          [](auto& e) -> auto& { return e.sampling.thinning; }),
      key(
          sampling, "layer_order", "",
          "random start and direction in each layer, or fixed (breaks the mirror symmetry: for comparison only)",
          [](auto& e) -> auto& { return e.sampling.order; }),
      key(
          sampling, "mending_rules", "",
          "granusolve: all, or without some of the rules that mend a failing bead (no-pair, no-arcs, climb-only: other "
          "laws, for comparison only)",
          [](auto& e) -> auto& { return e.sampling.rules; }),

      key(
          response, "estimator", "",
          "point: overloaded piles minus the uniform load; paired: each pile solved with and without the overload, "
          "keeping its random numbers; multiplexed: all top loads varied at random, the linear response by correlation",
          [](auto& e) -> auto& { return e.response.estimator; }),
      key(
          response, "overload", "loads of one top bead", "extra force on the middle top bead (point, paired)",
          [](auto& e) -> auto& { return e.response.overload; }),
      key(
          response, "epsilon", "loads of one top bead",
          "by how much each top load is raised or lowered (multiplexed), above 0 and below 1",
          [](auto& e) -> auto& { return e.response.epsilon; }),
      key(
          response, "opposite", "",
          "multiplexed: draw each pile once more with all variations reversed, from the same random numbers, and take "
          "half the difference; twice the work, and worth it at small epsilon or mu",
          [](auto& e) -> auto& { return e.response.opposite; }),
      key(
          response, "sign_run", "beads",
          "multiplexed: so many neighbouring top beads, or one more, are raised or lowered together (1: each by "
          "itself); 2 or 3 measure peaks wider than a bead better",
          [](auto& e) -> auto& { return e.response.sign_run; }),
      key(
          response, "samples", "piles", "piles per friction coefficient, at least eight per block",
          [](auto& e) -> auto& { return e.response.samples; }),
      key(
          response, "blocks", "blocks", "blocks of the jackknife, each of whole groups of eight piles; at least 8",
          [](auto& e) -> auto& { return e.response.blocks; }),

      key(
          fit, "first_layer", "layer", "first layer of the window over which the slopes c and D are taken",
          [](auto& e) -> auto& { return e.fit.first_layer; }),
      key(
          fit, "last_layer", "layer", "last layer of that window, at most lattice.layers - 21",
          [](auto& e) -> auto& { return e.fit.last_layer; }),
      key(
          fit, "layer_step", "layers", "distance of the fitted layers; an odd one alternates the two kinds of rows",
          [](auto& e) -> auto& { return e.fit.layer_step; }),
      key(
          fit, "shallow_layer", "layer", "from here down to the window layers are fitted for the figures only",
          [](auto& e) -> auto& { return e.fit.shallow_layer; }),
      key(
          fit, "min_identifiable_width", "bead diameters", "below it the size of a bead hides the width of a peak",
          [](auto& e) -> auto& { return e.fit.min_identifiable_width; }),
      key(
          fit, "scaling_window", "", "range of mu, both ends included, of the exponents beta, gamma and alpha",
          [](auto& e) -> auto& { return e.fit.scaling_window; }),
      key(
          fit, "other_scaling_windows", "", "further ranges of mu whose exponents are shown beside it",
          [](auto& e) -> auto& { return e.fit.other_scaling_windows; }),

      key(
          precision, "c", "",
          "standard error of the slope c down to which response.samples is multiplied by 3/2 again and again, at each "
          "mu; "
          "0: not asked for",
          [](auto& e) -> auto& { return e.precision.c; }),
      key(
          precision, "D", "bead diameters", "the same for the slope D; both together: until both are reached",
          [](auto& e) -> auto& { return e.precision.D; }),
      key(
          precision, "most_samples", "piles", "per friction coefficient, beyond which it is given up and reported",
          [](auto& e) -> auto& { return e.precision.most_samples; }),

      key(
          claims, "decisive_chi2", "",
          "double-peak: difference in chi squared that decides between two peaks and one (25: five standard "
          "deviations)",
          [](auto& e) -> auto& { return e.claims.decisive_chi2; }),
      key(
          claims, "highest_mu", "",
          "double-peak, linear-time: friction that friction.mu, or the counted work, must reach for a claim up to 1.7",
          [](auto& e) -> auto& { return e.claims.highest_mu; }),
      key(
          claims, "exponent_tolerance", "",
          "laws in z, N and the number of beads: standard error granted to their exponents for the finite range",
          [](auto& e) -> auto& { return e.claims.exponent_tolerance; }),
      key(
          claims, "chain_share", "", "force-chains: share of the response that the two rays must carry",
          [](auto& e) -> auto& { return e.claims.chain_share; }),

      key(
          "figures.bead_forces", "draw", "",
          "draw one bead of the force-chain pile with its contacts and cones, at figures.response_profiles.mu (Fig. 1)",
          [](auto& e) -> auto& { return e.figures.bead_forces; }),
      key(
          profiles, "draw", "", "draw the response at a few layers with its fits (the paper's Fig. 2)",
          [](auto& e) -> auto& { return e.figures.response_profiles; }),
      key(
          profiles, "mu", "", "friction coefficient shown, one of friction.mu",
          [](auto& e) -> auto& { return e.figures.profile_mu; }),
      key(
          profiles, "layers", "layers", "layers shown", [](auto& e) -> auto& { return e.figures.profile_layers; }),
      key(
          "figures.transport_with_depth", "draw", "", "draw c and D against depth and against mu (Fig. 3)",
          [](auto& e) -> auto& { return e.figures.transport_with_depth; }),
      key(
          "figures.propagation_against_diffusion", "draw", "", "draw c against D (Fig. 4)",
          [](auto& e) -> auto& { return e.figures.propagation_against_diffusion; }),
      key(
          "figures.scaling_with_friction", "draw", "", "draw D and c0 - c against mu, from slopes and from ratios",
          [](auto& e) -> auto& { return e.figures.scaling_with_friction; }),
      key(
          "figures.propagation_and_thrust", "draw", "", "draw c beside the speed that follows from the thrust ratio",
          [](auto& e) -> auto& { return e.figures.propagation_and_thrust; }),

      key(
          redrawn, "mu", "", "friction coefficients at which the standard procedure is followed too; none: not at all",
          [](auto& e) -> auto& { return e.redrawn_beads.mu; }),
      key(
          redrawn, "samples", "pairs of piles", "pairs per friction coefficient",
          [](auto& e) -> auto& { return e.redrawn_beads.samples; }),
      key(
          work, "mu", "",
          "friction coefficients at which the work of drawing is counted against size; none: not at all",
          [](auto& e) -> auto& { return e.counted_work.mu; }),
      key(
          work, "sizes", "beads", "columns and layers of the square piles",
          [](auto& e) -> auto& { return e.counted_work.sizes; }),
      key(
          work, "samples", "piles", "piles per size and friction coefficient, at least 64",
          [](auto& e) -> auto& { return e.counted_work.samples; }),
      key(
          small, "mu", "", "friction coefficients followed by the thrust of narrow deep piles; none: not at all",
          [](auto& e) -> auto& { return e.small_friction.mu; }),
      key(
          small, "columns", "beads", "beads per layer of these piles",
          [](auto& e) -> auto& { return e.small_friction.columns; }),
      key(
          small, "depth", "0.6/mu^2 layers", "their depth in units of that over which the fluctuations saturate",
          [](auto& e) -> auto& { return e.small_friction.depth; }),
      key(
          small, "samples", "piles", "piles per friction coefficient, at least eight per block",
          [](auto& e) -> auto& { return e.small_friction.samples; }),
      key(
          "figures.chain_share", "samples", "piles",
          "piles of the size of scenes.force_chains from which the share of the response along the rays is taken; 0: "
          "none",
          [](auto& e) -> auto& { return e.chain_share.samples; }),
      key(
          "figures.law_comparison", "samples", "piles",
          "uniformly loaded piles of every law from which the laws are compared (rejection and eloy-clement on 6 x 6 "
          "beads only); 0: none",
          [](auto& e) -> auto& { return e.law_comparison.samples; }),
      key(
          "figures.law_comparison", "mu", "", "friction coefficient of that comparison",
          [](auto& e) -> auto& { return e.law_comparison.mu; }),
      key(
          "figures.law_comparison", "columns", "beads", "beads per layer of the piles of granusolve and polytope in it",
          [](auto& e) -> auto& { return e.law_comparison.columns; }),
      key(
          "figures.law_comparison", "layers", "layers", "layers of these piles",
          [](auto& e) -> auto& { return e.law_comparison.layers; }),
      key(
          "figures.law_comparison", "response_samples", "piles",
          "multiplexed piles of granusolve and polytope from which c and D under these laws are compared; 0: none",
          [](auto& e) -> auto& { return e.law_comparison.response_samples; }),
      key(
          "figures.law_comparison", "response_columns", "beads", "beads per layer of these piles",
          [](auto& e) -> auto& { return e.law_comparison.response_columns; }),
      key(
          "figures.law_comparison", "response_layers", "layers",
          "layers of these piles; c and D are slopes over layer 4 to the last but 21",
          [](auto& e) -> auto& { return e.law_comparison.response_layers; }),
      key(
          "figures.law_comparison", "response_burn_in", "sweeps",
          "polytope: from the start of a chain to the first of its eight piles; 0: measured, which takes long",
          [](auto& e) -> auto& { return e.law_comparison.response_burn_in; }),
      key(
          "figures.law_comparison", "response_thinning", "sweeps",
          "polytope: from one of the eight piles of a chain to the next; 0: measured",
          [](auto& e) -> auto& { return e.law_comparison.response_thinning; }),
      key(
          "figures.law_comparison", "cost_mu", "",
          "friction coefficients at which the work of eloy-clement is counted against size, beside granusolve; none: "
          "not at all",
          [](auto& e) -> auto& { return e.law_comparison.cost_mu; }),
      key(
          "figures.law_comparison", "cost_sizes", "beads", "columns and layers of the square piles for it",
          [](auto& e) -> auto& { return e.law_comparison.cost_sizes; }),
      key(
          "figures.law_comparison", "exact_mu", "",
          "friction coefficients, at most 0.3, at which the thrust ratio under the law rejection is taken from piles "
          "of several widths and depths; none: not at all",
          [](auto& e) -> auto& { return e.law_comparison.exact_mu; }),
      key(
          "figures.law_comparison", "exact_samples", "piles", "piles of each of these sizes",
          [](auto& e) -> auto& { return e.law_comparison.exact_samples; }),
      key(
          "figures.stress", "layers", "layers",
          "layers of the piles that strain the sampler: friction from 1e-9 to 1.73, with others on four columns and "
          "under uneven loads beside them; 0: none",
          [](auto& e) -> auto& { return e.stress.layers; }),
      key(
          "figures.stress", "columns", "beads", "beads per layer of these piles",
          [](auto& e) -> auto& { return e.stress.columns; }),
      key(
          errors, "repetitions", "repetitions",
          "independent repetitions of each estimator from which its error is taken and drawn against its run time; 0: "
          "none",
          [](auto& e) -> auto& { return e.error_against_time.repetitions; }),
      key(
          errors, "mu", "", "friction coefficient of that comparison",
          [](auto& e) -> auto& { return e.error_against_time.mu; }),
      key(
          errors, "columns", "beads", "beads per layer of its piles",
          [](auto& e) -> auto& { return e.error_against_time.columns; }),
      key(
          errors, "layers", "layers", "layers of its piles",
          [](auto& e) -> auto& { return e.error_against_time.layers; }),

      key(
          loads, "mu", "",
          "friction coefficients at which the response to several loads is compared with the linear one; none: not at "
          "all",
          [](auto& e) -> auto& { return e.nonlinearity.mu; }),
      key(
          loads, "epsilons", "loads of one top bead",
          "multiplexed loads compared; that of response.epsilon must be among them and stands for the linear response",
          [](auto& e) -> auto& { return e.nonlinearity.epsilons; }),
      key(
          loads, "overloads", "loads of one top bead", "point loads compared",
          [](auto& e) -> auto& { return e.nonlinearity.overloads; }),
      key(
          loads, "multiplexed_samples", "piles",
          "piles at response.epsilon and under a uniform load; at another epsilon in inverse proportion to its square, "
          "for errors of one size",
          [](auto& e) -> auto& { return e.nonlinearity.multiplexed_samples; }),
      key(
          loads, "point_samples", "piles", "piles at the overload 1; at another one in inverse proportion to it",
          [](auto& e) -> auto& { return e.nonlinearity.point_samples; }),

      key(
          chains, "draw", "", "draw the force chains of one pile (Fig. 1)",
          [](auto& e) -> auto& { return e.force_chains.draw; }),
      key(
          chains, "columns", "beads", "beads per layer of that pile, all shown",
          [](auto& e) -> auto& { return e.force_chains.columns; }),
      key(
          chains, "layers", "layers", "layers shown; 20 more are computed below them",
          [](auto& e) -> auto& { return e.force_chains.layers; }),
      key(
          chains, "mu", "", "friction coefficient of that pile", [](auto& e) -> auto& { return e.force_chains.mu; }),
      key(
          chains, "sample", "", "number of that pile under sampling.seed",
          [](auto& e) -> auto& { return e.force_chains.sample; }),
      key(
          chains, "width_px", "pixels", "width of the picture; mm = 25.4 width_px / dpi",
          [](auto& e) -> auto& { return e.force_chains.scene.width_px; }),
      key(
          chains, "dpi", "pixels per inch", "resolution of the picture; its text is laid out in points",
          [](auto& e) -> auto& { return e.force_chains.scene.dpi; }),
      key(
          chains, "colour_map", "", "colour map of the forces",
          [](auto& e) -> auto& { return e.force_chains.scene.colour_map; }),
      key(
          chains, "backend", "",
          "how OpenGL is reached: auto, osmesa or egl; none: the processor draws the same pixels",
          [](auto& e) -> auto& { return e.force_chains.scene.backend; }),
      key(
          chains, "skip_invisible", "", "leave out contacts that cannot change a pixel",
          [](auto& e) -> auto& { return e.force_chains.scene.skip_invisible; }),
      key(
          "scenes.weight", "draw", "", "draw the weights of the beads of scenes.force_chains, darker where larger",
          [](auto& e) -> auto& { return e.force_chains.weight; }),
      key(
          "scenes.friction", "draw", "",
          "draw how much of its friction each contact of scenes.force_chains mobilises, |T| / (mu N)",
          [](auto& e) -> auto& { return e.force_chains.friction; }),
      key(
          "scenes.response", "draw", "",
          "draw how those weights change with the overload, every bead keeping its random number",
          [](auto& e) -> auto& { return e.force_chains.response; }),
      key(
          "scenes.response_field", "draw", "",
          "draw the mean response over the plane, at figures.response_profiles.mu, with the fitted rays and widths",
          [](auto& e) -> auto& { return e.response_field.draw; }),

      key(
          "report", "pdf", "", "also write report.pdf, if WeasyPrint is installed",
          [](auto& e) -> auto& { return e.report.pdf; }),
  };
}

}  // namespace

std::string kind_of(const KeyValue& value) {
  static constexpr const char* kinds[] = {"true or false",
                                          "a whole number",
                                          "a number",
                                          "a string",
                                          "a list of whole numbers",
                                          "a list of numbers",
                                          "a list of pairs of numbers"};
  static_assert(std::size(kinds) == std::variant_size_v<KeyValue>);
  return kinds[value.index()];
}

std::vector<ExperimentKey> picture_keys(const std::string& name) {
  const std::string table = fmt::format("{}.{}", pictures_table, name);
  return {
      key(
          table, "scene", "", "one more picture of the pile of scenes.force_chains: forces, weight, friction, response",
          [name](auto& e) -> auto& { return e.pictures.at(name).scene; }),
      key(
          table, "window", "bead diameters, layers",
          "part shown: x0, x1 from the middle, first and last layer, both included; none: all that is shown",
          [name](auto& e) -> auto& { return e.pictures.at(name).window; }),
      key(
          table, "range", "as the scene",
          "ends of the colour scale, so that pictures compare; none: from what is shown",
          [name](auto& e) -> auto& { return e.pictures.at(name).range; }),
      key(
          table, "colour_map", "",
          "grey, viridis or cividis, or diverging for the scene response; empty: the scene's own",
          [name](auto& e) -> auto& { return e.pictures.at(name).colour_map; }),
      key(
          table, "width_px", "pixels", "width of the picture, at scenes.force_chains.dpi",
          [name](auto& e) -> auto& { return e.pictures.at(name).width_px; }),
  };
}

const std::vector<ExperimentKey>& experiment_keys() {
  static const std::vector<ExperimentKey> keys = make_keys();
  return keys;
}

}  // namespace granuscope
