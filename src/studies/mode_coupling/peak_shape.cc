#include "peak_shape.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "best_step.h"
#include "kpz_peak.h"

namespace granuscope {
namespace {

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

}  // namespace

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

ScaledPeak scaled_peak(ReferredPeak coupled, double z) {
  const CoupledPeak& solution = coupled.solution;
  const DoubleGaussian shape = solution.shape_below(coupled.reference, z);
  const double from_c = shape.peak - solution.spec.c * z;
  ScaledPeak peak{z, scaled_places(), {}};
  for (const double x : peak.x) {
    const double density = solution.density_below(coupled.reference, z, from_c + x * shape.width);
    peak.height.push_back({shape.width * density, 0, {}});
  }
  return peak;
}

PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, ReferredPeak coupled) {
  const double peak = lag.peak_position.value, width = std::sqrt(lag.width_squared.value);
  PeakShapeTest test;
  test.z = lag.z;
  test.degrees_of_freedom = static_cast<int>(spectrum.whole.size()) - 2;
  test.gaussian = chi2_of(spectrum, peak, width, [](double k) { return std::complex(std::exp(-k * k / 2)); });
  test.kpz = chi2_of(spectrum, peak, width, [](double k) { return std::complex(kpz_peak().mode(k)); });
  const CoupledPeak& solution = coupled.solution;
  const double W = solution.shape_below(coupled.reference, lag.z).width;
  test.coupled =
      chi2_of(spectrum, peak, width, [&](double k) { return solution.mode_below(coupled.reference, lag.z, k / W); });
  return test;
}

}  // namespace granuscope
