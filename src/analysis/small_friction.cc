#include "analysis/small_friction.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "analysis/layer_spectrum.h"
#include "analysis/power_law.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr int shown_depths = 40;      ///< spread evenly in ln z
constexpr int averaged_depths = 500;  ///< at most about this many enter the average

int usable(int layers) { return Lattice({4, layers}).usable_layers(); }

int first_deep_layer(int layers) { return usable(layers) / 2; }

}  // namespace

double saturation_layers(double mu) { return 0.6 / (mu * mu); }

std::vector<int> thrust_layers(int layers) {
  const int last = usable(layers) - 1;
  std::set<int> recorded;
  for (int k = 0; k < shown_depths; ++k) {
    recorded.insert(static_cast<int>(std::lround(std::pow(last, static_cast<double>(k) / (shown_depths - 1)))));
  }
  const int deep = last - first_deep_layer(layers);
  const int step = std::max(1, deep / averaged_depths) | 1;  // odd, so that both row parities take part
  for (int layer = last; layer >= first_deep_layer(layers); layer -= step) recorded.insert(layer);
  return {recorded.begin(), recorded.end()};
}

MeasuredSmallFriction measure_small_friction(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  MeasuredSmallFriction measured;
  SmallFriction& result = measured.result;
  result.spec = ensemble.spec;
  const int layers = ensemble.spec.lattice.layers;
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.depth_over_saturation = layers / saturation_layers(ensemble.spec.sampler.mu);
  result.first_layer = first_deep_layer(layers);
  result.last_layer = sums.layers.back();
  std::vector<Replicated> deep;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const Replicated thrust = block_mean(sums, "thrust", row);
    result.depths.push_back(
        {layer, Lattice::depth(layer), estimate(thrust), estimate(block_mean(sums, "weight_variance", row))});
    if (layer >= result.first_layer) deep.push_back(thrust);
  }
  const Replicated alpha = mean_of(deep);
  const Replicated c = transform([](double a) { return tan30 * std::sqrt(a); }, alpha);
  measured.c0_minus_c = transform([](double speed) { return tan30 - speed; }, c);
  result.alpha_thrust = estimate(alpha);
  result.c_thrust = estimate(c, "the mean thrust ratio is negative");
  result.c0_minus_c = estimate(measured.c0_minus_c, "the mean thrust ratio is negative");
  return measured;
}

ScalingFit fit_small_friction(const std::vector<MeasuredSmallFriction>& measured) {
  std::vector<Replicated> log_mu, log_slowing;
  std::array<double, 2> window{};
  for (const MeasuredSmallFriction& one : measured) {
    const Replicated slowing = transform([](double s) { return std::log(s); }, one.c0_minus_c);
    if (one.result.spec.sampler.mu <= 0 || !estimate(slowing).known()) continue;
    if (log_mu.empty()) window[0] = one.result.spec.sampler.mu;
    window[1] = one.result.spec.sampler.mu;
    log_mu.push_back(transform([&](double) { return std::log(one.result.spec.sampler.mu); }, slowing));
    log_slowing.push_back(slowing);
  }
  return fit_power_law(log_mu, log_slowing, window);
}

}  // namespace granuscope
