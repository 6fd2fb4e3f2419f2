#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/law_comparison.h"
#include "ensemble/ensemble_runner.h"
#include "experiment/experiment_check.h"
#include "studies/common_checks.h"

namespace granuscope {
namespace {

constexpr int most_error_repetitions = 256;

/// A list of friction coefficients of a side measurement: `least` <= mu < sqrt(3), ascending.
Problem find_side_mu_problem(const char* key, const std::vector<double>& mu, bool zero_allowed) {
  if (mu.size() > most_friction_values) {
    return problem(key, "{} values are more than {}; split the experiment", mu.size(), most_friction_values);
  }
  for (std::size_t k = 0; k < mu.size(); ++k) {
    if (auto found = find_mu_problem(key, mu[k])) return found;
    if (mu[k] == 0 && !zero_allowed) {
      return problem(key, "at mu = 0 nothing is random, so that there is nothing to measure here; give mu above 0");
    }
    if (k > 0 && mu[k] <= mu[k - 1]) {
      return problem(key, "{} follows {}, but the list must ascend without repetition; sort it", mu[k], mu[k - 1]);
    }
  }
  return {};
}

Problem find_nonlinearity_problem(const Experiment& e) {
  const NonlinearitySpec& loads = e.nonlinearity;
  if (auto found = find_side_mu_problem("figures.nonlinearity.mu", loads.mu, false)) return found;
  const auto find_list_problem = [](const char* key, const std::vector<double>& values, double least, double most) {
    if (values.empty() || values.size() > 6) return problem(key, "{} loads; give 1 to 6", values.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (!(values[k] >= least && values[k] <= most)) {
        return problem(key, "{} cannot be measured beside loads of 1; give {} to {}", values[k], least, most);
      }
      if (k > 0 && values[k] <= values[k - 1]) {
        return problem(key, "{} follows {}, but the list must ascend without repetition; sort it", values[k],
                       values[k - 1]);
      }
    }
    return Problem{};
  };
  if (auto found = find_list_problem("figures.nonlinearity.epsilons", loads.epsilons, 0.01, 0.99)) return found;
  if (auto found = find_list_problem("figures.nonlinearity.overloads", loads.overloads, 0.01, 100)) return found;
  if (std::find(loads.epsilons.begin(), loads.epsilons.end(), e.response.epsilon) == loads.epsilons.end()) {
    return problem(
        "figures.nonlinearity.epsilons",
        "response.epsilon = {} is not among [{}], but the linear response is measured with it and the others "
        "are compared with that; add it",
        e.response.epsilon, fmt::join(loads.epsilons, ", "));
  }
  for (const double mu : loads.mu) {
    if (mu > e.mu.back()) {
      return problem("figures.nonlinearity.mu",
                     "{} is above the largest friction coefficient of friction.mu, {}, for which lattice.columns were "
                     "found wide enough; leave it out",
                     mu, e.mu.back());
    }
  }
  const char* key = "figures.nonlinearity.multiplexed_samples";
  if (auto found = find_samples_problem(key, loads.multiplexed_samples, e.response.blocks)) return found;
  return find_samples_problem("figures.nonlinearity.point_samples", loads.point_samples, e.response.blocks);
}

Problem find_law_response_problem(const Experiment& e) {
  const LawComparisonSpec& laws = e.law_comparison;
  const char* key = "figures.law_comparison.response_samples";
  if (laws.samples == 0) {
    return problem(key,
                   "{} piles for c and D, but figures.law_comparison.samples is 0, so that there is no table to "
                   "put them into; set both or neither",
                   laws.response_samples);
  }
  if (auto found = find_samples_problem(key, laws.response_samples, e.response.blocks)) return found;
  const FitSpec fit = law_response_fit({laws.response_columns, laws.response_layers});
  constexpr int least_depths = 3;
  const int least_layers = fit.first_layer + least_depths + bottom_margin;
  if (laws.response_layers < least_layers) {
    return problem("figures.law_comparison.response_layers",
                   "{} layers: slopes need {} depths from layer {} on, and the lowest {} layers follow another law; "
                   "give at least {}",
                   laws.response_layers, least_depths, fit.first_layer, bottom_margin, least_layers);
  }
  const double least_columns = columns_needed(laws.mu, fit.last_layer);
  if (laws.response_columns < least_columns ||
      static_cast<double>(laws.response_columns) * laws.response_layers > static_cast<double>(most_polytope_beads)) {
    return problem("figures.law_comparison.response_columns",
                   "{} x {} beads: the two peaks need {} columns not to meet behind the ring, and the chain of the law "
                   "polytope forgets too slowly on more than {} beads; give a size between",
                   laws.response_columns, laws.response_layers, std::ceil(least_columns), most_polytope_beads);
  }
  if (laws.response_burn_in > most_sweeps || laws.response_thinning > most_sweeps) {
    return problem("figures.law_comparison.response_burn_in",
                   "a chain counts no more than {} sweeps; give fewer, or 0 to have them measured", most_sweeps);
  }
  return {};
}

Problem find_error_curve_problem(const Experiment& e) {
  const ErrorAgainstTimeSpec& asked = e.error_against_time;
  if (asked.repetitions < 8 || asked.repetitions > most_error_repetitions) {
    return problem("figures.error_against_time.repetitions",
                   "{} repetitions: the scatter of fewer than 8 says nothing about an error, and their sums are kept "
                   "apart, each in blocks of its own; give 8 to {}",
                   asked.repetitions, most_error_repetitions);
  }
  if (e.sampling.law != Law::granusolve) {
    return problem("figures.error_against_time.repetitions",
                   "only the law granusolve draws enough piles in which peaks stand apart, but sampling.law is {}; set "
                   "repetitions = 0 or change the law",
                   name_of(e.sampling.law));
  }
  if (auto found = find_mu_problem("figures.error_against_time.mu", asked.mu)) return found;
  if (asked.mu == 0)
    return problem("figures.error_against_time.mu", "at mu = 0 nothing is random and no error falls; give mu above 0");
  constexpr int least_layers = bottom_margin + 40;
  if (auto found =
          find_lattice_problem("figures.error_against_time.columns", asked.columns, "figures.error_against_time.layers",
                               asked.layers, least_layers, pile_memory(asked.columns, asked.layers))) {
    return found;
  }
  constexpr double room_for_widths = 24;  // bead diameters: eight widths of 3
  const double least_columns = 2 * tan30 * Lattice::depth(asked.layers - bottom_margin) + room_for_widths;
  if (asked.columns < least_columns) {
    return problem("figures.error_against_time.columns",
                   "{} columns: the two peaks meet behind the ring above layer {}, so that no slope could be fitted; "
                   "give at least {}, or fewer layers",
                   asked.columns, asked.layers - bottom_margin, std::ceil(least_columns));
  }
  return {};
}

}  // namespace

Problem find_side_problem(const Experiment& e) {
  if (!e.nonlinearity.mu.empty()) {
    if (auto found = find_nonlinearity_problem(e)) return found;
  }
  if (e.law_comparison.samples > 0) {
    const LawComparisonSpec& laws = e.law_comparison;
    if (auto found = find_samples_problem("figures.law_comparison.samples", laws.samples, e.response.blocks)) {
      return found;
    }
    if (!(laws.mu > 0 && laws.mu <= 0.6)) {
      return problem(
          "figures.law_comparison.mu",
          "{}: without friction all laws are one, and above 0.6 the laws that throw away what fails take for "
          "ever even on 6 x 6 beads; give more than 0 and at most 0.6",
          laws.mu);
    }
    if (laws.columns < 4 || laws.layers < 4 ||
        static_cast<double>(laws.columns) * laws.layers > static_cast<double>(most_polytope_beads)) {
      return problem("figures.law_comparison.columns",
                     "{} x {} beads: the law polytope takes on 4 x 4 beads to {} in all, since its chain forgets too "
                     "slowly on more; give a size between",
                     laws.columns, laws.layers, most_polytope_beads);
    }
  }
  if (e.law_comparison.response_samples > 0) {
    if (auto found = find_law_response_problem(e)) return found;
  }
  for (const double mu : e.law_comparison.exact_mu) {
    if (!(mu > 0 && mu <= 0.3)) {
      return problem(
          "figures.law_comparison.exact_mu",
          "{}: without friction alpha is 1 by definition, and above 0.3 rejection takes for ever on piles deep enough "
          "to have a bulk; give more than 0 and at most 0.3",
          mu);
    }
  }
  if (!e.law_comparison.exact_mu.empty()) {
    if (e.law_comparison.samples == 0) {
      return problem("figures.law_comparison.exact_mu",
                     "the thrust of the law rejection is asked for, but figures.law_comparison.samples is 0, so that "
                     "there is no comparison to stand in; set both or neither");
    }
    if (auto found = find_samples_problem("figures.law_comparison.exact_samples", e.law_comparison.exact_samples,
                                          e.response.blocks)) {
      return found;
    }
  }
  for (const double mu : e.law_comparison.cost_mu) {
    if (!(mu > 0 && mu <= 0.6)) {
      return problem(
          "figures.law_comparison.cost_mu",
          "{}: without friction nothing fails, and above 0.6 eloy-clement takes for ever even on 6 x 6 beads; "
          "give more than 0 and at most 0.6",
          mu);
    }
  }
  for (std::size_t i = 0; i < e.law_comparison.cost_sizes.size(); ++i) {
    const auto& sizes = e.law_comparison.cost_sizes;
    if (sizes[i] < 4 || sizes[i] > 40 || (i > 0 && sizes[i] <= sizes[i - 1])) {
      return problem("figures.law_comparison.cost_sizes",
                     "{} at place {}: sizes must ascend from 4 beads, the narrowest ring, to at most 40, where nothing "
                     "eloy-clement begins is finished",
                     sizes[i], i + 1);
    }
  }
  if (e.error_against_time.repetitions != 0) {
    if (auto found = find_error_curve_problem(e)) return found;
  }
  return {};
}

}  // namespace granuscope
