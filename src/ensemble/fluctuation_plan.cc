#include "ensemble/fluctuation_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace granuscope {
namespace {

constexpr double most_of_lag = 4.5, most_of_reference = 3;  ///< k W
constexpr double smallest = 0.1;                            ///< W^2 of the shortest lags

/// Growth of W^2 per bead diameter, of beads within a third of what was measured at mu = 0.1 to 0.8; under the law
/// polytope, where W^2 is no power of z near 1, of what it was at z = 14 and mu = 0.5.
double spreading_of(const SamplerSpec& sampler) {
  constexpr double slope = 2.4, of_polytope = 10, power = 2.7;
  return sampler.model.has_contacts()
             ? (sampler.law == Law::polytope ? of_polytope : slope) * std::pow(sampler.mu, power)
             : rough_spreading(sampler.model);
}

/// The highest mode on a ring of `columns` that tells something of a lag: where k W = 4.5 for a rough W(lag), so that
/// the response has fallen to 4e-5 and the mode counts less than 1 % in the fit that x_p and W come from
/// (weighted_shape.h); or where k W(reference) = 3, if that is less: the noise is divided by exp(-k^2
/// W(reference)^2/2).
int weighty_modes(const SamplerSpec& sampler, int columns, int lag, int reference) {
  const auto width = [&](int layers) {
    return std::sqrt(smallest + spreading_of(sampler) * layers * rows_of(sampler.model).spacing);
  };
  const double k = std::min(most_of_lag / width(lag), most_of_reference / width(reference));
  const int all = (columns - 1) / 2;
  return std::clamp(static_cast<int>(k * columns / (2 * std::numbers::pi)), std::min(4, all), all);
}

/// Layers below which uniformly loaded piles fluctuate as deep ones do: 0.6/mu^2 of beads, at least 60 and at most
/// 2000. Of legs that push twice the deepest lag, so that waves as long as its peak is wide are there (from layer 60 on
/// W^2 was 5 to 16 % smaller than from layer 2000 on). Models whose noise acts linearly respond alike in any layer.
int saturated_layer(const SamplerSpec& sampler, int deepest_lag) {
  constexpr double shallowest = 60, deepest = 2000, times_mu_squared = 0.6;
  const ModelSpec& model = sampler.model;
  if (model.name == ModelName::three_leg && model.three_leg.law != MiddleLaw::free)
    return std::max(static_cast<int>(shallowest), 2 * deepest_lag);
  if (!model.has_contacts() || !(sampler.mu > 0)) return static_cast<int>(shallowest);
  return static_cast<int>(std::clamp(times_mu_squared / (sampler.mu * sampler.mu), shallowest, deepest));
}

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

FluctuationPlan fluctuation_plan(const EnsembleSpec& spec) {
  const ResponseSpec& response = spec.response;
  FluctuationPlan plan;
  plan.lags = recorded_layers(spec);
  const int spacing = spacing_of(plan.lags), last = plan.lags.back();
  const int step = (response.base_step + spacing - 1) / spacing * spacing;
  const int first = response.first_base > 0 ? response.first_base : saturated_layer(spec.sampler, last);
  // The deepest lag then falls on a layer as far from a base as lags are apart.
  plan.reference = response.reference_lag;
  while ((plan.reference + last) % spacing != 0) ++plan.reference;
  const int unused = bottom_margin_of(spec.sampler.model);
  plan.layers_needed = first + plan.reference + last + unused + 1;
  for (int base = first; base + plan.reference + last + unused < spec.lattice.layers; base += step) {
    plan.bases.push_back(base);
  }
  for (const int lag : plan.lags) {
    // The reference serves every lag.
    const int shallowest = lag == 0 && plan.lags.size() > 1 ? plan.lags[1] : lag;
    plan.modes.push_back(weighty_modes(spec.sampler, spec.lattice.columns, shallowest, plan.reference));
  }
  plan.layers = layers_of(plan);
  return plan;
}

}  // namespace granuscope
