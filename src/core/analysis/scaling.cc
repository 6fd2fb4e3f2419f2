#include "analysis/scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// The reader of a window such as [0.1, 0.3] expects both ends inside.
constexpr double window_slack = 1e-9;

struct Points {
  std::vector<Replicated> x, y;  ///< logarithms
  int without = 0;               ///< values in the window where one of them is unknown

  /// `what` has no logarithm there.
  ReplicatedPowerLaw fit(std::array<double, 2> window, const char* what) const {
    return fit_replicated_power_law(
        x, y, window, without > 0 ? fmt::format("; at {} more {} is not above 0 by its noise", without, what) : "");
  }
};

Replicated logarithm_of_D(const Coefficients& one) {
  return transform([](double D) { return std::log(D); }, one.D);
}
Replicated logarithm_of_slowing(const Coefficients& one) {
  return transform([&](double c) { return std::log(one.c0 - c); }, one.c);
}

}  // namespace

ReplicatedFits fit_coefficients(const std::vector<Coefficients>& coefficients, std::array<double, 2> window) {
  Points beta, gamma, alpha;
  for (const Coefficients& one : coefficients) {
    if (one.scanned <= 0 || one.scanned < window[0] - window_slack || one.scanned > window[1] + window_slack) continue;
    const Replicated log_scanned = transform([&](double) { return std::log(one.scanned); }, one.c);
    const Replicated log_D = logarithm_of_D(one), log_slowing = logarithm_of_slowing(one);
    const bool D_usable = estimate(log_D).known(), slowing_usable = estimate(log_slowing).known();
    const auto add = [](Points& points, bool usable, const Replicated& x, const Replicated& y) {
      if (!usable) return void(++points.without);
      points.x.push_back(x), points.y.push_back(y);
    };
    add(beta, D_usable, log_scanned, log_D);
    add(gamma, slowing_usable, log_scanned, log_slowing);
    add(alpha, D_usable && slowing_usable, log_D, log_slowing);
  }
  return {beta.fit(window, "D"), gamma.fit(window, "c₀ − c"), alpha.fit(window, "D or c₀ − c")};
}

namespace {

std::vector<Coefficients> slopes_of(const std::vector<MeasuredTransport>& results) {
  std::vector<Coefficients> slopes;
  for (const MeasuredTransport& result : results) {
    const Transport& t = result.transport;
    if (!t.exact && t.c.known() && t.D.known()) slopes.push_back({t.scanned(), result.c, result.D, t.c0()});
  }
  return slopes;
}

/// The slopes from variation number k of each fit, and from the fit itself where there is none.
std::vector<Coefficients> varied_slopes(const std::vector<MeasuredTransport>& results, std::size_t k) {
  std::vector<Coefficients> slopes;
  for (const MeasuredTransport& result : results) {
    const Transport& t = result.transport;
    if (t.exact || !t.c.known() || !t.D.known()) continue;
    const VariationSlopes* const variation = k < result.variations.size() ? &result.variations[k] : nullptr;
    if (variation != nullptr && variation->shown.c.known() && variation->shown.D.known()) {
      slopes.push_back({t.scanned(), variation->c, variation->D, t.c0()});
    } else {
      slopes.push_back({t.scanned(), result.c, result.D, t.c0()});
    }
  }
  return slopes;
}

Estimate shift_between(const ReplicatedPowerLaw& moved, const ReplicatedPowerLaw& from) {
  if (!from.fit.exponent.known()) return {.reason = from.fit.exponent.reason};
  if (!moved.fit.exponent.known()) return {.reason = moved.fit.exponent.reason};
  return estimate(transform([](double a, double b) { return a - b; }, moved.exponent, from.exponent));
}

/// "; fit.scaling_window = [0.2, 0.5] holds 4": the window nearest to one with too few values that holds one more than
/// an exponent needs; "" where there are not even as many as it needs.
std::string other_window(const std::vector<Coefficients>& slopes, std::array<double, 2> window) {
  std::vector<double> usable;
  for (const Coefficients& one : slopes) {
    const bool known = estimate(logarithm_of_D(one)).known() && estimate(logarithm_of_slowing(one)).known();
    if (known && one.scanned > 0) usable.push_back(one.scanned);
  }
  if (usable.size() < min_power_law_points) return "";
  const std::size_t held = std::min<std::size_t>(usable.size(), min_power_law_points + 1);
  const auto distance = [&](std::size_t first) {
    return std::abs(usable[first] - window[0]) + std::abs(usable[first + held - 1] - window[1]);
  };
  std::size_t nearest = 0;
  for (std::size_t first = 1; first + held <= usable.size(); ++first) {
    if (distance(first) < distance(nearest)) nearest = first;
  }
  return fmt::format("; fit.scaling_window = [{}, {}] holds {}", usable[nearest], usable[nearest + held - 1], held);
}

}  // namespace

ScalingVariation variation_of(const ReplicatedFits& from, const std::string& change, const ReplicatedFits& moved) {
  return {change, moved.shown(), shift_between(moved.beta, from.beta), shift_between(moved.gamma, from.gamma),
          shift_between(moved.alpha, from.alpha)};
}

ScalingFits fit_scaling(const std::vector<MeasuredTransport>& results, std::array<double, 2> window) {
  return fit_coefficients(slopes_of(results), window).shown();
}

ScalingWithVariations fit_scaling_with_variations(const std::vector<MeasuredTransport>& results,
                                                  std::array<double, 2> window) {
  const std::vector<Coefficients> slopes = slopes_of(results);
  const ReplicatedFits fits = fit_coefficients(slopes, window);
  ScalingWithVariations all{fits.shown(), {}};
  for (ScalingFit* const one : {&all.fits.beta, &all.fits.gamma, &all.fits.alpha}) {
    if (one->points < min_power_law_points) one->exponent.reason += other_window(slopes, window);
  }
  const auto with_variations =
      std::ranges::find_if(results, [](const MeasuredTransport& result) { return !result.variations.empty(); });
  if (with_variations != results.end()) {
    for (std::size_t k = 0; k < with_variations->variations.size(); ++k) {
      all.variations.push_back(variation_of(fits, with_variations->variations[k].shown.change,
                                            fit_coefficients(varied_slopes(results, k), window)));
    }
  }
  std::vector<double> values;
  for (const Coefficients& one : slopes) {
    if (one.scanned >= window[0] - window_slack && one.scanned <= window[1] + window_slack)
      values.push_back(one.scanned);
  }
  if (values.size() > min_power_law_points) {
    all.variations.push_back(variation_of(fits, "without_lowest_mu", fit_coefficients(slopes, {values[1], window[1]})));
    all.variations.push_back(
        variation_of(fits, "without_highest_mu", fit_coefficients(slopes, {window[0], values[values.size() - 2]})));
  }
  const auto spread_of = [&](Estimate ScalingVariation::*shift) {
    std::vector<Estimate> shifts;
    for (const ScalingVariation& variation : all.variations) shifts.push_back(variation.*shift);
    return systematic_spread(shifts);
  };
  all.fits.beta.exponent.systematic = spread_of(&ScalingVariation::beta_shift);
  all.fits.gamma.exponent.systematic = spread_of(&ScalingVariation::gamma_shift);
  all.fits.alpha.exponent.systematic = spread_of(&ScalingVariation::alpha_shift);
  return all;
}

namespace {

/// Every point counts alike, whatever its error: a power law holds nowhere exactly, so that weights would change what
/// the exponent means. Weights from the errors, which follow the noise of these, gave beta a bias of an eighth of its
/// stated error, which was 8 % too small with 32 blocks, for an exponent 1 to 10 % more precise.
Line fit_alike(const std::vector<double>& x, const std::vector<double>& y) {
  return fit_line(x, y, std::vector<double>(x.size(), 1.0));
}

std::vector<double> logs_of(const std::vector<Replicated>& numbers, std::size_t block, bool whole) {
  std::vector<double> result(numbers.size());
  std::ranges::transform(numbers, result.begin(),
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
  const std::vector<double> at = logs_of(log_x, 0, true);
  const auto [low, high] = std::ranges::minmax_element(at);
  running.low = std::exp(*low);
  running.high = std::exp(*high);
  const double middle = (*low + *high) / 2, half = (*high - *low) / 2;
  for (Replicated& x : log_x) x = transform([&](double number) { return number - middle; }, x);
  const std::vector<double> ones(log_x.size(), 1.0);
  const Parabola whole = fit_parabola(logs_of(log_x, 0, true), logs_of(log_y, 0, true), ones);
  const auto slope = [&](const Parabola& one, double side) { return one.slope + 2 * side * half * one.curvature; };
  Replicated at_low{slope(whole, -1), {}}, at_high{slope(whole, 1), {}};
  for (std::size_t b = 0; b < log_x.front().without_block.size(); ++b) {
    const Parabola without = fit_parabola(logs_of(log_x, b, false), logs_of(log_y, b, false), ones);
    at_low.without_block.push_back(slope(without, -1));
    at_high.without_block.push_back(slope(without, 1));
  }
  running.at_low = estimate(at_low);
  running.at_high = estimate(at_high);
  running.scatter = test_parabola(
      logs_of(log_x, 0, true), across(log_x, log_y, [&](double x) { return x * (whole.slope + x * whole.curvature); }));
  return running;
}

}  // namespace

ReplicatedPowerLaw fit_replicated_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                                            std::array<double, 2> window, const std::string& missing) {
  ReplicatedPowerLaw result;
  ScalingFit& fit = result.fit;
  fit.window = window;
  fit.points = static_cast<int>(log_x.size());
  if (fit.points < min_power_law_points) {
    fit.exponent.reason = fit.intercept.reason = fit.scatter.reason = fit.running.at_low.reason =
        fit.running.at_high.reason = fit.running.scatter.reason =
            fmt::format("the window from {} to {} holds usable results at {} value{}, an exponent needs {}{}",
                        window[0], window[1], fit.points, fit.points == 1 ? "" : "s", min_power_law_points, missing);
    return result;
  }
  Replicated& exponent = result.exponent;
  Replicated intercept;
  const Line whole = fit_alike(logs_of(log_x, 0, true), logs_of(log_y, 0, true));
  exponent.value = whole.slope;
  intercept.value = whole.intercept;
  for (std::size_t b = 0; b < log_x.front().without_block.size(); ++b) {
    const Line line = fit_alike(logs_of(log_x, b, false), logs_of(log_y, b, false));
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
  fit.scatter = test_line(logs_of(log_x, 0, true), across(log_x, log_y, [&](double x) { return whole.slope * x; }));
  fit.running = fit_running_exponent(log_x, log_y);
  return result;
}

ScalingFit fit_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                         std::array<double, 2> window) {
  return fit_replicated_power_law(log_x, log_y, window).fit;
}

std::string in_words(const RunningExponent& running, const char* of) {
  return fmt::format("from {} at {} = {} to {} at {}", value_with_error(running.at_low), of,
                     significant(running.low, 2), value_with_error(running.at_high), significant(running.high, 2));
}

namespace {

/// What is averaged of one friction coefficient.
struct Averaged {
  const Estimate& shown;
  const Replicated& replicated;
};

template <typename Pick>
Estimate average(const std::vector<MeasuredTransport>& results, double tolerance, Pick pick) {
  std::vector<Replicated> numbers;
  std::vector<double> weights;
  double total = 0;
  Estimate unknown{.reason = "the experiment contains no friction above 0"};
  for (const MeasuredTransport& result : results) {
    if (result.transport.exact) continue;
    const Averaged one = pick(result);
    if (!one.shown.known()) {
      if (!result.transport.is_frictionless()) unknown.reason = one.shown.reason;
      continue;
    }
    numbers.push_back(one.replicated);
    weights.push_back(1 / (one.shown.standard_error * one.shown.standard_error + tolerance * tolerance));
    total += weights.back();
  }
  if (numbers.empty()) return unknown;
  return estimate(transform_all(numbers, [&](const std::vector<double>& values) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i];
    return sum / total;
  }));
}

Estimate average_exponent(const std::vector<MeasuredTransport>& results, double tolerance,
                          Estimate Exponents::*exponent, Replicated ReplicatedExponents::*replicated) {
  return average(results, tolerance, [&](const MeasuredTransport& result) {
    return Averaged{result.transport.exponents.*exponent, result.exponents.*replicated};
  });
}

}  // namespace

Exponents average_exponents(const std::vector<MeasuredTransport>& results, double tolerance) {
  return {average_exponent(results, tolerance, &Exponents::position, &ReplicatedExponents::position),
          average_exponent(results, tolerance, &Exponents::width, &ReplicatedExponents::width),
          average_exponent(results, tolerance, &Exponents::amplitude, &ReplicatedExponents::amplitude),
          average_exponent(results, tolerance, &Exponents::noise, &ReplicatedExponents::noise)};
}

Estimate average_position_offset(const std::vector<MeasuredTransport>& results) {
  return average(results, 0, [](const MeasuredTransport& result) {
    return Averaged{result.transport.position_offset, result.position_offset};
  });
}

std::string reason_against_pairs(const Replicated& response_thrust, const Replicated& thrust) {
  const Estimate difference = estimate(transform([](double a, double b) { return a - b; }, response_thrust, thrust));
  if (!difference.known()) return "the thrust of the pairs' response is unknown: " + difference.reason;
  const double allowed = std::max(coupling_bias_errors * difference.standard_error, coupling_bias_rounding);
  if (std::abs(difference.value) <= allowed) return {};
  return fmt::format(
      "the numbers that beads keep have been chosen by the first solution, and piles solved from them follow another "
      "law: their response has the thrust ratio {} where that of the law is {}",
      value_with_error(response_thrust.value, estimate(response_thrust).standard_error),
      value_with_error(thrust.value, estimate(thrust).standard_error));
}

}  // namespace granuscope
