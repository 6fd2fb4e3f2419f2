#include "studies/mode_coupling/fields.h"

#include <gsl/gsl_sf_airy.h>
#include <array>
#include <cstddef>
#include <numbers>

namespace granuscope {
namespace {

constexpr double longest_of_beads = 0.5;  ///< of k: shorter waves see single beads
constexpr double most_error = 0.25;       ///< of the D of a band
constexpr std::size_t fewest_bands = 3;
constexpr double forgotten = 1e-9;  ///< of a mode: what is left of it counts no more
constexpr int most_steps = 50;

bool tells(const BandOfModes& band) {
  return band.k < longest_of_beads && band.D.known() && band.D.value > 0 &&
         band.D.standard_error < most_error * band.D.value;
}

std::vector<double> depths_of(const DeepResponse& response) {
  std::vector<double> z;
  for (const LagResponse& lag : response.lags) z.push_back(lag.z);
  return z;
}

FormTest spread_from_first(const SoundForm& form, const DeepResponse& response) {
  FormTest test;
  const std::vector<double> z = depths_of(response);
  test.slopes = form.slopes(z, response.spec.lattice.columns);
  test.width_squared = {response.lags.front().width_squared.value};
  for (std::size_t i = 0; i < test.slopes.size(); ++i) {
    test.width_squared.push_back(test.width_squared.back() + test.slopes[i] * (z[i + 1] - z[i]));
  }
  return test;
}

/// chi^2 of the octaves from number `first` on; `variance`: of the slopes of the form.
void hold_against(const DeepResponse& response, std::size_t first, const std::vector<double>& variance,
                  FormTest& test) {
  for (std::size_t i = first; i < test.slopes.size(); ++i) {
    const Estimate& D = response.octaves[i].D;
    test.chi2 += std::pow(D.value - test.slopes[i], 2) / (std::pow(D.standard_error, 2) + variance[i]);
    ++test.octaves;
  }
}

}  // namespace

TwoNumbers least_squares(const std::vector<double>& y, const std::vector<double>& by_first,
                         const std::vector<double>& by_second, const std::vector<double>& weight) {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    aa += weight[i] * by_first[i] * by_first[i];
    ab += weight[i] * by_first[i] * by_second[i];
    bb += weight[i] * by_second[i] * by_second[i];
    ay += weight[i] * by_first[i] * y[i];
    by += weight[i] * by_second[i] * y[i];
  }
  const double determinant = aa * bb - ab * ab;
  return {(ay * bb - by * ab) / determinant, (by * aa - ay * ab) / determinant, bb / determinant, aa / determinant,
          -ab / determinant};
}

std::vector<double> less(const std::vector<double>& one, const std::vector<double>& other, double step) {
  std::vector<double> result;
  for (std::size_t i = 0; i < one.size(); ++i) result.push_back((one[i] - other[i]) / step);
  return result;
}

std::complex<double> SoundForm::mode(double k, double z) const {
  const double fed = B * std::pow(k, 1.5) * z;
  return std::polar(std::exp(-D * k * k * z / 2 - fed), -c * k * z - fed);
}

DoubleGaussian SoundForm::shape(double z, int columns) const {
  LayerSpectrum spectrum;
  spectrum.columns = columns;
  for (int m = 1; m <= (columns - 1) / 2; ++m) {
    const std::complex<double> f = mode(2 * std::numbers::pi * m / columns, z);
    if (std::abs(f) < forgotten) break;
    spectrum.whole.push_back(f.real());
    spectrum.sines.whole.push_back(-f.imag());
  }
  // A wave of the length of the peak tells how wide it is.
  double W = std::sqrt(D * z);
  for (int i = 0; i < 5; ++i) W = std::sqrt((D + 2 * B * std::sqrt(W)) * z);
  auto fitted = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {c * z + B * z / std::sqrt(W), W});
  if (!fitted) throw InputError("two Gaussians do not fit to the form of a peak of sound");
  // The fit gives the nearest of the places that are one on the ring; sound is here or at its mirror image.
  const auto on_ring = [&](double x) { return c * z + std::remainder(x - c * z, columns); };
  const double here = on_ring(fitted->peak), mirrored = on_ring(-fitted->peak);
  fitted->peak = std::abs(here - c * z) < std::abs(mirrored - c * z) ? here : mirrored;
  return *fitted;
}

std::vector<double> SoundForm::slopes(const std::vector<double>& z, int columns) const {
  std::vector<double> slopes, squares;
  for (const double at : z) squares.push_back(std::pow(shape(at, columns).width, 2));
  for (std::size_t i = 0; i + 1 < z.size(); ++i) slopes.push_back((squares[i + 1] - squares[i]) / (z[i + 1] - z[i]));
  return slopes;
}

double fed_by(double coupling, double D_field, double c) { return coupling / std::sqrt(8 * D_field * c); }

FormFit fit_waves(const std::vector<BandOfModes>& bands) {
  FormFit fit;
  std::vector<double> D, ones, slow, weight;
  for (const BandOfModes& band : bands) {
    if (!tells(band)) continue;
    D.push_back(band.D.value);
    ones.push_back(1);
    slow.push_back(2 / std::sqrt(band.k));
    weight.push_back(std::pow(band.D.standard_error, -2));
  }
  if (D.size() < fewest_bands) {
    fit.D.reason = fit.B.reason = "D is known of fewer than three bands of waves";
    return fit;
  }
  const TwoNumbers found = least_squares(D, ones, slow, weight);
  fit.D = {found.first, std::sqrt(found.first_variance), {}};
  fit.B = {found.second, std::sqrt(found.second_variance), {}};
  fit.D_B = found.covariance;
  for (std::size_t i = 0; i < D.size(); ++i) {
    fit.chi2 += weight[i] * std::pow(D[i] - found.first - found.second * slow[i], 2);
  }
  fit.degrees_of_freedom = static_cast<int>(D.size()) - 2;
  return fit;
}

FormFit fit_widths(const DeepResponse& response, double D, double B) {
  std::vector<double> y, weight, by_D, by_B, model;
  for (const Replicated& slope : response.slopes_of_width) {
    y.push_back(slope.value);
    weight.push_back(std::pow(estimate(slope).standard_error, -2));
  }
  const std::vector<double> z = depths_of(response);
  const double c = response.c_thrust.value;
  const auto slopes = [&](double of_D, double of_B) {
    return SoundForm{c, of_D, of_B}.slopes(z, response.spec.lattice.columns);
  };
  for (int step = 0; step < most_steps; ++step) {
    const double dD = 1e-3 * D, dB = 1e-3 * std::max(B, 1e-3 * D);
    model = slopes(D, B);
    by_D = less(slopes(D + dD, B), model, dD);
    by_B = less(slopes(D, B + dB), model, dB);
    const TwoNumbers change = least_squares(less(y, model), by_D, by_B, weight);
    D = std::max(0.3 * D, D + change.first);
    B = std::max(0.0, B + change.second);
    if (std::abs(change.first) < 1e-6 * D && std::abs(change.second) < 1e-6 * D) break;
  }
  const auto number = [&](double TwoNumbers::*which, double value) {
    return transform_all(response.slopes_of_width, [&, which, value](const std::vector<double>& others) {
      return value + least_squares(less(others, y), by_D, by_B, weight).*which;
    });
  };
  FormFit fit;
  fit.D = estimate(number(&TwoNumbers::first, D));
  fit.B = estimate(number(&TwoNumbers::second, B));
  fit.D_B = least_squares(y, by_D, by_B, weight).covariance;
  for (std::size_t i = 0; i < y.size(); ++i) fit.chi2 += weight[i] * std::pow(y[i] - model[i], 2);
  fit.degrees_of_freedom = static_cast<int>(y.size()) - 2;
  return fit;
}

FormTest test_waves(const FormFit& fit, const DeepResponse& response) {
  const SoundForm form{response.c_thrust.value, fit.D.value, fit.B.value};
  FormTest test = spread_from_first(form, response);
  const double dD = 1e-3 * form.D, dB = 1e-3 * form.B;
  const std::vector<double> z = depths_of(response);
  const int columns = response.spec.lattice.columns;
  const std::vector<double> by_D = less(SoundForm{form.c, form.D + dD, form.B}.slopes(z, columns), test.slopes, dD),
                            by_B = less(SoundForm{form.c, form.D, form.B + dB}.slopes(z, columns), test.slopes, dB);
  std::vector<double> variance;
  for (std::size_t i = 0; i < by_D.size(); ++i) {
    variance.push_back(std::pow(by_D[i] * fit.D.standard_error, 2) + std::pow(by_B[i] * fit.B.standard_error, 2) +
                       2 * by_D[i] * by_B[i] * fit.D_B);
  }
  hold_against(response, 0, variance, test);
  return test;
}

FormTest test_coupling(const Estimate& B, const DeepResponse& response, SoundForm& form) {
  const std::vector<double> z = depths_of(response);
  const Estimate& first = response.octaves.front().D;
  const auto with = [&](double of_B, double first_slope) {
    SoundForm one{response.c_thrust.value, 0.8 * first_slope, of_B};
    for (int step = 0; step < most_steps; ++step) {
      const double missing = first_slope - one.slopes({z[0], z[1]}, response.spec.lattice.columns).front();
      one.D = std::max(0.3 * one.D, one.D + missing);
      if (std::abs(missing) < 1e-7 * first_slope) break;
    }
    return one;
  };
  form = with(B.value, first.value);
  FormTest test = spread_from_first(form, response);
  const std::vector<double> by_B = spread_from_first(with(B.value + B.standard_error, first.value), response).slopes;
  const std::vector<double> by_first =
      spread_from_first(with(B.value, first.value + first.standard_error), response).slopes;
  std::vector<double> variance;
  for (std::size_t i = 0; i < by_B.size(); ++i) {
    variance.push_back(std::pow(by_B[i] - test.slopes[i], 2) + std::pow(by_first[i] - test.slopes[i], 2));
  }
  hold_against(response, 1, variance, test);
  return test;
}

SpeedTest test_speeds(const FormFit& fit, const DeepResponse& response) {
  SpeedTest test;
  const double c = response.c_thrust.value;
  double products = 0, squares = 0;
  for (const BandOfModes& band : response.bands) {
    if (!tells(band) || !band.c.known()) continue;
    const double faster = std::sqrt(band.k), measured = band.c.value - c, said = fit.B.value * faster;
    const double variance = std::pow(band.c.standard_error, 2), of_form = std::pow(fit.B.standard_error * faster, 2);
    products += measured * said / variance;
    squares += said * said / variance;
    test.chi2 += std::pow(measured - said, 2) / (variance + of_form);
    test.chi2_of_none += measured * measured / variance;
    ++test.bands;
  }
  if (squares == 0) {
    test.ratio.reason = "the speed of no band of waves is known";
    return test;
  }
  const double ratio = products / squares;
  test.ratio = {ratio, std::hypot(1 / std::sqrt(squares), ratio * fit.B.standard_error / fit.B.value), {}};
  return test;
}

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

}  // namespace granuscope
