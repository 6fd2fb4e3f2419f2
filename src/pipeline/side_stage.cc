#include "pipeline/side_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/error_curve.h"
#include "analysis/exact_thrust.h"
#include "analysis/law_comparison.h"
#include "experiment/experiment_check.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Fills the list of one experiment's side ensembles.
class Planner {
 public:
  Planner(const Experiment& experiment, const std::filesystem::path& run_folder)
      : experiment_(experiment), run_folder_(run_folder) {}

  std::vector<SideEnsemble> plan() {
    if (experiment_.law_comparison.samples > 0) add_laws();
    if (experiment_.law_comparison.response_samples > 0) add_law_responses();
    for (const double mu : experiment_.law_comparison.exact_mu) {
      for (const ExactThrustSize& size : exact_thrust_sizes(mu)) add_exact_thrust(mu, size.lattice);
    }
    for (const double mu : experiment_.law_comparison.cost_mu) {
      for (const Law law : {Law::granusolve, Law::eloy_clement}) {
        for (const int size : experiment_.law_comparison.cost_sizes) add_law_cost(law, mu, size);
      }
    }
    for (const double mu : experiment_.nonlinearity.mu) add_loads(mu);
    if (experiment_.error_against_time.repetitions > 0) add_error_curves();
    return std::move(planned_);
  }

 private:
  /// On columns just wide enough for the response: beads outside it would cost time and tell nothing.
  void add_loads(double mu) {
    const NonlinearitySpec& asked = experiment_.nonlinearity;
    FitSpec fit = experiment_.fit;
    fit.shallow_layer = fit.first_layer;  // nothing is drawn of the layers above the window
    constexpr double handy = 16;          // for the Fourier transforms
    const int enough = static_cast<int>(handy * std::ceil(columns_needed(mu, fit.last_layer) / handy));
    const LatticeSpec lattice{std::min(enough, experiment_.lattice.columns), experiment_.lattice.layers};
    const double reference = experiment_.response.epsilon;
    const auto add_load = [&](const std::string& name, double mean_samples, const auto& change) {
      EnsembleSpec spec = spec_at(mu, lattice, whole_rounds(mean_samples));
      spec.layout = BlockLayout::interleaved;
      spec.layers = layers_to_record(fit, {});
      change(spec);
      add(SideKind::nonlinearity, fmt::format("load {}, mu = {}", name, mu),
          fmt::format("load-{}-mu-{}", name, exact(mu)), spec);
    };
    const auto multiplexed = static_cast<double>(asked.multiplexed_samples);
    for (const double epsilon : asked.epsilons) {
      add_load("multiplexed-" + exact(epsilon), multiplexed * std::pow(reference / epsilon, 2),
               [&](EnsembleSpec& spec) {
                 spec.response.estimator = EstimatorName::multiplexed;
                 spec.response.epsilon = epsilon;
               });
    }
    for (const double overload : asked.overloads) {
      add_load("point-" + exact(overload), static_cast<double>(asked.point_samples) / overload,
               [&](EnsembleSpec& spec) { spec.response.overload = overload; });
    }
    add_load(name_of(Load::uniform), multiplexed, [](EnsembleSpec& spec) {
      spec.load = Load::uniform;
      spec.record_profiles = false;
    });
  }

  /// The least number of samples, at least that many, of which every block holds as many groups.
  std::uint64_t whole_rounds(double samples) const {
    const std::uint64_t round = group_size * static_cast<std::uint64_t>(experiment_.response.blocks);
    return round * static_cast<std::uint64_t>(std::max(1.0, std::ceil(samples / static_cast<double>(round) - 1e-9)));
  }

  /// Small repetitions of noisy estimators have no fit, so that these need more piles each time.
  void add_error_curves() {
    EnsembleSpec spec = error_spec(64);
    spec.response.estimator = EstimatorName::point;
    spec.response.samples *= 4;
    add_error_curve("point", spec);
    spec = error_spec(64);
    spec.response.estimator = EstimatorName::paired;
    spec.response.samples *= 2;
    add_error_curve("paired", spec);
    struct Options {
      double epsilon;
      bool opposite;
      int sign_run;
    };
    for (const auto& [epsilon, opposite, sign_run] :
         {Options{0.1, false, 1}, {0.25, false, 1}, {0.5, false, 1}, {0.25, true, 2}, {0.1, true, 2}}) {
      spec = error_spec(64);
      spec.response.estimator = EstimatorName::multiplexed;
      spec.response.epsilon = epsilon;
      spec.response.opposite = opposite;
      spec.response.sign_run = sign_run;
      add_error_curve(fmt::format("multiplexed-{}{}{}", exact(epsilon), opposite ? "-opposite" : "",
                                  sign_run > 1 ? fmt::format("-runs-{}", sign_run) : ""),
                      spec);
    }
  }

  EnsembleSpec error_spec(std::uint64_t samples_each_time) const {
    const ErrorAgainstTimeSpec& asked = experiment_.error_against_time;
    const auto repetitions = static_cast<std::uint64_t>(asked.repetitions);
    EnsembleSpec spec = spec_at(asked.mu, {asked.columns, asked.layers}, samples_each_time * repetitions);
    spec.response.overload = ResponseSpec{}.overload;
    spec.response.blocks = repetition_blocks * asked.repetitions;
    spec.layers = layers_to_record(error_curve_fit(spec.lattice), {});
    return spec;
  }

  void add_error_curve(const std::string& name, const EnsembleSpec& spec) {
    add(SideKind::error_curve, fmt::format("error against time, {}", name), fmt::format("error-{}", name), spec);
  }

  void add_laws() {
    const LawComparisonSpec& asked = experiment_.law_comparison;
    const LatticeSpec small{asked.columns, asked.layers}, tiny{LawComparisonSpec::tiny, LawComparisonSpec::tiny};
    add_law(Law::granusolve, 1, small);
    for (const MendingRules rules : {MendingRules::no_pair, MendingRules::no_arcs, MendingRules::climb_only}) {
      add_law(Law::granusolve, 1, small, rules);
    }
    add_law(Law::polytope, 1, small);
    add_law(Law::polytope, 0, small);
    add_law(Law::granusolve, 1, tiny);
    add_law(Law::eloy_clement, 1, tiny);
    add_law(Law::rejection, 1, tiny);
    add_law(Law::polytope, 1, tiny);
    add_law(Law::rejection, 1, LawComparisonSpec::narrow);
  }

  /// What none of its rules could complete is left out: climbs alone finish hardly a pile.
  void add_law_responses() {
    for (const MendingRules rules : {MendingRules::all, MendingRules::no_pair, MendingRules::no_arcs}) {
      add_law_response(Law::granusolve, 1, rules);
    }
    for (const double lambda : {1.0, 0.0}) add_law_response(Law::polytope, lambda);
  }

  void add_law_response(Law law, double lambda, MendingRules rules = MendingRules::all) {
    const LawComparisonSpec& asked = experiment_.law_comparison;
    const LatticeSpec lattice{asked.response_columns, asked.response_layers};
    EnsembleSpec spec = uniform_piles(law, asked.mu, lattice, asked.response_samples);
    spec.sampler.lambda = lambda;
    spec.sampler.rules = rules;
    if (law == Law::polytope) {
      spec.sampler.burn_in = asked.response_burn_in;
      spec.sampler.thinning = asked.response_thinning;
    }
    spec.load = Load::point;
    spec.response.estimator = EstimatorName::multiplexed;
    spec.response.epsilon = LawComparisonSpec::response_epsilon;
    spec.record_profiles = true;
    spec.layers = layers_to_record(law_response_fit(lattice), {});
    const std::string which = law_in_file_name(law, lambda, rules);
    add(SideKind::law_response, fmt::format("response under {}, {} x {}", which, lattice.columns, lattice.layers),
        fmt::format("law-response-{}", which), spec);
  }

  void add_exact_thrust(double mu, LatticeSpec lattice) {
    EnsembleSpec spec = uniform_piles(Law::rejection, mu, lattice, experiment_.law_comparison.exact_samples);
    const std::string size = fmt::format("{}x{}", lattice.columns, lattice.layers);
    add(SideKind::exact_thrust,
        fmt::format("thrust under rejection, mu = {}, {} x {}", mu, lattice.columns, lattice.layers),
        fmt::format("exact-thrust-mu-{}-{}", exact(mu), size), spec);
  }

  static std::string law_in_file_name(Law law, double lambda, MendingRules rules) {
    return law == Law::polytope         ? fmt::format("{}-{}", name_of(law), lambda)
           : rules != MendingRules::all ? fmt::format("{}-{}", name_of(law), name_of(rules))
                                        : name_of(law);
  }

  /// Counted, not measured: few blocks, and piles that eloy-clement still finishes.
  void add_law_cost(Law law, double mu, int size) {
    EnsembleSpec spec = uniform_piles(law, mu, {size, size}, group_size * 8);
    spec.response.blocks = 8;
    add(SideKind::law_cost, fmt::format("work of {}, mu = {}, {} x {}", name_of(law), mu, size, size),
        fmt::format("law-cost-{}-mu-{}-{}x{}", name_of(law), exact(mu), size, size), spec);
  }

  /// Piles of one law as it is by default, every layer recorded.
  EnsembleSpec uniform_piles(Law law, double mu, LatticeSpec lattice, std::uint64_t samples) const {
    EnsembleSpec spec = spec_at(mu, lattice, samples);
    SamplerSpec sampler;  // the law as it is by default, whatever the main ensembles are drawn by
    sampler.mu = spec.sampler.mu;
    sampler.seed = spec.sampler.seed;
    sampler.law = law;
    if (law == Law::eloy_clement) sampler.effort = LawComparisonSpec::effort;
    spec.sampler = sampler;
    spec.load = Load::uniform;
    spec.response.estimator = EstimatorName::point;
    spec.record_profiles = false;
    return spec;
  }

  void add_law(Law law, double lambda, LatticeSpec lattice, MendingRules rules = MendingRules::all) {
    EnsembleSpec spec = uniform_piles(law, experiment_.law_comparison.mu, lattice, experiment_.law_comparison.samples);
    spec.sampler.lambda = lambda;
    spec.sampler.rules = rules;
    const std::string which = law_in_file_name(law, lambda, rules);
    add(SideKind::law_comparison, fmt::format("law {}, {} x {}", which, lattice.columns, lattice.layers),
        fmt::format("law-{}-{}x{}", which, lattice.columns, lattice.layers), spec);
  }

  EnsembleSpec spec_at(double mu, LatticeSpec lattice, std::uint64_t samples) const {
    EnsembleSpec spec;
    spec.sampler = experiment_.sampler_for(mu);
    spec.lattice = lattice;
    spec.response.overload = experiment_.response.overload;
    spec.response.blocks = experiment_.response.blocks;
    spec.response.samples = samples;
    return spec;
  }

  void add(SideKind kind, const std::string& label, const std::string& file, const EnsembleSpec& spec) {
    PlannedEnsemble planned;
    planned.label = label;
    planned.spec = spec;
    planned.file = std::filesystem::path("ensembles") / (file + ".h5");
    look_for(planned, run_folder_);
    planned_.push_back({kind, std::move(planned)});
  }

  const Experiment& experiment_;
  const std::filesystem::path& run_folder_;
  std::vector<SideEnsemble> planned_;
};

}  // namespace

std::vector<SideEnsemble> plan_side_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder) {
  return Planner(experiment, run_folder).plan();
}

void SideMeasurer::add(const SideEnsemble& side, const MeasuredEnsemble& ensemble, double seconds) {
  switch (side.kind) {
    case SideKind::law_comparison:
      measured_.laws.push_back(measure_law(ensemble));
      law_seconds_.push_back(seconds);
      break;
    case SideKind::law_response:
      measured_.law_responses.push_back(measure_law_response(ensemble, threads_));
      break;
    case SideKind::exact_thrust:
      measured_.exact_thrusts.push_back(
          measure_exact_thrust(ensemble, exact_thrust_sizes(ensemble.spec.sampler.mu).front().margin));
      break;
    case SideKind::law_cost:
      measured_.law_costs.push_back(measure_law(ensemble));
      break;
    case SideKind::nonlinearity:
      nonlinearity_.add(ensemble);
      break;
    case SideKind::error_curve:
      measured_.error_curves.push_back(measure_error_curve(ensemble, threads_));
      error_curve_seconds_.push_back(seconds);
      break;
  }
}

SideMeasurements SideMeasurer::finish() {
  measured_.nonlinearity = nonlinearity_.finish();
  set_shifts(measured_.error_curves);
  return std::move(measured_);
}

}  // namespace granuscope
