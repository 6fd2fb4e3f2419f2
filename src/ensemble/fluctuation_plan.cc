#include "ensemble/fluctuation_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace granuscope {
namespace {

constexpr double most_of_lag = 4.5, most_of_reference = 3;  ///< k W
/// W^2 = smallest + slope mu^power z, within a third of what was measured at mu = 0.1 to 0.8.
constexpr double smallest = 0.1, slope = 2.4, power = 2.7;

constexpr double saturation = 0.6;  ///< layers times mu^2
constexpr int shallowest_base = 60, deepest_first_base = 2000;

/// The common divisor of the distances between lags: bases and references that keep to it need the fewest layers.
int spacing_of(const std::vector<int>& lags) {
  int spacing = 0;
  for (std::size_t i = 2; i < lags.size(); ++i) spacing = std::gcd(spacing, lags[i] - lags[i - 1]);
  return std::max(1, spacing);
}

std::vector<int> layers_of(const FluctuationPlan& plan) {
  std::vector<int> layers = plan.bases;
  for (const int base : plan.bases) {
    for (const int lag : plan.lags) layers.push_back(base + plan.reference + lag);
  }
  std::sort(layers.begin(), layers.end());
  layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
  return layers;
}

}  // namespace

int weighty_modes(double mu, int columns, int lag, int reference) {
  const auto width = [&](int layers) {
    return std::sqrt(smallest + slope * std::pow(mu, power) * (Lattice::depth(layers) - Lattice::depth(0)));
  };
  const double k = std::min(most_of_lag / width(lag), most_of_reference / width(reference));
  const int all = (columns - 1) / 2;
  return std::clamp(static_cast<int>(k * columns / (2 * std::numbers::pi)), std::min(4, all), all);
}

int saturated_layer(double mu) {
  if (!(mu > 0)) return shallowest_base;
  return static_cast<int>(std::clamp(saturation / (mu * mu), double{shallowest_base}, double{deepest_first_base}));
}

FluctuationPlan fluctuation_plan(const EnsembleSpec& spec) {
  const ResponseSpec& response = spec.response;
  FluctuationPlan plan;
  plan.lags = recorded_layers(spec);
  const int spacing = spacing_of(plan.lags), last = plan.lags.back();
  const int step = (response.base_step + spacing - 1) / spacing * spacing;
  const int first = response.first_base > 0 ? response.first_base : saturated_layer(spec.sampler.mu);
  // The deepest lag then falls on a layer as far from a base as lags are apart.
  plan.reference = response.reference_lag;
  while ((plan.reference + last) % spacing != 0) ++plan.reference;
  plan.layers_needed = first + plan.reference + last + bottom_margin + 1;
  for (int base = first; base + plan.reference + last + bottom_margin < spec.lattice.layers; base += step) {
    plan.bases.push_back(base);
  }
  for (const int lag : plan.lags) {
    // The reference serves every lag.
    const int shallowest = lag == 0 && plan.lags.size() > 1 ? plan.lags[1] : lag;
    plan.modes.push_back(weighty_modes(spec.sampler.mu, spec.lattice.columns, shallowest, plan.reference));
  }
  plan.layers = layers_of(plan);
  return plan;
}

}  // namespace granuscope
