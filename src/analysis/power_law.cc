#include "analysis/power_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/line_fit.h"

namespace granuscope {
namespace {

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

}  // namespace

ReplicatedPowerLaw fit_replicated_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                                            std::array<double, 2> window) {
  ReplicatedPowerLaw result;
  ScalingFit& fit = result.fit;
  fit.window = window;
  fit.points = static_cast<int>(log_x.size());
  if (fit.points < min_power_law_points) {
    fit.exponent.reason = fit.intercept.reason = fit.scatter.reason =
        fmt::format("the window μ = {} to {} has usable results at {} friction coefficient{}, an exponent needs {}",
                    window[0], window[1], fit.points, fit.points == 1 ? "" : "s", min_power_law_points);
    return result;
  }
  std::vector<double> weights(log_x.size(), 1.0);
  double slope = 0;
  // The weights depend on the slope through the errors of x; three rounds settle them far below their own accuracy.
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double spread =
          variance(log_y[i]) + slope * slope * variance(log_x[i]) - 2 * slope * covariance(log_x[i], log_y[i]);
      weights[i] = 1 / spread;
    }
    slope = fit_line(values(log_x, 0, true), values(log_y, 0, true), weights).slope;
  }
  Replicated& exponent = result.exponent;
  Replicated intercept;
  const Line whole = fit_line(values(log_x, 0, true), values(log_y, 0, true), weights);
  exponent.value = whole.slope;
  intercept.value = whole.intercept;
  for (std::size_t b = 0; b < log_x.front().without_block.size(); ++b) {
    const Line line = fit_line(values(log_x, b, false), values(log_y, b, false), weights);
    exponent.without_block.push_back(line.slope);
    intercept.without_block.push_back(line.intercept);
  }
  const std::string reason = "a quantity is not positive without one of the blocks, so that its logarithm is undefined";
  fit.exponent = estimate(exponent, reason);
  fit.intercept = estimate(intercept, reason);
  if (!fit.exponent.known()) {
    fit.scatter.reason = fit.exponent.reason;
    return result;
  }
  // What scatters across the law is y - exponent x; adding it back to the law leaves the test a line in x.
  std::vector<Replicated> across;
  for (std::size_t i = 0; i < log_x.size(); ++i) {
    across.push_back(transform([&](double x, double y) { return y - whole.slope * x; }, log_x[i], log_y[i]));
  }
  fit.scatter = test_line(values(log_x, 0, true), across);
  return result;
}

ScalingFit fit_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                         std::array<double, 2> window) {
  return fit_replicated_power_law(log_x, log_y, window).fit;
}

}  // namespace granuscope
