#include "measure.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/layer_spectrum.h"
#include "analysis/line_fit.h"
#include "analysis/line_test.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

/// Modes of the plateau: those that have decayed by exp(-saturated) since the top, and are long against beads.
constexpr double saturated = 4, largest_k = 0.5;
constexpr double nearly_saturated = 0.9;  ///< beyond, the law says no more than that there is a plateau
constexpr std::size_t tested_shapes = 3;
constexpr const char* unknown_lags = "the response is not known at every lag; give more piles";

}  // namespace

LoadedPiles measure_loaded(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  return {ensemble.spec, load_line(ensemble.spec.sampler), block_mean(sums, "thrust", 0),
          block_mean(sums, "thrust", sums.layers.size() - 1)};
}

Estimate difference_of(const Replicated& one, const Replicated& other) {
  return estimate(transform([](double a, double b) { return a - b; }, one, other));
}

Estimate largest_change_with_depth(const CoupledSpreading& one) {
  Estimate largest{0, 1, {}};
  for (const auto* loads : {&one.leaning, &one.turned}) {
    for (const LoadedPiles& piles : *loads) {
      const Estimate change = difference_of(piles.thrust_below, piles.thrust);
      const auto errors = [](const Estimate& of) { return std::abs(of.value) / of.standard_error; };
      if (errors(change) > errors(largest)) largest = change;
    }
  }
  return largest;
}

ThrustCurvature fit_thrust(const std::vector<LoadedPiles>& piles, double LoadLine::*x, Replicated* curvature) {
  ThrustCurvature result;
  std::vector<double> squares, weights;
  std::vector<Replicated> thrust;
  for (const LoadedPiles& one : piles) {
    squares.push_back(one.line.*x * one.line.*x);
    weights.push_back(std::pow(estimate(one.thrust).standard_error, -2));
    thrust.push_back(one.thrust);
  }
  const auto fit = [&](const std::vector<double>& y) { return fit_parabola(squares, y, weights); };
  result.at_zero = estimate(transform_all(thrust, [&](const auto& y) { return fit(y).intercept; }));
  const Replicated second = transform_all(thrust, [&](const auto& y) { return 2 * fit(y).slope; });
  result.curvature = estimate(second);
  result.test = test_parabola(squares, thrust);
  std::vector<Replicated> changes;
  changes.reserve(piles.size());
  for (const LoadedPiles& one : piles)
    changes.push_back(transform([](double a, double b) { return a - b; }, one.thrust_below, one.thrust));
  result.curvature_change = estimate(transform_all(changes, [&](const auto& y) { return 2 * fit(y).slope; }));
  if (curvature != nullptr) *curvature = second;
  return result;
}

namespace {

/// The plateau with replicates.
struct PlateauMeans {
  Replicated of_w, of_H, of_torque;
};

Plateau plateau_of(const LayerFluctuations& layer, double D, PlateauMeans& means) {
  Plateau plateau;
  plateau.layer = layer.layer;
  plateau.k_from = std::sqrt(saturated / (D * Lattice::depth(layer.layer)));
  plateau.k_to = largest_k;
  std::vector<Replicated> w, H, torque;
  for (std::size_t m = 0; m < layer.k.size(); ++m) {
    if (layer.k[m] < plateau.k_from || layer.k[m] > plateau.k_to) continue;
    w.push_back(layer.of_w[m]);
    H.push_back(layer.of_H[m]);
    torque.push_back(layer.of_torque[m]);
  }
  if (w.empty()) return plateau;
  means = {mean_of(w), mean_of(H), mean_of(torque)};
  plateau.of_w = estimate(means.of_w);
  plateau.of_H = estimate(means.of_H);
  plateau.of_torque = estimate(means.of_torque);
  plateau.ratio = estimate(transform([](double a, double b) { return b / a; }, means.of_w, means.of_H));
  return plateau;
}

SaturationTest test_saturation(const std::vector<SaturatingSpectrum>& spectra, double c_squared,
                               const PlateauMeans& plateau) {
  SaturationTest test;
  for (const SaturatingSpectrum& spectrum : spectra) {
    for (const BandOfFluctuations& band : spectrum.bands) {
      if (band.k_to > largest_k || !(band.saturation.value < nearly_saturated)) continue;
      const Estimate share =
          estimate(transform([&](double w, double H, double w_all,
                                 double H_all) { return (w + H / c_squared) / (w_all + H_all / c_squared); },
                             band.of_w, band.of_H, plateau.of_w, plateau.of_H));
      const double error = std::hypot(share.standard_error, band.saturation.standard_error);
      test.chi2 += std::pow((share.value - band.saturation.value) / error, 2);
      test.doubled_chi2 += std::pow((share.value - band.doubled) / error, 2);
      ++test.points;
    }
  }
  return test;
}

bool all_known(const DeepResponse& response) {
  return std::all_of(response.octaves.begin(), response.octaves.end(),
                     [](const OctaveOfDepth& octave) { return octave.D.known(); });
}

}  // namespace

CoupledSpreading measure_coupling(const MeasuredEnsemble& deep, std::vector<LoadedPiles> leaning,
                                  std::vector<LoadedPiles> turned, std::vector<LoadedPiles> twice_as_wide,
                                  Fluctuations fluctuations, std::vector<DeepResponse> checks, int threads) {
  CoupledSpreading result;
  result.mu = deep.spec.sampler.mu;
  result.response = measure_spreading(deep, DeepMeasurement::fluctuations, threads);
  result.leaning = std::move(leaning);
  result.turned = std::move(turned);
  result.twice_as_wide = std::move(twice_as_wide);
  result.layers = std::move(fluctuations.layers);
  result.spectra = saturating_spectra(result.layers, DiffusionOfWaves(result.response.bands));
  result.in_blocks = std::move(fluctuations.thrust);
  result.D_torque = estimate(fluctuations.D_torque);
  Replicated by_slope, by_torque;
  result.by_slope = fit_thrust(result.leaning, &LoadLine::slope, &by_slope);
  result.by_torque = fit_thrust(result.turned, &LoadLine::offset, &by_torque);
  const auto unknown = [&](const char* reason) {
    for (Estimate* one : {&result.to_itself, &result.to_torque, &result.fit.strength, &result.fit.D})
      one->reason = reason;
    return result;
  };
  if (!all_known(result.response)) return unknown(unknown_lags);
  PlateauMeans plateau;
  result.plateau = plateau_of(result.layers.back(), result.response.octaves.front().D.value, plateau);
  if (!result.plateau.of_H.known()) {
    for (Estimate* one : {&result.plateau.of_w, &result.plateau.of_H, &result.plateau.of_torque, &result.plateau.ratio,
                          &result.plateau.c_thrust_squared})
      one->reason = "no mode of the deepest layer is saturated";
    return unknown("no mode of the deepest layer is saturated; give deeper fluctuation_layers");
  }
  const Estimate& c = result.response.c_thrust;
  result.plateau.c_thrust_squared = {c.value * c.value, 2 * c.value * c.standard_error, {}};
  result.saturation = test_saturation(result.spectra, result.plateau.c_thrust_squared.value, plateau);
  result.to_itself =
      estimate(transform([](double A, double C_H) { return A * A * C_H / 144; }, by_slope, plateau.of_H));
  result.to_torque = estimate(transform([](double A, double C_t, double C_H) { return A * A * C_t * C_t / (36 * C_H); },
                                        by_torque, plateau.of_torque, plateau.of_H));
  const SpreadingTheory theory(result.response, result.D_torque.value);
  const Couplings both{result.to_itself.value, result.to_torque.value};
  const double error =
      std::hypot(result.to_itself.standard_error, result.to_torque.standard_error) / (both.to_itself + both.to_torque);
  result.predicted = predict(theory, result.response, both, error, threads);
  result.without_torque = predict(theory, result.response, {both.to_itself, 0},
                                  result.to_itself.standard_error / result.to_itself.value, threads);
  for (DeepResponse& check : checks) {
    CheckedSpreading checked{std::move(check), {}, {}};
    if (all_known(checked.response)) {
      const SpreadingTheory of_check(checked.response, result.D_torque.value);
      checked.predicted = predict(of_check, checked.response, both, error, threads);
      checked.fit = fit_strength(of_check, checked.response.slopes_of_width, both, checked.predicted.D, threads);
    } else {
      checked.fit.strength.reason = checked.fit.D.reason = unknown_lags;
    }
    result.checks.push_back(std::move(checked));
  }
  result.fit = fit_strength(theory, result.response.slopes_of_width, both, result.predicted.D, threads);
  const CoupledPeak solution = theory.peak(result.predicted.D, both);
  const ReferredPeak coupled{solution, theory.reference()};
  const std::size_t lags = result.response.lags.size();
  for (std::size_t i = lags - std::min(lags, tested_shapes); i < lags; ++i) {
    const LayerSpectrum spectrum = layer_spectrum(deep.record.sums, i + 1, 0);
    result.peaks.push_back(scaled_peak(spectrum, result.response.lags[i]));
    result.shapes.push_back(test_shape(spectrum, result.response.lags[i], coupled));
  }
  result.predicted_peak = scaled_peak(coupled, result.response.lags.back().z);
  return result;
}

}  // namespace granuscope
