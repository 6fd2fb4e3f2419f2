#include <gsl/gsl_sf_airy.h>
#include <algorithm>
#include <array>
#include <cstddef>
#include <numbers>
#include <span>

#include "studies/sound_form.h"

namespace granuscope {
namespace {

// Everything follows from u, the solution of u'' = s u + 2 u^3 that ends as -Ai(s), and from a and b of
//   a' = u b,   b' = u a - w b,   a -> 1, b -> -exp(w^3/3 - s w) for s -> infinity.
// With F(s) = exp(-V(s)), V'' = u^2, V -> 0, the height at y has the distribution function
//   d/ds [F(s + y^2) g(s + y^2, y)],   g(s, w) = integral of a(x, w) a(x, -w) over x < s, which is s - w^2 for large s.
// All are integrated downwards by their Taylor series: errors of u grow as exp(0.94 |s|^1.5) below 0, where F falls as
// exp(-|s|^3/12).
using Real = long double;
constexpr std::size_t order = 24;
constexpr Real step_of_s = 0.125L, lowest = -7.5L;
constexpr Real negligible = -45;  ///< log of what couples b to a at the start

using PowerSeries = std::array<Real, order + 1>;

/// Coefficient n of the product of two series.
Real product(const PowerSeries& one, const PowerSeries& other, std::size_t n) {
  Real sum = 0;
  for (std::size_t i = 0; i <= n; ++i) sum += one[i] * other[n - i];
  return sum;
}

Real value(const PowerSeries& series, Real at) {
  Real sum = 0;
  for (std::size_t n = order + 1; n-- > 0;) sum = sum * at + series[n];
  return sum;
}

PowerSeries derivative(const PowerSeries& series) {
  PowerSeries result{};
  for (std::size_t n = 1; n <= order; ++n) result[n - 1] = static_cast<Real>(n) * series[n];
  return result;
}

/// The series that begins with `first`.
PowerSeries antiderivative(const PowerSeries& series, Real first) {
  PowerSeries result{first};
  for (std::size_t n = 1; n <= order; ++n) result[n] = series[n - 1] / static_cast<Real>(n);
  return result;
}

/// u around s.
PowerSeries solution(Real s, Real u, Real slope) {
  PowerSeries series{u, slope}, square{};
  for (std::size_t n = 0; n + 2 <= order; ++n) {
    square[n] = product(series, series, n);
    const Real linear = s * series[n] + (n > 0 ? series[n - 1] : 0);
    series[n + 2] = (linear + 2 * product(square, series, n)) / static_cast<Real>((n + 1) * (n + 2));
  }
  return series;
}

/// a and b.
struct Pair {
  PowerSeries a{}, b{};
};
Pair pair_around(const PowerSeries& u, Real w, Real a, Real b) {
  Pair pair{{a}, {b}};
  for (std::size_t n = 0; n < order; ++n) {
    const auto next = static_cast<Real>(n + 1);
    pair.a[n + 1] = product(u, pair.b, n) / next;
    pair.b[n + 1] = (product(u, pair.a, n) - w * pair.b[n]) / next;
  }
  return pair;
}

/// s from which on a is 1.
Real highest(Real w) {
  Real s = std::max<Real>(12, w * w);
  while (-2 * std::pow(s, Real{1.5}) / 3 + s * w - w * w * w / 3 > negligible) s += 1;
  return s;
}

/// Gauss and Legendre's points of [0, 1] and their weights.
constexpr std::array<std::array<Real, 2>, 5> points = {{{0.046910077030668003601L, 0.11846344252809454376L},
                                                        {0.23076534494715845448L, 0.23931433524968323402L},
                                                        {0.5L, 0.28444444444444444444L},
                                                        {0.76923465505284154552L, 0.23931433524968323402L},
                                                        {0.95308992296933199640L, 0.11846344252809454376L}}};

}  // namespace

double stationary_height_variance(double y) {
  const Real w = std::abs(y), top = highest(w);
  Real u = -gsl_sf_airy_Ai(static_cast<double>(top), GSL_PREC_DOUBLE);
  Real slope = -gsl_sf_airy_Ai_deriv(static_cast<double>(top), GSL_PREC_DOUBLE);
  Real a = 1, b = -std::exp(w * w * w / 3 - top * w), c = 1, d = -std::exp(top * w - w * w * w / 3);
  Real U = 0, V = 0, g = top - w * w;  // U = -V'
  // The mean being 0, the variance is twice the integral of F g - max(s - w^2, 0).
  Real variance = -(top - w * w) * (top - w * w);
  for (Real s = top; s > lowest;) {
    const Real step = std::min(step_of_s, s - lowest);
    const PowerSeries u_here = solution(s, u, slope), u_slope = derivative(u_here);
    const Pair plus = pair_around(u_here, w, a, b), minus = pair_around(u_here, -w, c, d);
    PowerSeries square{}, density{};
    for (std::size_t n = 0; n <= order; ++n) {
      square[n] = product(u_here, u_here, n);
      density[n] = product(plus.a, minus.a, n);
    }
    PowerSeries U_here = antiderivative(square, -U);  // V'
    const PowerSeries V_here = antiderivative(U_here, V), g_here = antiderivative(density, g);
    for (const auto& [at, weight] : points) {
      variance += 2 * weight * step * std::exp(-value(V_here, -at * step)) * value(g_here, -at * step);
    }
    U = -value(U_here, -step);
    V = value(V_here, -step);
    g = value(g_here, -step);
    u = value(u_here, -step);
    slope = value(u_slope, -step);
    a = value(plus.a, -step), b = value(plus.b, -step);
    c = value(minus.a, -step), d = value(minus.b, -step);
    s -= step;
  }
  return static_cast<double>(variance);
}

double KpzPeak::mode(double k) const {
  // The trapezoidal rule is exact for a smooth shape but for exp(-(2 pi/step)^2/...).
  const double scale = k / std::sqrt(variance);
  double sum = density.front() / 2;
  for (std::size_t i = 1; i < density.size(); ++i) sum += density[i] * std::cos(scale * step * static_cast<double>(i));
  return 2 * step * sum;
}

namespace {

/// Central differences of eighth order for a second derivative.
constexpr std::array<double, 5> second_difference = {-205.0 / 72, 8.0 / 5, -1.0 / 5, 8.0 / 315, -1.0 / 560};
constexpr std::size_t entries = 42;  // up to y = 4.1

KpzPeak make_kpz_peak() {
  std::vector<double> height;
  for (std::size_t i = 0; i < entries + second_difference.size() - 1; ++i)
    height.push_back(stationary_height_variance(KpzPeak::step * static_cast<double>(i)));
  KpzPeak peak;
  for (std::size_t i = 0; i < entries; ++i) {
    double second = second_difference[0] * height[i];
    for (std::size_t j = 1; j < second_difference.size(); ++j)
      second += second_difference[j] * (height[i + j] + height[i < j ? j - i : i - j]);
    peak.density.push_back(second / (4 * KpzPeak::step * KpzPeak::step));
  }
  for (std::size_t i = 1; i < entries; ++i) {
    const double y = KpzPeak::step * static_cast<double>(i);
    peak.variance += 2 * KpzPeak::step * y * y * peak.density[i];
  }
  return peak;
}

}  // namespace

const KpzPeak& kpz_peak() {
  static const KpzPeak peak = make_kpz_peak();
  return peak;
}

namespace {

constexpr std::size_t tested_lags = 3;

std::span<const LagResponse> deepest_lags(const DeepResponse& response) {
  return std::span(response.lags).last(std::min(response.lags.size(), tested_lags));
}

LayerSpectrum spectrum_of(const MeasuredEnsemble& deep, const LagResponse& lag) {
  const BlockSums& sums = deep.record.sums;
  return layer_spectrum(sums, static_cast<std::size_t>(std::ranges::find(sums.layers, lag.lag) - sums.layers.begin()),
                        0);
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
    const TwoNumbers change = least_squares(here, less(here, residuals(peak + h, width), h),
                                            less(here, residuals(peak, width + h), h), alike);
    const double of_peak = change.first, of_width = change.second;
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

ScaledPeak scaled_peak(const SoundForm& form, double z, int columns) {
  const DoubleGaussian shape = form.shape(z, columns);
  ScaledPeak peak{z, scaled_places(), {}};
  for (const double x : peak.x) {
    double sum = 1;
    for (int m = 1; m <= (columns - 1) / 2; ++m) {
      const double k = 2 * std::numbers::pi * m / columns;
      sum += 2 * (form.mode(k, z) * std::polar(1.0, k * (shape.peak + x * shape.width))).real();
    }
    peak.height.push_back({shape.width * sum / columns, 0, {}});
  }
  return peak;
}

PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, const SoundForm& form) {
  const double peak = lag.peak_position.value, width = std::sqrt(lag.width_squared.value);
  PeakShapeTest test;
  test.z = lag.z;
  test.degrees_of_freedom = static_cast<int>(spectrum.whole.size()) - 2;
  test.gaussian = chi2_of(spectrum, peak, width, [](double k) { return std::complex(std::exp(-k * k / 2)); });
  test.kpz = chi2_of(spectrum, peak, width, [](double k) { return std::complex(kpz_peak().mode(k)); });
  test.levy = std::nan("");
  if (form.D == 0) return test;
  // By its own x_p and W.
  const DoubleGaussian shape = form.shape(lag.z, spectrum.columns);
  test.levy = chi2_of(spectrum, peak, width, [&](double k) {
    return form.mode(k / shape.width, lag.z) * std::polar(1.0, k / shape.width * shape.peak);
  });
  return test;
}

std::vector<PeakShapeTest> test_shapes(const MeasuredEnsemble& deep, const DeepResponse& response,
                                       const SoundForm& form) {
  std::vector<PeakShapeTest> shapes;
  for (const LagResponse& lag : deepest_lags(response)) shapes.push_back(test_shape(spectrum_of(deep, lag), lag, form));
  return shapes;
}

std::vector<ScaledPeak> scaled_peaks(const MeasuredEnsemble& deep, const DeepResponse& response) {
  std::vector<ScaledPeak> peaks;
  for (const LagResponse& lag : deepest_lags(response)) peaks.push_back(scaled_peak(spectrum_of(deep, lag), lag));
  return peaks;
}

void to_json(Json& json, const PeakShapeTest& test) {
  json = {{"z", test.z},
          {"degrees_of_freedom", test.degrees_of_freedom},
          {"chi2_gaussian", finite_or_null(test.gaussian)},
          {"chi2_kpz", finite_or_null(test.kpz)},
          {"chi2_levy", finite_or_null(test.levy)}};
}

}  // namespace granuscope
