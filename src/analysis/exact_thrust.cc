#include "analysis/exact_thrust.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"

namespace granuscope {

std::vector<ExactThrustSize> exact_thrust_sizes(double mu) {
  constexpr double beads_times_mu = 25.2, margin_times_mu = 1.2;
  constexpr int most_layers = 400, widest_margin = most_layers / 4;
  std::vector<ExactThrustSize> sizes;
  const int margin = static_cast<int>(std::min(std::round(margin_times_mu / mu), 1.0 * widest_margin));
  for (const int columns : {4, 6, 8}) {
    const double layers = std::max(beads_times_mu / mu / columns, 2.0 * margin + 2);
    sizes.push_back({{columns, static_cast<int>(std::min(layers, 1.0 * most_layers))}, margin});
  }
  return sizes;
}

ExactThrust measure_exact_thrust(const MeasuredEnsemble& ensemble, int margin) {
  const auto& [spec, record] = ensemble;
  const BlockSums& sums = record.sums;
  const double mu = spec.sampler.mu;
  ExactThrust result;
  result.spec = spec;
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.failed = record.failed.size();
  result.first_layer = margin;
  result.last_layer = result.spec.lattice.layers - margin - 1;
  std::vector<Replicated> upper, lower, bulk;
  const int bulk_layers = result.last_layer - result.first_layer + 1;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int in_bulk = sums.layers[row] - result.first_layer;
    const Replicated thrust = block_mean(sums, "thrust", row);
    if (sums.layers[row] == result.spec.lattice.layers - 1)
      result.alpha_of_last_layer = estimate(thrust, "no pile was completed");
    if (in_bulk < 0 || in_bulk >= bulk_layers) continue;
    bulk.push_back(thrust);
    if (2 * in_bulk < bulk_layers - 1) upper.push_back(thrust);
    if (2 * in_bulk > bulk_layers - 1) lower.push_back(thrust);
  }
  const Replicated alpha = mean_of(bulk);
  result.alpha = estimate(alpha, "no pile was completed");
  result.deficit_over_mu2 =
      estimate(transform([mu](double a) { return (1 - a) / (mu * mu); }, alpha), "no pile was completed");
  result.change_with_depth =
      estimate(transform([](double above, double below) { return below - above; }, mean_of(upper), mean_of(lower)),
               "no pile was completed");
  return result;
}

}  // namespace granuscope
