#include "analysis/power_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/line_fit.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Every point counts alike, whatever its error: a power law holds nowhere exactly, so that weights would change what
/// the exponent means. Weights from the errors, which follow the noise of these, gave beta a bias of an eighth of its
/// stated error, which was 8 % too small with 32 blocks, for an exponent 1 to 10 % more precise.
Line fit_alike(const std::vector<double>& x, const std::vector<double>& y) {
  return fit_line(x, y, std::vector<double>(x.size(), 1.0));
}

std::vector<double> values(const std::vector<Replicated>& numbers, std::size_t block, bool whole) {
  std::vector<double> result(numbers.size());
  std::transform(numbers.begin(), numbers.end(), result.begin(),
                 [&](const Replicated& number) { return whole ? number.value : number.without_block[block]; });
  return result;
}

/// What scatters across a curve is y less what of the curve depends on x, with x as uncertain as it is; adding the
/// curve back leaves a test against its own terms in x alone.
template <class Rest>
std::vector<Replicated> across(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                               const Rest& rest) {
  std::vector<Replicated> scatter;
  for (std::size_t i = 0; i < log_x.size(); ++i) {
    scatter.push_back(transform([&](double x, double y) { return y - rest(x); }, log_x[i], log_y[i]));
  }
  return scatter;
}

/// With coordinates from the middle of the points: their powers are then well apart.
RunningExponent fit_running_exponent(std::vector<Replicated> log_x, const std::vector<Replicated>& log_y) {
  RunningExponent running;
  if (log_x.size() < min_power_law_points + 1) {
    running.at_low.reason = running.at_high.reason = running.scatter.reason =
        fmt::format("an exponent that changes needs {} friction coefficients", min_power_law_points + 1);
    return running;
  }
  const std::vector<double> at = values(log_x, 0, true);
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  running.low = std::exp(*low);
  running.high = std::exp(*high);
  const double middle = (*low + *high) / 2, half = (*high - *low) / 2;
  for (Replicated& x : log_x) x = transform([&](double number) { return number - middle; }, x);
  const std::vector<double> ones(log_x.size(), 1.0);
  const Parabola whole = fit_parabola(values(log_x, 0, true), values(log_y, 0, true), ones);
  const auto slope = [&](const Parabola& one, double side) { return one.slope + 2 * side * half * one.curvature; };
  Replicated at_low{slope(whole, -1), {}}, at_high{slope(whole, 1), {}};
  for (std::size_t b = 0; b < log_x.front().without_block.size(); ++b) {
    const Parabola without = fit_parabola(values(log_x, b, false), values(log_y, b, false), ones);
    at_low.without_block.push_back(slope(without, -1));
    at_high.without_block.push_back(slope(without, 1));
  }
  running.at_low = estimate(at_low);
  running.at_high = estimate(at_high);
  running.scatter = test_parabola(
      values(log_x, 0, true), across(log_x, log_y, [&](double x) { return x * (whole.slope + x * whole.curvature); }));
  return running;
}

}  // namespace

ReplicatedPowerLaw fit_replicated_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                                            std::array<double, 2> window) {
  ReplicatedPowerLaw result;
  ScalingFit& fit = result.fit;
  fit.window = window;
  fit.points = static_cast<int>(log_x.size());
  if (fit.points < min_power_law_points) {
    fit.exponent.reason = fit.intercept.reason = fit.scatter.reason = fit.running.at_low.reason =
        fit.running.at_high.reason = fit.running.scatter.reason =
            fmt::format("the window from {} to {} holds usable results at {} value{}, an exponent needs {}", window[0],
                        window[1], fit.points, fit.points == 1 ? "" : "s", min_power_law_points);
    return result;
  }
  Replicated& exponent = result.exponent;
  Replicated intercept;
  const Line whole = fit_alike(values(log_x, 0, true), values(log_y, 0, true));
  exponent.value = whole.slope;
  intercept.value = whole.intercept;
  for (std::size_t b = 0; b < log_x.front().without_block.size(); ++b) {
    const Line line = fit_alike(values(log_x, b, false), values(log_y, b, false));
    exponent.without_block.push_back(line.slope);
    intercept.without_block.push_back(line.intercept);
  }
  const std::string reason = "a quantity is not positive without one of the blocks, so that its logarithm is undefined";
  fit.exponent = estimate(exponent, reason);
  fit.intercept = estimate(intercept, reason);
  if (!fit.exponent.known()) {
    fit.scatter.reason = fit.exponent.reason;
    fit.running.at_low.reason = fit.running.at_high.reason = fit.running.scatter.reason = fit.exponent.reason;
    return result;
  }
  fit.scatter = test_line(values(log_x, 0, true), across(log_x, log_y, [&](double x) { return whole.slope * x; }));
  fit.running = fit_running_exponent(log_x, log_y);
  return result;
}

ScalingFit fit_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                         std::array<double, 2> window) {
  return fit_replicated_power_law(log_x, log_y, window).fit;
}

std::string in_words(const RunningExponent& running, const char* of) {
  const auto text = [](const Estimate& exponent) { return value_with_error(exponent.value, exponent.standard_error); };
  return fmt::format("from {} at {} = {} to {} at {}", text(running.at_low), of, significant(running.low, 2),
                     text(running.at_high), significant(running.high, 2));
}

}  // namespace granuscope
