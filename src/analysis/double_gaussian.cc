#include "analysis/double_gaussian.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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
struct Phase {
  double cosine, sine;
};
Phase phase_of(double angle) { return {std::cos(angle), std::sin(angle)}; }
Phase turned(Phase a, Phase b) {
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

ModeValue fourier_mode(const DoubleGaussian& shape, int mode, int columns, bool half_shifted) {
  const double k = two_pi * mode / columns;
  ModeValue sum{0, 0, 0};
  const auto add = [&](int l) {
    const double q = k + two_pi * l;
    const double exponent = q * q * shape.width * shape.width / 2;
    if (exponent > largest_exponent) return false;
    const double bin = q == 0 ? 1.0 : std::sin(q / 2) / (q / 2);
    const double envelope = (half_shifted && l % 2 != 0 ? -1 : 1) * std::exp(-exponent) * bin;
    const double cosine = std::cos(q * shape.peak);
    sum.value += envelope * cosine;
    sum.by_peak -= envelope * q * std::sin(q * shape.peak);
    sum.by_width -= envelope * q * q * shape.width * cosine;
    return true;
  };
  add(0);
  for (int l = 1; l <= most_aliases; ++l) {
    const bool minus = add(-l), plus = add(l);
    if (!minus && !plus) break;
  }
  return sum;
}

void fourier_modes(const DoubleGaussian& shape, int columns, bool half_shifted, std::span<ModeValue> modes,
                   std::span<ModeValue> sines) {
  // Aliases k + 2 pi l with |k + 2 pi l| beyond q_max carry nothing.
  const double half_variance = shape.width * shape.width / 2;
  const double q_max = half_variance > 0 ? std::sqrt(largest_exponent / half_variance) : two_pi * most_aliases;
  // Bounded before it becomes an integer: a fit may try a width next to 0.
  const auto aliases =
      static_cast<int>(std::min<double>(most_aliases, std::floor((q_max + std::numbers::pi) / two_pi)));
  std::vector<Phase> turn;  // 2 pi l x_p for l = -aliases .. aliases
  for (int l = -aliases; l <= aliases; ++l) turn.push_back(phase_of(two_pi * l * shape.peak));
  const Phase step = phase_of(two_pi / columns * shape.peak), half_step = phase_of(std::numbers::pi / columns);
  Phase phase{1, 0}, half_phase{1, 0};  // k x_p and k/2
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
      const Phase wave = turned(phase, *(turn.begin() + l + aliases));
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

}  // namespace granuscope
