#include "analysis/scaling.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "analysis/line_fit.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr int min_points = 3;
/// The reader of a window such as [0.1, 0.3] expects both ends inside.
constexpr double window_slack = 1e-9;

struct Points {
  std::vector<Replicated> x, y;  ///< logarithms
};

double variance(const Replicated& number) { return std::pow(estimate(number).standard_error, 2); }

/// Covariance of two replicated numbers, by the same jackknife.
double covariance(const Replicated& a, const Replicated& b) {
  // From the variance of the sum: exact for the jackknife, which is a quadratic form.
  const Replicated sum = transform([](double p, double q) { return p + q; }, a, b);
  return (variance(sum) - variance(a) - variance(b)) / 2;
}

std::vector<double> values(const std::vector<Replicated>& numbers, std::size_t block, bool whole) {
  std::vector<double> result(numbers.size());
  std::transform(numbers.begin(), numbers.end(), result.begin(),
                 [&](const Replicated& number) { return whole ? number.value : number.without_block[block]; });
  return result;
}

ScalingFit fit_power_law(const Points& points, std::array<double, 2> window) {
  ScalingFit fit;
  fit.window = window;
  fit.points = static_cast<int>(points.x.size());
  if (fit.points < min_points) {
    fit.exponent.reason = fit.intercept.reason =
        fmt::format("{} friction coefficients with usable results in the window {} to {}; an exponent needs {}",
                    fit.points, window[0], window[1], min_points);
    return fit;
  }
  std::vector<double> weights(points.x.size(), 1.0);
  double slope = 0;
  // The weights depend on the slope through the errors of x; three rounds settle them far below their own accuracy.
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double spread = variance(points.y[i]) + slope * slope * variance(points.x[i]) -
                            2 * slope * covariance(points.x[i], points.y[i]);
      weights[i] = 1 / spread;
    }
    slope = fit_line(values(points.x, 0, true), values(points.y, 0, true), weights).slope;
  }
  Replicated exponent, intercept;
  const Line whole = fit_line(values(points.x, 0, true), values(points.y, 0, true), weights);
  exponent.value = whole.slope;
  intercept.value = whole.intercept;
  for (std::size_t b = 0; b < points.x.front().without_block.size(); ++b) {
    const Line line = fit_line(values(points.x, b, false), values(points.y, b, false), weights);
    exponent.without_block.push_back(line.slope);
    intercept.without_block.push_back(line.intercept);
  }
  const std::string reason = "a quantity is not positive without one of the blocks, so that its logarithm is undefined";
  fit.exponent = estimate(exponent, reason);
  fit.intercept = estimate(intercept, reason);
  return fit;
}

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
  return {fit_power_law(beta, window), fit_power_law(gamma, window), fit_power_law(alpha, window)};
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
