#include "analysis/scaling.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "analysis/power_law.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

/// The reader of a window such as [0.1, 0.3] expects both ends inside.
constexpr double window_slack = 1e-9;

struct Points {
  std::vector<Replicated> x, y;  ///< logarithms
  ReplicatedPowerLaw fit(std::array<double, 2> window) const { return fit_replicated_power_law(x, y, window); }
};

struct ReplicatedFits {
  ReplicatedPowerLaw beta, gamma, alpha;
  ScalingFits shown() const { return {beta.fit, gamma.fit, alpha.fit}; }
};

/// c and D of one ensemble, however they were read.
struct Coefficients {
  double scanned;
  const Replicated& c;
  const Replicated& D;
};

ReplicatedFits fit_all(const std::vector<Coefficients>& coefficients, std::array<double, 2> window) {
  Points beta, gamma, alpha;
  for (const Coefficients& one : coefficients) {
    if (one.scanned < window[0] - window_slack || one.scanned > window[1] + window_slack) continue;
    const Replicated log_scanned = transform([&](double) { return std::log(one.scanned); }, one.c);
    const Replicated log_D = transform([](double D) { return std::log(D); }, one.D);
    const Replicated log_slowing = transform([](double c) { return std::log(tan30 - c); }, one.c);
    const bool D_usable = estimate(log_D).known(), slowing_usable = estimate(log_slowing).known();
    if (D_usable) beta.x.push_back(log_scanned), beta.y.push_back(log_D);
    if (slowing_usable) gamma.x.push_back(log_scanned), gamma.y.push_back(log_slowing);
    if (D_usable && slowing_usable) alpha.x.push_back(log_D), alpha.y.push_back(log_slowing);
  }
  return {beta.fit(window), gamma.fit(window), alpha.fit(window)};
}

std::vector<Coefficients> slopes_of(const std::vector<MeasuredTransport>& results) {
  std::vector<Coefficients> slopes;
  for (const MeasuredTransport& result : results) {
    const Transport& t = result.transport;
    if (!t.exact && t.c.known() && t.D.known()) slopes.push_back({t.scanned(), result.c, result.D});
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
      slopes.push_back({t.scanned(), variation->c, variation->D});
    } else {
      slopes.push_back({t.scanned(), result.c, result.D});
    }
  }
  return slopes;
}

Estimate shift_between(const ReplicatedPowerLaw& moved, const ReplicatedPowerLaw& from) {
  if (!from.fit.exponent.known()) return {.reason = from.fit.exponent.reason};
  if (!moved.fit.exponent.known()) return {.reason = moved.fit.exponent.reason};
  return estimate(transform([](double a, double b) { return a - b; }, moved.exponent, from.exponent));
}

ScalingVariation variation_of(const ReplicatedFits& fits, const std::string& change, const ReplicatedFits& moved) {
  return {change, moved.shown(), shift_between(moved.beta, fits.beta), shift_between(moved.gamma, fits.gamma),
          shift_between(moved.alpha, fits.alpha)};
}

}  // namespace

ScalingFits fit_scaling(const std::vector<MeasuredTransport>& results, std::array<double, 2> window) {
  return fit_all(slopes_of(results), window).shown();
}

ScalingWithVariations fit_scaling_with_variations(const std::vector<MeasuredTransport>& results,
                                                  std::array<double, 2> window) {
  const std::vector<Coefficients> slopes = slopes_of(results);
  const ReplicatedFits fits = fit_all(slopes, window);
  ScalingWithVariations all{fits.shown(), {}};
  const auto with_variations = std::find_if(results.begin(), results.end(),
                                            [](const MeasuredTransport& result) { return !result.variations.empty(); });
  if (with_variations != results.end()) {
    for (std::size_t k = 0; k < with_variations->variations.size(); ++k) {
      all.variations.push_back(
          variation_of(fits, with_variations->variations[k].shown.change, fit_all(varied_slopes(results, k), window)));
    }
  }
  std::vector<double> values;
  for (const Coefficients& one : slopes) {
    if (one.scanned >= window[0] - window_slack && one.scanned <= window[1] + window_slack)
      values.push_back(one.scanned);
  }
  if (values.size() > min_power_law_points) {
    all.variations.push_back(variation_of(fits, "without_lowest_mu", fit_all(slopes, {values[1], window[1]})));
    all.variations.push_back(
        variation_of(fits, "without_highest_mu", fit_all(slopes, {window[0], values[values.size() - 2]})));
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

RatioScaling fit_ratio_scaling(const std::vector<MeasuredTransport>& results, int layer, std::array<double, 2> window) {
  // The load acts at the centre of a top bead, half a bead below the surface from which z counts.
  const RowGeometry rows = results.empty() ? RowGeometry{} : rows_of(results.front().transport.spec.sampler.model);
  const double z = rows.depth(layer), below_load = z - rows.depth(0);
  const auto from_load = [&](double per_depth) { return per_depth * z / below_load; };
  std::vector<MeasuredRatios> shifted;
  std::vector<Coefficients> ratios, shifted_ratios;
  shifted.reserve(results.size());
  for (const MeasuredTransport& result : results) {
    if (result.transport.exact) continue;
    for (const MeasuredRatios& one : result.ratios) {
      if (one.layer != layer) continue;
      ratios.push_back({result.transport.scanned(), one.position, one.width_squared});
      shifted.push_back({layer, transform(from_load, one.position), transform(from_load, one.width_squared)});
      shifted_ratios.push_back({result.transport.scanned(), shifted.back().position, shifted.back().width_squared});
    }
  }
  return {layer, z, fit_all(ratios, window).shown(), fit_all(shifted_ratios, window).shown()};
}

}  // namespace granuscope
