#include "pipeline/side_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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
    return std::move(planned_);
  }

 private:
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
  }
}

SideMeasurements SideMeasurer::finish() { return std::move(measured_); }

}  // namespace granuscope
