#include "analysis/double_gaussian.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include "analysis/shape_fit.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;
/// exp(-45) = 3e-20 is nothing beside 1.
constexpr double largest_exponent = 45;
/// Without a width the aliases fall off only as 1/q; the fits never get there, and this bounds the work.
constexpr int most_aliases = 64;

/// In rings of the lattice: beyond it the first mode, exp(-2 (pi W/columns)^2), is nothing beside 1.
constexpr double widest_on_a_ring = 2;

/// Cosine and sine of an angle. (std::complex multiplies with a detour for infinities that costs more than the rest.)
struct PhaseOfMode {
  double cosine, sine;
};
PhaseOfMode phase_of(double angle) { return {std::cos(angle), std::sin(angle)}; }
PhaseOfMode turned(PhaseOfMode a, PhaseOfMode b) {
  return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine};
}

}  // namespace

std::vector<double> evaluate(const DoubleGaussian& shape, std::span<const double> x, int columns) {
  const double scale = 1 / (std::abs(shape.width) * std::numbers::sqrt2);
  // Mass of a Gaussian centred at 0 between a and b; differences of erfc keep the far tails accurate.
  const auto mass = [&](double a, double b) {
    return a > 0 ? (std::erfc(a * scale) - std::erfc(b * scale)) / 2
                 : (std::erfc(-b * scale) - std::erfc(-a * scale)) / 2;
  };
  if (std::abs(shape.width) > widest_on_a_ring * columns) return std::vector<double>(x.size(), 1.0 / columns);
  const int images = 1 + static_cast<int>(std::ceil(10 * std::abs(shape.width) / columns));
  std::vector<double> values;
  values.reserve(x.size());
  for (double centre : x) {
    double value = 0;
    for (int image = -images; image <= images; ++image) {
      const double at = centre + static_cast<double>(image) * columns;
      value += mass(at - shape.peak - 0.5, at - shape.peak + 0.5) + mass(at + shape.peak - 0.5, at + shape.peak + 0.5);
    }
    values.push_back(value / 2);
  }
  return values;
}

double largest_value(const DoubleGaussian& shape) {
  // The maximum solves x = x_p tanh(x_p x / W^2); from x_p downwards the iteration falls monotonically onto it, or onto
  // the middle where x_p <= W.
  const double variance = shape.width * shape.width;
  double x = shape.peak;
  for (int round = 0; round < 100; ++round) {
    const double next = shape.peak * std::tanh(shape.peak * x / variance);
    if (x - next < 1e-12 * shape.peak) break;
    x = next;
  }
  const auto gaussian = [&](double at) { return std::exp(-at * at / (2 * variance)) / std::sqrt(two_pi * variance); };
  return (gaussian(x - shape.peak) + gaussian(x + shape.peak)) / 2;
}

void fourier_modes(const DoubleGaussian& shape, int columns, bool half_shifted, std::span<ModeValue> modes,
                   std::span<ModeValue> sines) {
  // Aliases k + 2 pi l with |k + 2 pi l| beyond q_max carry nothing.
  const double half_variance = shape.width * shape.width / 2;
  const double q_max = half_variance > 0 ? std::sqrt(largest_exponent / half_variance) : two_pi * most_aliases;
  // Bounded before it becomes an integer: a fit may try a width next to 0.
  const auto aliases =
      static_cast<int>(std::min<double>(most_aliases, std::floor((q_max + std::numbers::pi) / two_pi)));
  std::vector<PhaseOfMode> turn;  // 2 pi l x_p for l = -aliases .. aliases
  for (int l = -aliases; l <= aliases; ++l) turn.push_back(phase_of(two_pi * l * shape.peak));
  const PhaseOfMode step = phase_of(two_pi / columns * shape.peak), half_step = phase_of(std::numbers::pi / columns);
  PhaseOfMode phase{1, 0}, half_phase{1, 0};  // k x_p and k/2
  for (std::size_t m = 0; m < modes.size(); ++m) {
    phase = turned(phase, step);
    half_phase = turned(half_phase, half_step);
    const double k = two_pi * static_cast<double>(m + 1) / columns;
    ModeValue sum{0, 0, 0}, of_sine{0, 0, 0};
    for (int l = -aliases; l <= aliases; ++l) {
      const double q = k + two_pi * l;
      const double exponent = q * q * half_variance;
      if (exponent > largest_exponent) continue;
      // sin(q/2) = (-1)^l sin(k/2), and beads at half-integer x bring another (-1)^l.
      const double sign = !half_shifted && l % 2 != 0 ? -1 : 1;
      const double envelope = sign * std::exp(-exponent) * half_phase.sine / (q / 2);
      const PhaseOfMode wave = turned(phase, *(turn.begin() + l + aliases));
      sum.value += envelope * wave.cosine;
      sum.by_peak -= envelope * q * wave.sine;
      sum.by_width -= envelope * q * q * shape.width * wave.cosine;
      of_sine.value += envelope * wave.sine;
      of_sine.by_peak += envelope * q * wave.cosine;
      of_sine.by_width -= envelope * q * q * shape.width * wave.sine;
    }
    modes[m] = sum;
    if (!sines.empty()) sines[m] = of_sine;
  }
}

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

namespace {

/// The speed of deep peaks, that which follows from the thrust ratio (`granuscope sample --statistics` of 500 x 700
/// beads; errors below 0.001), by mu.
double deep_speed(double mu) {
  constexpr std::pair<double, double> known[] = {{0, tan30},     {0.1, 0.5748}, {0.2, 0.5674},
                                                 {0.3, 0.5559},  {0.4, 0.5418}, {0.5, 0.5272},
                                                 {0.65, 0.5193}, {0.8, 0.5302}, {1, 0.5531}};
  const auto above = std::lower_bound(std::next(std::begin(known)), std::prev(std::end(known)), std::pair(mu, 0.0));
  const auto below = std::prev(above);
  return std::lerp(below->second, above->second, (mu - below->first) / (above->first - below->first));
}

/// Deep down W^2 grows faster than z, by a tenth to a fifth in the exponent.
double deep_width(double mu, double z) {
  constexpr double usual = 100, faster = 0.2;
  return expected_width(mu, z) * std::pow(std::max(1.0, z / usual), faster / 2);
}

/// Whether the two peaks are apart in this layer of a ring.
bool are_apart(double mu, int layer, int ring) {
  constexpr double apart = 6, around = 12;  // widths: from one peak to the other, and the least of a ring
  constexpr double largest_mu = 1;          // of those whose speed is known well enough
  if (ring >= columns_needed(mu, layer)) return true;
  const double z = Lattice::depth(layer);
  const double width = deep_width(mu, z);
  return mu <= largest_mu && ring >= around * width &&
         2 * std::abs(std::remainder(deep_speed(mu) * z, ring / 2.0)) >= apart * width;
}

/// The fewest columns, from `columns` on, of a ring that suits each of these.
template <class Suits>
int fewest_columns_that_suit(const std::vector<double>& mu, const std::vector<int>& layers, int columns, Suits suits) {
  const auto suits_all = [&](int ring) {
    return std::ranges::all_of(mu, [&](double one) {
      return std::ranges::all_of(layers, [&](int layer) { return suits(one, layer, ring); });
    });
  };
  while (!suits_all(columns)) ++columns;
  return columns;
}

}  // namespace

int columns_apart(const std::vector<double>& mu, const std::vector<int>& layers, int columns) {
  return fewest_columns_that_suit(mu, layers, columns, are_apart);
}

int columns_of_waves(const std::vector<double>& mu, const std::vector<int>& layers, int columns) {
  return fewest_columns_that_suit(mu, layers, columns, [](double one, int layer, int ring) {
    return ring >= widths_of_ring * deep_width(one, Lattice::depth(layer));
  });
}

}  // namespace granuscope
