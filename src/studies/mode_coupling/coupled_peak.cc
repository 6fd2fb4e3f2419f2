#include "coupled_peak.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "analysis/weighted_shape.h"
#include "ensemble/real_spectrum.h"
#include "support/error.h"

namespace granuscope {
namespace {

using Complex = std::complex<double>;
using Modes = std::vector<Complex>;

constexpr int corrections = 1;      ///< of the kernel at the end of a step, which the step's own end enters
constexpr double forgotten = 1e-9;  ///< of a mode: what is left of it counts no more
/// What must be left of a mode that others are referred to: exp(-(3^2)/2), as of those of fluctuations
/// (ensemble/fluctuation_plan.h).
constexpr double least_referred_to = 0.0111;

double wave_number(const CouplingSpec& spec, std::size_t mode) {
  return 2 * std::numbers::pi * static_cast<double>(mode) / spec.ring;
}

std::size_t steps_of(const CouplingSpec& spec) { return static_cast<std::size_t>(std::ceil(spec.depth / spec.step)); }

/// Parts of a step in which kernels are averaged. At s = 0 a kernel falls as s^(-1/2), faster than long steps see.
int parts_of(const CouplingSpec& spec) { return std::max(1, static_cast<int>(spec.step)); }

/// Calls add(s, weight) for the parts of the two steps (for n = 0 the one) around step n: the weights, of sum 1, fall
/// to both sides, as a straight line between the steps has it.
template <typename Add>
void around_step(const CouplingSpec& spec, std::size_t n, Add add) {
  const int parts = parts_of(spec);
  if (parts == 1) return add(spec.step * static_cast<double>(n), 1.0);
  double sum = 0;
  const int first = n == 0 ? 0 : -parts;
  const auto weight = [&](int part) { return parts - std::abs(part + 0.5); };
  for (int part = first; part < parts; ++part) sum += weight(part);
  for (int part = first; part < parts; ++part)
    add(spec.step * (static_cast<double>(n) + (part + 0.5) / parts), weight(part) / sum);
}

/// How much of the mode k of the kernel is there of a correlation over s that had the depth `built_up` to build up. All
/// of it is the square of a Gaussian of variance a = D s; missing is the product of that with one of variance
/// b = D (s + 2 built_up). No product is narrower than a bead. Every mode in turn, from k = 0 on.
class BuiltUp {
 public:
  BuiltUp(double D, double s, double built_up, double first_k) {
    constexpr double narrowest = 1 / (2 * std::numbers::pi);  // of a + b: the product of beads is 1
    const double a = D * s, b = D * (s + 2 * built_up);
    missing_ = std::sqrt(std::max(2 * a, narrowest) / std::max(a + b, narrowest));
    const double exponent = a + b > 0 ? a * (b - a) / (4 * (a + b)) * first_k * first_k : 0;
    ratio_ = std::exp(-exponent);
    step_ = ratio_ * ratio_;
  }
  double next() {
    const double share = 1 - missing_;
    missing_ *= ratio_;  // exp(-e m^2): ratios are exp(-e (2 m + 1))
    ratio_ *= step_;
    return share;
  }

 private:
  double missing_, ratio_, step_;
};

/// Squares on a ring of functions that are given by their modes.
class Squares {
 public:
  explicit Squares(int ring) : spectrum_(static_cast<std::size_t>(ring)), ring_(static_cast<std::size_t>(ring)) {}

  /// The modes of f(x)^2.
  Modes of(const Modes& f) {
    const std::size_t half = ring_.size() / 2;
    ring_[0] = f[0].real();
    for (std::size_t m = 1; m < half; ++m) {
      ring_[2 * m - 1] = f[m].real();
      ring_[2 * m] = f[m].imag();
    }
    ring_.back() = f[half].real();
    spectrum_.inverse(ring_);
    for (double& one : ring_) one *= one;
    spectrum_.transform(ring_);
    Modes square(half + 1);
    square[0] = ring_[0];
    for (std::size_t m = 1; m < half; ++m) square[m] = {ring_[2 * m - 1], ring_[2 * m]};
    square[half] = ring_.back();
    return square;
  }

 private:
  RealSpectrum spectrum_;
  std::vector<double> ring_;
};

class Solver {
 public:
  Solver(const CouplingSpec& spec, const TorqueKernels& torque)
      : torque_(torque),
        squares_(spec.ring),
        modes_(static_cast<std::size_t>(spec.ring) / 2 + 1),
        growing_(std::isfinite(spec.start)),
        kept_(modes_, 0) {
    peak_.spec = spec;
    for (std::size_t m = 0; m < modes_; ++m) k_squared_.push_back(std::pow(wave_number(spec, m), 2));
  }

  CoupledPeak solve() {
    peak_.modes.emplace_back(modes_, 1.0);
    kernels_.push_back(first_kernel());
    Modes memory(modes_);  // the integral over s at the last step
    for (std::size_t n = 1; n <= steps_of(peak_.spec); ++n) {
      const Modes past = past_without_ends(n);
      // Of the kernels over no step and over all of them.
      const Modes first = growing_ ? built_up(kernels_[0], 0, n) : kernels_[0];
      Modes kernel = kernels_.back(), next;
      for (int i = 0; i <= corrections; ++i) {
        next = step(memory, past, first, growing_ ? built_up(kernel, n, n) : kernel);
        kernel = kernel_of(next, n);
      }
      memory = memory_of(past, first, growing_ ? built_up(kernel, n, n) : kernel, next);
      kernels_.push_back(std::move(kernel));
      for (std::size_t m = 0; m < modes_; ++m) {
        if (std::abs(next[m]) > forgotten) kept_[m] = n;
      }
      peak_.modes.push_back(std::move(next));
    }
    return std::move(peak_);
  }

 private:
  Modes kernel_of(const Modes& f, std::size_t step) {
    return with_torque(peak_.spec.to_itself != 0 ? squares_.of(f) : Modes(modes_), step);
  }
  /// As long as the peak has only spread by diffusion.
  Modes first_kernel() {
    Modes sum(modes_);
    if (peak_.spec.to_itself == 0) return with_torque(sum, 0);
    around_step(peak_.spec, 0, [&](double s, double weight) {
      Modes f(modes_);
      for (std::size_t m = 0; m < modes_; ++m) f[m] = std::exp(-peak_.spec.D * k_squared_[m] * s / 2);
      const Modes square = squares_.of(f);
      for (std::size_t m = 0; m < modes_; ++m) sum[m] += weight * square[m];
    });
    return with_torque(sum, 0);
  }
  /// Where fluctuations still build up, that with torque is added later (built_up).
  Modes with_torque(Modes kernel, std::size_t step) const {
    const double to_torque = growing_ ? 0 : peak_.spec.to_torque;
    for (std::size_t m = 0; m < modes_; ++m)
      kernel[m] = peak_.spec.to_itself * kernel[m] + to_torque * torque_[step][m];
    return kernel;
  }
  /// The kernel over s steps down to step n, of fluctuations that have built up to the step n - s; `with_itself`: that
  /// part of it, saturated.
  Modes built_up(const Modes& with_itself, std::size_t s, std::size_t n) const {
    const CouplingSpec& spec = peak_.spec;
    const double over = spec.step * static_cast<double>(s), depth = spec.start + spec.step * static_cast<double>(n - s);
    BuiltUp itself(spec.D, over, depth, wave_number(spec, 1)), torque(spec.D_torque, over, depth, wave_number(spec, 1));
    Modes kernel(modes_);
    for (std::size_t m = 0; m < modes_ && (s == 0 || m < 8 || kept_[m] >= n - s); ++m)
      kernel[m] = with_itself[m] * itself.next() + spec.to_torque * torque_[s][m] * torque.next();
    return kernel;
  }
  /// The trapezoidal sum over s at step n but for its two ends, which need what is not known yet.
  Modes past_without_ends(std::size_t n) const {
    Modes sum(modes_);
    for (std::size_t s = 1; s < n; ++s) {
      const Modes built = growing_ ? built_up(kernels_[s], s, n) : Modes();
      const double* const M = reinterpret_cast<const double*>(growing_ ? built.data() : kernels_[s].data());
      const double* const f = reinterpret_cast<const double*>(peak_.modes[n - s].data());
      double* const to = reinterpret_cast<double*>(sum.data());
      // Of short waves little is left: those that have gone by then are the last ones.
      for (std::size_t m = 0; m < modes_ && (m < 8 || kept_[m] >= n - s); ++m) {
        to[2 * m] += M[2 * m] * f[2 * m] - M[2 * m + 1] * f[2 * m + 1];
        to[2 * m + 1] += M[2 * m] * f[2 * m + 1] + M[2 * m + 1] * f[2 * m];
      }
    }
    return sum;
  }
  /// `first`, `kernel`: over no step and over all.
  Modes memory_of(const Modes& past, const Modes& first, const Modes& kernel, const Modes& f) const {
    Modes memory(modes_);
    for (std::size_t m = 0; m < modes_; ++m)
      memory[m] = peak_.spec.step * (past[m] + (first[m] * f[m] + kernel[m]) / 2.0);
    return memory;
  }
  /// f at the next step, the mean of both ends driving it.
  Modes step(const Modes& memory, const Modes& past, const Modes& first, const Modes& kernel) const {
    const Modes& f = peak_.modes.back();
    const double h = peak_.spec.step, D = peak_.spec.D;
    Modes next(modes_);
    for (std::size_t m = 0; m < modes_; ++m) {
      const double damping = h / 2 * k_squared_[m];
      const Complex known = f[m] - damping * (D / 2 * f[m] + memory[m] + h * (past[m] + kernel[m] / 2.0));
      next[m] = known / (1.0 + damping * (D / 2 + h * first[m] / 2.0));
    }
    return next;
  }

  const TorqueKernels& torque_;
  Squares squares_;
  std::size_t modes_;
  bool growing_;  ///< fluctuations still build up
  std::vector<double> k_squared_;
  std::vector<Modes> kernels_;     ///< M(k, s)
  std::vector<std::size_t> kept_;  ///< of each mode, the last step at which something is left of it
  CoupledPeak peak_;
};

std::size_t step_at(const CoupledPeak& peak, double z) {
  return std::min(static_cast<std::size_t>(std::lround(z / peak.spec.step)), peak.modes.size() - 1);
}

}  // namespace

DoubleGaussian CoupledPeak::shape_below(double above, double z) const {
  const Modes &first = modes[step_at(*this, above)], &last = modes[step_at(*this, above + z)];
  const double there = spec.step * static_cast<double>(step_at(*this, above + z) - step_at(*this, above));
  LayerSpectrum spectrum;
  spectrum.columns = spec.ring;
  for (std::size_t m = 1; m < first.size() - 1 && std::abs(first[m]) > least_referred_to; ++m) {
    const Complex turned = last[m] / first[m] * std::polar(1.0, -wave_number(spec, m) * spec.c * there);
    spectrum.whole.push_back(turned.real());
    spectrum.sines.whole.push_back(-turned.imag());
  }
  const DoubleGaussian start{spec.c * there, std::sqrt(spec.D * there)};
  const auto fitted = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, start);
  if (!fitted) throw InputError("two Gaussians do not fit to a peak of the mode-coupling equation");
  return *fitted;
}

double CoupledPeak::density_below(double above, double z, double x) const {
  const Modes &first = modes[step_at(*this, above)], &last = modes[step_at(*this, above + z)];
  double sum = 1;
  for (std::size_t m = 1; m + 1 < first.size() && std::abs(first[m]) > least_referred_to; ++m)
    sum += 2 * (last[m] / first[m] * std::polar(1.0, wave_number(spec, m) * x)).real();
  return sum / spec.ring;
}

std::complex<double> CoupledPeak::mode_below(double above, double z, double k) const {
  const Complex first = mode_at(above, k);
  return std::abs(first) > least_referred_to ? mode_at(above + z, k) / first : 0;
}

std::complex<double> CoupledPeak::mode_at(double z, double k) const {
  const Modes& f = modes[step_at(*this, z)];
  const double place = k / wave_number(spec, 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), f.size() - 2);
  const Complex first = f[below], second = f[below + 1];
  if (!(std::abs(first) > 0 && std::abs(second) > 0)) return 0;
  // Nearly a Gaussian: the logarithm of its size is straight in k^2, and its phase nearly straight in k.
  const auto square = [](double number) { return number * number; };
  const auto low = static_cast<double>(below);
  const double share = (square(place) - square(low)) / (square(low + 1) - square(low));
  const double size = std::exp(std::log(std::abs(first)) * (1 - share) + std::log(std::abs(second)) * share);
  return std::polar(size, std::arg(first) + std::arg(second / first) * (place - low));
}

TorqueKernels torque_kernels(const CouplingSpec& spec) {
  const std::size_t modes = static_cast<std::size_t>(spec.ring) / 2 + 1;
  Squares squares(spec.ring);
  TorqueKernels kernels;
  for (std::size_t n = 0; n <= steps_of(spec); ++n) {
    kernels.emplace_back(modes);
    around_step(spec, n, [&](double s, double weight) {
      Modes f(modes);
      for (std::size_t m = 0; m < f.size(); ++m)
        f[m] = std::exp(-spec.D_torque * std::pow(wave_number(spec, m), 2) * s / 2);
      const Modes square = squares.of(f);
      for (std::size_t m = 0; m < f.size(); ++m)
        kernels.back()[m] += weight * square[m] * std::polar(1.0, wave_number(spec, m) * spec.c * s);
    });
  }
  return kernels;
}

CoupledPeak solve_coupled_peak(const CouplingSpec& spec, const TorqueKernels& torque) {
  return Solver(spec, torque).solve();
}

CoupledPeak solve_coupled_peak(const CouplingSpec& spec) { return solve_coupled_peak(spec, torque_kernels(spec)); }

}  // namespace granuscope
