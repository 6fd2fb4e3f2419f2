#include "analysis/response_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "analysis/double_gaussian.h"
#include "analysis/shape_fit.h"

namespace granuscope {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double narrowest = 0.3;    ///< bead diameters
constexpr double coarse_step = 1.3;  ///< ratio of neighbouring widths of a scan
constexpr double no_response = 30;   ///< k s, beyond which an elastic response has no modes
constexpr double precision = 1e-3;   ///< relative; chi^2 is flat to second order at its minimum

double chi2_of(const LayerSpectrum& spectrum, const std::vector<double>& modes, const std::vector<ModeValue>& model) {
  double sum = 0;
  for (std::size_t i = 0; i < model.size(); ++i) {
    const double residual = (model[i].value - modes[i]) / spectrum.noise[i];
    sum += residual * residual;
  }
  return sum;
}

/// The smallest value of f over widths: a scan that no local minimum can fool, then a golden section.
template <typename F>
std::pair<double, double> least_over_widths(double widest, F f) {
  double scanned = narrowest, best_width = narrowest, best = infinite;
  while (scanned < widest) {
    if (const double value = f(scanned); value < best) best = value, best_width = scanned;
    scanned *= coarse_step;
  }
  constexpr double golden = 0.6180339887498949;
  double low = best_width / coarse_step, high = best_width * coarse_step;
  double left = high - golden * (high - low), right = low + golden * (high - low);
  double at_left = f(left), at_right = f(right);
  while (high - low > precision * best_width) {
    if (at_left <= at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = f(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = f(right);
    }
  }
  const double width = (low + high) / 2;
  return {width, std::min(best, f(width))};
}

/// Modes of an elastic shape, integrated over the beads. What sampling at their centres folds back is exp(-2 pi s).
std::vector<ModeValue> elastic_modes(const LayerSpectrum& spectrum, double s, double a) {
  std::vector<ModeValue> modes(spectrum.whole.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const double k = 2 * std::numbers::pi * static_cast<double>(i + 1) / spectrum.columns, q = k * s;
    if (q > no_response) break;
    const double turned = a > 0 ? std::cos(a * q) + std::sin(a * q) / a : 1 + q;
    modes[i].value = turned * std::exp(-q) * std::sin(k / 2) / (k / 2);
  }
  return modes;
}

FittedResponseShape fit_gaussian(const LayerSpectrum& spectrum, const std::vector<double>& data) {
  std::vector<ModeValue> modes(spectrum.whole.size());
  const auto [width, chi2] = least_over_widths(0.5 * spectrum.columns, [&](double W) {
    fourier_modes({0, W}, spectrum.columns, spectrum.half_shifted, modes);
    return chi2_of(spectrum, data, modes);
  });
  return {chi2, 0, width};
}

FittedResponseShape fit_elastic(const LayerSpectrum& spectrum, double a) {
  const auto [s, chi2] = least_over_widths(0.5 * spectrum.columns, [&](double width) {
    return chi2_of(spectrum, spectrum.whole, elastic_modes(spectrum, width, a));
  });
  return {chi2, a > 1 ? s * std::sqrt(a * a - 1) : 0, s};
}

/// Over a, with the best s at each.
FittedResponseShape fit_orthotropic(const LayerSpectrum& spectrum) {
  constexpr double most = 30, first_step = 0.5;
  FittedResponseShape best = fit_elastic(spectrum, 0);
  double best_a = 0;
  const auto try_a = [&](double a) {
    if (a < 0) return;
    if (const FittedResponseShape one = fit_elastic(spectrum, a); one.chi2 < best.chi2) best = one, best_a = a;
  };
  double a = first_step;
  while (a < most) {
    try_a(a);
    a *= coarse_step;
  }
  double step = std::max(first_step, 0.3 * best_a);
  while (step > 1e-3 * std::max(1.0, best_a)) {
    const double centre = best_a;
    try_a(centre - step);
    try_a(centre + step);
    step /= 2;
  }
  return best;
}

}  // namespace

std::string name_of(ResponseShape shape) {
  constexpr std::array names = {"two Gaussians", "one Gaussian", "isotropic elastic", "orthotropic elastic"};
  return names[static_cast<std::size_t>(shape)];
}

FittedResponseShapes fit_response_shapes(const LayerSpectrum& spectrum, double z) {
  const FittedResponseShape one = fit_gaussian(spectrum, spectrum.whole);
  FittedResponseShape two = one;
  if (const auto fit = fit_shape(spectrum, coarse_shape(spectrum, z)); fit && fit->chi2 < one.chi2) {
    two = {fit->chi2, fit->shape.peak, fit->shape.width};
  }
  return {two, one, fit_elastic(spectrum, 0), fit_orthotropic(spectrum)};
}

ResponseShape best_shape(const FittedResponseShapes& fits) {
  using enum ResponseShape;
  const auto chi2 = [&](ResponseShape shape) { return fits[static_cast<std::size_t>(shape)].chi2; };
  const ResponseShape simple = chi2(one_gaussian) <= chi2(isotropic) ? one_gaussian : isotropic;
  const ResponseShape rich = chi2(two_gaussians) <= chi2(orthotropic) ? two_gaussians : orthotropic;
  return chi2(simple) - chi2(rich) > decisive_shape_chi2 ? rich : simple;
}

double single_width_squared(const LayerSpectrum& spectrum, const std::vector<double>& modes) {
  const double width = fit_gaussian(spectrum, modes).width;
  return width * width;
}

}  // namespace granuscope
