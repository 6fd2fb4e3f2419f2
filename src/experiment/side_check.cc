#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/expected_response.h"
#include "analysis/law_comparison.h"
#include "ensemble/ensemble_runner.h"
#include "experiment/experiment_check.h"
#include "studies/common_checks.h"

namespace granuscope {
namespace {

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

}  // namespace

Problem find_side_problem(const Experiment& e) {
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
  return {};
}

}  // namespace granuscope
