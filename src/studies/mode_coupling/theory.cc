#include "studies/mode_coupling/theory.h"

#include <gsl/gsl_sf_airy.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "analysis/shape_fit.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/fluctuation_estimator.h"
#include "ensemble/multiplexed_estimator.h"
#include "model/lattice.h"
#include "studies/mode_coupling/measure.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr double most_steps = 768;  ///< of z down to the deepest lag
constexpr int most_iterations = 12;
constexpr double least_D = 0.05;  ///< of the first octave's

std::vector<double> slopes_of(const std::vector<double>& y, const std::vector<double>& z) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i + 1 < z.size(); ++i) slopes.push_back((y[i + 1] - y[i]) / (z[i + 1] - z[i]));
  return slopes;
}

/// W^2 at the lags from its slopes.
std::vector<double> widths_of(const std::vector<double>& slopes, double first, const std::vector<double>& z) {
  std::vector<double> widths{first};
  for (std::size_t i = 0; i < slopes.size(); ++i) widths.push_back(widths.back() + slopes[i] * (z[i + 1] - z[i]));
  return widths;
}

}  // namespace

SpreadingTheory::SpreadingTheory(const DeepResponse& response, double D_torque)
    : bands_(response.bands),
      columns_(response.spec.lattice.columns),
      c_(response.c_thrust.value),
      D_torque_(D_torque) {
  for (const LagResponse& lag : response.lags) z_.push_back(lag.z);
  if (response.by != DeepMeasurement::loads) {
    const FluctuationPlan plan = fluctuation_plan(response.spec);
    start_ = Lattice::depth((plan.bases.front() + plan.bases.back()) / 2);
    reference_ = Lattice::depth(plan.reference) - Lattice::depth(0);
  }
  while (ring_ < 2.4 * c_ * depth()) ring_ *= 2;
  torque_ = torque_kernels(spec(0, {}));
}

CoupledPeak SpreadingTheory::peak(double D, Couplings couplings) const {
  return solve_coupled_peak(spec(D, couplings), torque_);
}

Spreading SpreadingTheory::spreading(double D, Couplings couplings) const {
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

std::vector<double> SpreadingTheory::slopes(double D, Couplings couplings) const {
  return slopes_of(spreading(D, couplings).width_squared, z_);
}

double SpreadingTheory::D_for(double first_slope, Couplings couplings) const {
  double D = 0.8 * first_slope, by_D = 1, D_before = 0, missing_before = 0;
  for (int i = 0; i < most_iterations; ++i) {
    const double missing = first_slope - slopes(D, couplings).front();
    if (std::abs(missing) < 2e-4 * first_slope) break;
    if (i > 0 && D != D_before) by_D = std::max(0.5, (missing_before - missing) / (D - D_before));
    D_before = D;
    missing_before = missing;
    D = std::max(least_D * first_slope, D + missing / by_D);
  }
  return D;
}

/// The mean over a band, a mode counting as in the fit of what is measured (analysis/dispersion.h).
double SpreadingTheory::D_of(const BandOfModes& band, const CoupledPeak& solved) const {
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

CouplingSpec SpreadingTheory::spec(double D, Couplings couplings) const {
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
          .start = start_};
}

double chi2_of(const PredictedSpreading& predicted, const DeepResponse& response) {
  double sum = 0;
  for (std::size_t i = 1; i < predicted.slopes.size(); ++i) {
    const Estimate &D = response.octaves[i].D, &slope = predicted.slopes[i];
    sum += std::pow((D.value - slope.value) / std::hypot(D.standard_error, slope.standard_error), 2);
  }
  return sum;
}

PredictedSpreading predict(const SpreadingTheory& theory, const DeepResponse& response, Couplings couplings,
                           double error, int threads) {
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

StrengthFit fit_strength(const SpreadingTheory& theory, const std::vector<Replicated>& slopes, Couplings couplings,
                         double D, int threads) {
  std::vector<double> y, weight;
  for (const Replicated& slope : slopes) {
    y.push_back(slope.value);
    weight.push_back(std::pow(estimate(slope).standard_error, -2));
  }
  double strength = 1;
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
  StrengthFit result;
  const auto chi2 = [&](const std::vector<double>& model) {
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += weight[i] * std::pow(y[i] - model[i], 2);
    return sum;
  };
  result.chi2 = chi2(theory.slopes(D, couplings.times(strength)));
  result.degrees_of_freedom = static_cast<int>(y.size()) - 2;
  double sum = 0, weights = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    sum += weight[i] * y[i];
    weights += weight[i];
  }
  result.diffusion_chi2 = chi2(std::vector<double>(y.size(), sum / weights));
  const auto parameter = [&](std::size_t which, double value) {
    return estimate(transform_all(slopes, [&, which, value](const std::vector<double>& others) {
      return value + best_step(difference(others, y), by_D, by_strength, weight)[which];
    }));
  };
  result.D = parameter(0, D);
  result.strength = parameter(1, strength);
  return result;
}

namespace {

using Complex = std::complex<double>;
using Modes = std::vector<Complex>;

constexpr int corrections = 1;      ///< of the kernel at the end of a step, which the step's own end enters
constexpr double forgotten = 1e-9;  ///< of a mode: what is left of it counts no more
/// What must be left of a mode that others are referred to: exp(-(3^2)/2), as of those of fluctuations
/// (ensemble/fluctuation_estimator.h).
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
