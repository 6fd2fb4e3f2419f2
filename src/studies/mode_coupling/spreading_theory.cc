#include "spreading_theory.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "best_step.h"
#include "ensemble/fluctuation_plan.h"
#include "ensemble/parallel.h"
#include "model/lattice.h"

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

}  // namespace granuscope
