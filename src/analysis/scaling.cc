#include "analysis/scaling.h"

#include <algorithm>
#include <cmath>

#include "analysis/power_law.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

/// The reader of a window such as [0.1, 0.3] expects both ends inside.
constexpr double window_slack = 1e-9;

struct Points {
  std::vector<Replicated> x, y;  ///< logarithms
  ScalingFit fit(std::array<double, 2> window) const { return fit_power_law(x, y, window); }
};

/// c and D of one friction coefficient, however they were read.
struct Coefficients {
  double mu;
  const Replicated& c;
  const Replicated& D;
};

ScalingFits fit_all(const std::vector<Coefficients>& coefficients, std::array<double, 2> window) {
  Points beta, gamma, alpha;
  for (const Coefficients& one : coefficients) {
    if (one.mu < window[0] - window_slack || one.mu > window[1] + window_slack) continue;
    const Replicated log_mu = transform([&](double) { return std::log(one.mu); }, one.c);
    const Replicated log_D = transform([](double D) { return std::log(D); }, one.D);
    const Replicated log_slowing = transform([](double c) { return std::log(tan30 - c); }, one.c);
    const bool D_usable = estimate(log_D).known(), slowing_usable = estimate(log_slowing).known();
    if (D_usable) beta.x.push_back(log_mu), beta.y.push_back(log_D);
    if (slowing_usable) gamma.x.push_back(log_mu), gamma.y.push_back(log_slowing);
    if (D_usable && slowing_usable) alpha.x.push_back(log_D), alpha.y.push_back(log_slowing);
  }
  return {beta.fit(window), gamma.fit(window), alpha.fit(window)};
}

}  // namespace

ScalingFits fit_scaling(const std::vector<MeasuredTransport>& results, std::array<double, 2> window) {
  std::vector<Coefficients> slopes;
  for (const MeasuredTransport& result : results) {
    const Transport& t = result.transport;
    if (!t.exact && t.c.known() && t.D.known()) slopes.push_back({t.mu, result.c, result.D});
  }
  return fit_all(slopes, window);
}

RatioScaling fit_ratio_scaling(const std::vector<MeasuredTransport>& results, int layer, std::array<double, 2> window) {
  std::vector<Coefficients> ratios;
  for (const MeasuredTransport& result : results) {
    if (result.transport.exact) continue;
    for (const MeasuredRatios& one : result.ratios) {
      if (one.layer == layer) ratios.push_back({result.transport.mu, one.position, one.width_squared});
    }
  }
  return {layer, Lattice::depth(layer), fit_all(ratios, window)};
}

}  // namespace granuscope
