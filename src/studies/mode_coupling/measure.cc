#include "measure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "analysis/layer_spectrum.h"
#include "analysis/line_fit.h"
#include "analysis/line_test.h"
#include "ensemble/fluctuation_plan.h"
#include "ensemble/parallel.h"
#include "kpz_peak.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double most_steps = 768;  ///< of z down to the deepest lag
constexpr int most_iterations = 12;
constexpr double least_D = 0.05;  ///< of the first octave's
/// Modes of the plateau: those that have decayed by exp(-saturated) since the top, and are long against beads.
constexpr double saturated = 4, largest_k = 0.5;
constexpr double nearly_saturated = 0.9;  ///< beyond, the law says no more than that there is a plateau
constexpr std::size_t tested_shapes = 3;

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

/// x_p and W^2 at the lags, and D of the bands that were measured.
struct Spreading {
  std::vector<double> peak, width_squared, D_of_bands;
};

std::vector<double> slopes_of(const std::vector<double>& y, const std::vector<double>& z) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i + 1 < z.size(); ++i) slopes.push_back((y[i + 1] - y[i]) / (z[i + 1] - z[i]));
  return slopes;
}

/// The two couplings of a peak.
struct Couplings {
  double to_itself = 0, to_torque = 0;
  Couplings times(double factor) const { return {factor * to_itself, factor * to_torque}; }
};

/// What the theory says about the recorded lags.
class Theory {
 public:
  Theory(const DeepResponse& response, double D_torque)
      : bands_(response.bands),
        columns_(response.spec.lattice.columns),
        c_(response.c_thrust.value),
        D_torque_(D_torque) {
    for (const LagResponse& lag : response.lags) z_.push_back(lag.z);
    const FluctuationPlan plan = fluctuation_plan(response.spec);
    saturated_by_ = Lattice::depth((plan.bases.front() + plan.bases.back()) / 2);
    reference_ = Lattice::depth(plan.reference) - Lattice::depth(0);
    while (ring_ < 2.4 * c_ * depth()) ring_ *= 2;
    torque_ = torque_kernels(spec(0, {}));
  }
  CoupledPeak peak(double D, Couplings couplings) const { return solve_coupled_peak(spec(D, couplings), torque_); }
  Spreading spreading(double D, Couplings couplings) const {
    const CoupledPeak solved = peak(D, couplings);
    Spreading result;
    for (const double z : z_) {
      const DoubleGaussian shape = solved.shape_below(reference_, z);
      result.peak.push_back(shape.peak);
      result.width_squared.push_back(shape.width * shape.width);
    }
    for (const BandOfModes& band : bands_) result.D_of_bands.push_back(D_of(band, solved));
    return result;
  }
  /// Slopes of W^2 over the octaves.
  std::vector<double> slopes(double D, Couplings couplings) const {
    return slopes_of(spreading(D, couplings).width_squared, z_);
  }
  /// D with which the first slope is as measured. The slope is D and a part that hardly depends on it.
  double D_for(double first_slope, Couplings couplings) const {
    double D = 0.8 * first_slope;
    for (int i = 0; i < most_iterations; ++i) {
      const double change = first_slope - slopes(D, couplings).front();
      D = std::max(least_D * first_slope, D + change);
      if (std::abs(change) < 2e-4 * first_slope) break;
    }
    return D;
  }
  const std::vector<double>& z() const { return z_; }

 private:
  /// The mean over a band, a mode counting as in the fit of what is measured (analysis/dispersion.h).
  double D_of(const BandOfModes& band, const CoupledPeak& solved) const {
    const double first = 2 * std::numbers::pi / columns_, z = band.z_to - band.z_from;
    double sum = 0, weights = 0;
    const auto at = [&](double below, double k) { return std::abs(solved.mode_at(reference_ + below, k)); };
    for (int m = static_cast<int>(std::ceil(band.k_from / first)); m * first < band.k_to; ++m) {
      const double k = m * first;
      const double left = at(band.z_to, k) / at(band.z_from, k);
      const double weight = std::pow(k * k * left, 2);
      sum -= weight * 2 * std::log(left) / (k * k * z);
      weights += weight;
    }
    return sum / weights;
  }
  double depth() const { return reference_ + z_.back(); }
  CouplingSpec spec(double D, Couplings couplings) const {
    // A whole number of steps to the first lag, and so to all.
    const double least = std::max(1.0, z_.back() / most_steps);
    return {.D = D,
            .c = c_,
            .to_itself = couplings.to_itself,
            .to_torque = couplings.to_torque,
            .D_torque = D_torque_,
            .depth = depth(),
            .step = z_.front() / std::ceil(z_.front() / least),
            .ring = ring_,
            .saturated_by = saturated_by_};
  }

  std::vector<double> z_;
  std::vector<BandOfModes> bands_;
  int columns_;
  double c_, D_torque_, saturated_by_ = 0, reference_ = 0;  ///< the last: depth of the lag 0 below the base
  int ring_ = 512;
  TorqueKernels torque_;
};

bool all_known(const DeepResponse& response) {
  return std::all_of(response.octaves.begin(), response.octaves.end(),
                     [](const OctaveOfDepth& octave) { return octave.D.known(); });
}

/// W^2 at the lags from its slopes.
std::vector<double> widths_of(const std::vector<double>& slopes, double first, const std::vector<double>& z) {
  std::vector<double> widths{first};
  for (std::size_t i = 0; i < slopes.size(); ++i) widths.push_back(widths.back() + slopes[i] * (z[i + 1] - z[i]));
  return widths;
}

/// Of the octaves behind the first.
double chi2_of(const PredictedSpreading& predicted, const DeepResponse& response) {
  double sum = 0;
  for (std::size_t i = 1; i < predicted.slopes.size(); ++i) {
    const Estimate &D = response.octaves[i].D, &slope = predicted.slopes[i];
    sum += std::pow((D.value - slope.value) / std::hypot(D.standard_error, slope.standard_error), 2);
  }
  return sum;
}

/// The prediction, of which nothing is free but the D of the first octave. `error`: of the couplings, relative.
PredictedSpreading predict(const Theory& theory, const DeepResponse& response, Couplings couplings, double error,
                           int threads) {
  PredictedSpreading result;
  const Estimate& first = response.octaves.front().D;
  const Couplings more = couplings.times(1 + error);
  const double faster = first.value + first.standard_error;
  Spreading spreading, with_more, with_faster;
  for_each_index(3, threads, [&](std::size_t which) {
    if (which == 0) {
      result.D = theory.D_for(first.value, couplings);
      spreading = theory.spreading(result.D, couplings);
    } else if (which == 1) {
      with_more = theory.spreading(theory.D_for(first.value, more), more);
    } else {
      with_faster = theory.spreading(theory.D_for(faster, couplings), couplings);
    }
  });
  const std::vector<double> by_coupling = slopes_of(with_more.width_squared, theory.z()),
                            by_first = slopes_of(with_faster.width_squared, theory.z());
  for (std::size_t i = 0; i < spreading.D_of_bands.size(); ++i) {
    const double D = spreading.D_of_bands[i];
    result.D_of_bands.push_back({D, std::hypot(with_more.D_of_bands[i] - D, with_faster.D_of_bands[i] - D), {}});
  }
  const std::vector<double> slopes = slopes_of(spreading.width_squared, theory.z());
  const double offset = response.lags.front().width_squared.value;
  const auto widths = [&](const std::vector<double>& of) { return widths_of(of, offset, theory.z()); };
  result.width_squared = widths(slopes);
  result.c = slopes_of(spreading.peak, theory.z());
  const std::vector<double> a = widths(by_coupling), b = widths(by_first);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double here = result.width_squared[i];
    result.width_squared_error.push_back(std::hypot(a[i] - here, b[i] - here));
  }
  for (std::size_t i = 0; i < slopes.size(); ++i)
    result.slopes.push_back({slopes[i], std::hypot(by_coupling[i] - slopes[i], by_first[i] - slopes[i]), {}});
  result.chi2 = chi2_of(result, response);
  return result;
}

/// The step in two parameters that takes the residuals away best, by least squares: residuals, their derivatives with
/// opposite sign, and weights.
std::array<double, 2> best_step(const std::vector<double>& residual, const std::vector<double>& by_first,
                                const std::vector<double>& by_second, const std::vector<double>& weight) {
  double aa = 0, ab = 0, bb = 0, ar = 0, br = 0;
  for (std::size_t i = 0; i < residual.size(); ++i) {
    aa += weight[i] * by_first[i] * by_first[i];
    ab += weight[i] * by_first[i] * by_second[i];
    bb += weight[i] * by_second[i] * by_second[i];
    ar += weight[i] * by_first[i] * residual[i];
    br += weight[i] * by_second[i] * residual[i];
  }
  const double determinant = aa * bb - ab * ab;
  return {(ar * bb - br * ab) / determinant, (br * aa - ar * ab) / determinant};
}

/// (one - other)/step.
std::vector<double> difference(const std::vector<double>& one, const std::vector<double>& other, double step = 1) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.size(); ++i) result.push_back((one[i] - other[i]) / step);
  return result;
}

/// D and the couplings' strength that describe the slopes of all octaves best, by Gauss and Newton's steps from the
/// prediction; errors by taking the slopes' replicates through the last step. Slopes of different octaves hardly depend
/// on each other.
void fit(const Theory& theory, const std::vector<Replicated>& measured, Couplings couplings, int threads,
         CoupledSpreading& result) {
  std::vector<double> y, weight;
  for (const Replicated& slope : measured) {
    y.push_back(slope.value);
    weight.push_back(std::pow(estimate(slope).standard_error, -2));
  }
  double D = result.predicted.D, strength = 1;
  std::vector<double> by_D, by_strength;
  for (int step = 0; step < most_iterations; ++step) {
    const double dD = 1e-2 * D, ds = 0.02;
    std::vector<double> model;
    for_each_index(3, threads, [&](std::size_t which) {
      if (which == 0) model = theory.slopes(D, couplings.times(strength));
      if (which == 1) by_D = theory.slopes(D + dD, couplings.times(strength));
      if (which == 2) by_strength = theory.slopes(D, couplings.times(strength + ds));
    });
    by_D = difference(by_D, model, dD);
    by_strength = difference(by_strength, model, ds);
    const auto [of_D, of_strength] = best_step(difference(y, model), by_D, by_strength, weight);
    D = std::max(0.3 * D, D + of_D);
    strength = std::max(0.0, strength + of_strength);
    if (std::abs(of_D) < 1e-3 * D && std::abs(of_strength) < 1e-3) break;
  }
  const auto chi2 = [&](const std::vector<double>& model) {
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += weight[i] * std::pow(y[i] - model[i], 2);
    return sum;
  };
  result.fitted_chi2 = chi2(theory.slopes(D, couplings.times(strength)));
  result.fitted_degrees_of_freedom = static_cast<int>(y.size()) - 2;
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    sum += weight[i] * y[i];
    weights += weight[i];
  }
  result.diffusion_chi2 = chi2(std::vector<double>(y.size(), sum / weights));
  const auto parameter = [&](std::size_t which, double value) {
    return estimate(transform_all(measured, [&, which, value](const std::vector<double>& slopes) {
      return value + best_step(difference(slopes, y), by_D, by_strength, weight)[which];
    }));
  };
  result.fitted_D = parameter(0, D);
  result.strength = parameter(1, strength);
}

/// chi^2 of the peaks mode(k W) exp(-i k x_p) and their mirror images with the best x_p and W.
template <typename Mode>
double chi2_of(const LayerSpectrum& spectrum, double peak, double width, Mode mode) {
  const auto residuals = [&](double x, double W) {
    std::vector<double> result;
    for (std::size_t m = 0; m < spectrum.whole.size(); ++m) {
      const double k = 2 * std::numbers::pi * static_cast<double>(m + 1) / spectrum.columns;
      const double modelled = (mode(k * W) * std::polar(1.0, -k * x)).real();
      result.push_back((spectrum.whole[m] - modelled) / spectrum.noise[m]);
    }
    return result;
  };
  const std::vector<double> alike(spectrum.whole.size(), 1.0);
  std::vector<double> here = residuals(peak, width);
  for (int step = 0; step < 30; ++step) {
    const double h = 1e-4 * width;
    const auto [of_peak, of_width] = best_step(here, difference(here, residuals(peak + h, width), h),
                                               difference(here, residuals(peak, width + h), h), alike);
    const double size = std::hypot(of_peak, of_width), part = std::min(1.0, 0.3 * width / size);
    peak += part * of_peak;
    width += part * of_width;
    here = residuals(peak, width);
    if (size < 1e-6 * width) break;
  }
  double chi2 = 0;
  for (const double one : here) chi2 += one * one;
  return chi2;
}

/// How far scaled peaks reach, in widths, and how fine they are.
constexpr double reach = 4, fineness = 0.1;

std::vector<double> scaled_places() {
  std::vector<double> x;
  for (int i = 0; i <= static_cast<int>(2 * reach / fineness); ++i) x.push_back(fineness * i - reach);
  return x;
}

/// By cosines and sines, which know the one peak from the other, however near that is on the ring.
ScaledPeak scaled_peak(const LayerSpectrum& spectrum, const LagResponse& lag) {
  const double W = std::sqrt(lag.width_squared.value);
  ScaledPeak peak{lag.z, scaled_places(), {}};
  for (const double x : peak.x) {
    const double angle = 2 * std::numbers::pi * (lag.peak_position.value + x * W) / spectrum.columns;
    const auto height = [&](ResponseModes modes) {
      double sum = 1;
      for (std::size_t m = 0; m < modes.cosines.size(); ++m) {
        const double turned = angle * static_cast<double>(m + 1);
        sum += 2 * (modes.cosines[m] * std::cos(turned) + modes.sines[m] * std::sin(turned));
      }
      return W * sum / spectrum.columns;
    };
    Replicated replicates{height(spectrum.modes()), {}};
    for (std::size_t b = 0; b < spectrum.without_block.size(); ++b)
      replicates.without_block.push_back(height(spectrum.modes_without(b)));
    peak.height.push_back(estimate(replicates));
  }
  return peak;
}

ScaledPeak scaled_peak(const CoupledPeak& coupled, double z) {
  const DoubleGaussian shape = coupled.shape(z);
  const double from_c = shape.peak - coupled.spec.c * z;
  ScaledPeak peak{z, scaled_places(), {}};
  for (const double x : peak.x)
    peak.height.push_back({shape.width * coupled.density(z, from_c + x * shape.width), 0, {}});
  return peak;
}

PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, const CoupledPeak& coupled) {
  const double peak = lag.peak_position.value, width = std::sqrt(lag.width_squared.value);
  PeakShapeTest test;
  test.z = lag.z;
  test.degrees_of_freedom = static_cast<int>(spectrum.whole.size()) - 2;
  test.gaussian = chi2_of(spectrum, peak, width, [](double k) { return std::complex(std::exp(-k * k / 2)); });
  test.kpz = chi2_of(spectrum, peak, width, [](double k) { return std::complex(kpz_peak().mode(k)); });
  const double W = coupled.shape(lag.z).width;
  test.coupled = chi2_of(spectrum, peak, width, [&](double k) { return coupled.mode_at(lag.z, k / W); });
  return test;
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
    for (Estimate* one : {&result.to_itself, &result.to_torque, &result.strength, &result.fitted_D})
      one->reason = reason;
    return result;
  };
  if (!all_known(result.response)) return unknown("the response is not known at every lag; give more piles");
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
  const Theory theory(result.response, result.D_torque.value);
  const Couplings both{result.to_itself.value, result.to_torque.value};
  const double error =
      std::hypot(result.to_itself.standard_error, result.to_torque.standard_error) / (both.to_itself + both.to_torque);
  result.predicted = predict(theory, result.response, both, error, threads);
  result.without_torque = predict(theory, result.response, {both.to_itself, 0},
                                  result.to_itself.standard_error / result.to_itself.value, threads);
  for (DeepResponse& check : checks) {
    const double chi2 = chi2_of(result.predicted, check);
    result.checks.push_back({std::move(check), chi2});
  }
  fit(theory, result.response.slopes_of_width, both, threads, result);
  const CoupledPeak coupled = theory.peak(result.predicted.D, both);
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
