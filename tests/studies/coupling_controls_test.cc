// What the study of coupled fields takes from piles, taken from data that are made up and known.
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "ensemble/fluctuation_estimator.h"
#include "model/lattice.h"
#include "studies/mode_coupling/measure.h"
#include "studies/mode_coupling/theory.h"

using namespace granuscope;

namespace {

/// `value` and replicates of so many blocks whose means scatter so that its error is `error`.
Replicated replicated_about(double value, double error, int blocks, std::mt19937_64& engine) {
  std::normal_distribution<double> normal(value, error * std::sqrt(blocks));
  std::vector<double> block;
  double sum = 0;
  for (int b = 0; b < blocks; ++b) sum += block.emplace_back(normal(engine));
  Replicated number{sum / blocks, {}};
  for (const double one : block) number.without_block.push_back((sum - one) / (blocks - 1));
  return number;
}

/// Fluctuations at mu = 0.5 over so many octaves, without numbers.
DeepResponse response_of_lags(int octaves) {
  DeepResponse response;
  EnsembleSpec spec;
  spec.sampler.mu = 0.5;
  spec.lattice.columns = 960;
  response.spec = spec_of_lags(spec, usual_first_lag, octaves);
  for (const int lag : response.spec.layers)
    response.lags.push_back({lag, Lattice::depth(lag) - Lattice::depth(0), {}, {}});
  response.c_thrust = {0.527, 1e-4, {}};
  return response;
}

constexpr Couplings couplings_at_05{0.0012, 0.042};
constexpr double D_torque_at_05 = 0.38, D_at_05 = 0.17;

}  // namespace

TEST_CASE("The strength of the couplings is found where it is known, and its errors cover it", "[long]") {
  const DeepResponse response = response_of_lags(3);
  const SpreadingTheory theory(response, D_torque_at_05);
  std::mt19937_64 engine(3);
  for (const double strength : {0.4, 1.0}) {
    const std::vector<double> slopes = theory.slopes(D_at_05, couplings_at_05.times(strength));
    REQUIRE(slopes.back() > 1.1 * slopes.front());
    constexpr int trials = 40;
    int covered = 0, covered_D = 0;
    double sum = 0, squares = 0, chi2 = 0;
    for (int trial = 0; trial < trials; ++trial) {
      std::vector<Replicated> measured;
      measured.reserve(slopes.size());
      for (const double slope : slopes) measured.push_back(replicated_about(slope, 0.005 * slope, 32, engine));
      const StrengthFit fit = fit_strength(theory, measured, couplings_at_05, 0.9 * D_at_05, 2);
      const double away = (fit.strength.value - strength) / fit.strength.standard_error;
      if (std::abs(away) < 1) ++covered;
      if (std::abs(fit.D.value - D_at_05) < fit.D.standard_error) ++covered_D;
      sum += away;
      squares += away * away;
      chi2 += fit.chi2;
      CHECK(fit.degrees_of_freedom == 1);
      CHECK(fit.diffusion_chi2 > fit.chi2);
    }
    CAPTURE(strength, covered, covered_D, sum / trials, squares / trials, chi2 / trials);
    // 68 %, known to 7.4 %.
    const double share = 0.68 * trials, margin = 3 * std::sqrt(trials * 0.68 * 0.32);
    CHECK(covered == Approx(share).margin(margin));
    CHECK(covered_D == Approx(share).margin(margin));
    CHECK(std::abs(sum / trials) < 3 / std::sqrt(trials));
    CHECK(squares / trials == Approx(1).margin(3 * std::sqrt(2.0 / trials)));
    CHECK(chi2 / trials == Approx(1).margin(4 * std::sqrt(2.0 / trials)));
  }
}

TEST_CASE("Each of the three shapes of a peak is told from the others where it is the one") {
  const DeepResponse response = response_of_lags(4);
  const SpreadingTheory theory(response, D_torque_at_05);
  const CoupledPeak solution = theory.peak(D_at_05, couplings_at_05);
  const ReferredPeak coupled{solution, theory.reference()};
  const double z = response.lags.back().z;
  const DoubleGaussian shape = solution.shape_below(theory.reference(), z);
  constexpr int columns = 960;
  std::mt19937_64 engine(5);
  std::normal_distribution<double> normal;
  enum { gaussian, kpz, of_theory };
  for (const int truth : {gaussian, kpz, of_theory}) {
    LayerSpectrum spectrum;
    spectrum.columns = columns;
    for (int m = 1; m <= 40; ++m) {
      const double k = 2 * std::numbers::pi * m / columns, kW = k * shape.width;
      const std::complex<double> mode = truth == gaussian ? std::exp(-kW * kW / 2)
                                        : truth == kpz    ? kpz_peak().mode(kW)
                                                          : solution.mode_below(theory.reference(), z, k);
      spectrum.noise.push_back(0.001);
      const double x = truth == of_theory ? solution.spec.c * z : shape.peak;
      spectrum.whole.push_back((mode * std::polar(1.0, -k * x)).real() + 0.001 * normal(engine));
    }
    // Not where the best fit begins.
    const LagResponse lag{512, z, {shape.peak + 0.3, 0.1, {}}, {1.05 * shape.width * shape.width, 0.1, {}}};
    const PeakShapeTest test = test_shape(spectrum, lag, coupled);
    CHECK(test.degrees_of_freedom == 38);
    const double chi2[] = {test.gaussian, test.kpz, test.coupled};
    CAPTURE(truth, test.gaussian, test.kpz, test.coupled);
    for (const int tried : {gaussian, kpz, of_theory}) {
      if (tried == truth) CHECK(chi2[tried] < 38 + 4 * std::sqrt(2 * 38));
      if (tried != truth) CHECK(chi2[tried] > 38 + 8 * std::sqrt(2 * 38));
    }
  }
}

TEST_CASE("A peak below a reference has the modes that are left of those at the reference") {
  // Straight from the solution, on its own ring and steps.
  const SpreadingTheory theory(response_of_lags(3), D_torque_at_05);
  const CoupledPeak solution = theory.peak(D_at_05, couplings_at_05);
  const double step = solution.spec.step;
  const std::size_t above = 20, below = 100;
  const auto &first = solution.modes[above], &last = solution.modes[above + below];
  double sum = 1;
  for (std::size_t m = 1; m + 1 < first.size(); ++m) {
    if (std::abs(first[m]) < 0.05) break;
    const std::complex<double> left = last[m] / first[m];
    sum += 2 * left.real();
    if (m > 200) continue;
    const double k = 2 * std::numbers::pi * static_cast<double>(m) / solution.spec.ring;
    const std::complex<double> found = solution.mode_below(step * above, step * below, k);
    CAPTURE(m, found, left, last[m]);
    CHECK(std::abs(found - left) < 1e-6);
    if (m == 40) CHECK(std::abs(found - last[m]) > 0.01);
  }
  const double density = solution.density_below(step * above, step * below, 0);
  CHECK(density == Approx(sum / solution.spec.ring).epsilon(1e-3));
}

TEST_CASE("A peak meets fluctuations that build up with depth, as summed mode by mode") {
  const int start = GENERATE(0, 60);  // steps below the surface
  // The equation in short explicit steps, its kernel by the sum over all pairs of modes of the ring.
  constexpr int ring = 64, steps = 240;
  constexpr double h = 0.1, D = 0.4, c = 0.5, to_torque = 0.4, D_torque = 1.2;
  const auto wave = [&](int m) { return 2 * std::numbers::pi * m / ring; };
  const auto kernel = [&](int m, int s, int built_up) {
    const auto torque = [&](int q) { return std::exp(-D_torque * wave(q) * wave(q) * h * s / 2); };
    double sum = 0;
    for (int q = -ring / 2; q < ring / 2; ++q) {
      int other = m - q;
      if (other >= ring / 2) other -= ring;
      const double share = -std::expm1(-D_torque * wave(q) * wave(q) * h * (start + built_up));
      sum += share * torque(q) * torque(other) / ring;
    }
    return to_torque * sum * std::polar(1.0, wave(m) * c * h * s);
  };
  const CouplingSpec spec{.D = D,
                          .c = c,
                          .to_torque = to_torque,
                          .D_torque = D_torque,
                          .depth = h * steps,
                          .step = h,
                          .ring = ring,
                          .start = h * start};
  const CoupledPeak solved = solve_coupled_peak(spec);
  CouplingSpec saturated = spec;
  saturated.start = CouplingSpec().start;
  const CoupledPeak other = solve_coupled_peak(saturated);
  for (const int m : {1, 2, 4}) {
    std::vector<std::complex<double>> f{1.0};
    const double k_squared = wave(m) * wave(m);
    const auto slope = [&](std::size_t n) {
      std::complex<double> memory = 0;
      for (std::size_t s = 0; s <= n; ++s) {
        const double end = s == 0 || s == n ? 0.5 : 1;
        memory += end * h * kernel(m, static_cast<int>(s), static_cast<int>(n - s)) * f[n - s];
      }
      return -k_squared * (D / 2 * f[n] + memory);
    };
    for (std::size_t n = 0; n < steps; ++n) {
      const std::complex<double> here = slope(n);
      f.push_back(f[n] + h * here);
      const std::complex<double> there = slope(n + 1);
      f.back() = f[n] + h / 2 * (here + there);
    }
    const std::complex<double> expected = f.back(), found = solved.modes[steps][static_cast<std::size_t>(m)];
    const double uncoupled = std::exp(-D / 2 * k_squared * h * steps);
    CAPTURE(start, m, expected, found, uncoupled, other.modes[steps][static_cast<std::size_t>(m)]);
    CHECK(std::abs(found - expected) < 0.05 * std::abs(uncoupled - expected));
    CHECK(std::abs(other.modes[steps][static_cast<std::size_t>(m)] - expected) > 0.15 * std::abs(uncoupled - expected));
  }
}

TEST_CASE("A scaled peak is the density that its modes were made of") {
  const DeepResponse response = response_of_lags(4);
  const SpreadingTheory theory(response, D_torque_at_05);
  const CoupledPeak solution = theory.peak(D_at_05, couplings_at_05.times(0));
  const double z = response.lags.back().z;
  const ScaledPeak peak = scaled_peak(ReferredPeak{solution, theory.reference()}, z);
  // Without coupling a Gaussian; its fitted width is that of one integrated over beads.
  double area = 0;
  for (std::size_t i = 0; i < peak.x.size(); ++i) {
    area += (peak.x[1] - peak.x[0]) * peak.height[i].value;
    CHECK(peak.height[i].value ==
          Approx(std::exp(-peak.x[i] * peak.x[i] / 2) / std::sqrt(2 * std::numbers::pi)).margin(0.002));
  }
  CHECK(area == Approx(1).margin(1e-3));
}

TEST_CASE("The curvature of the thrust is found beside a known fourth power, with errors that cover it") {
  std::mt19937_64 engine(7);
  constexpr double at_zero = 0.83, curvature = -3, fourth = 12;
  constexpr int trials = 400;
  int covered = 0;
  double sum = 0, squares = 0, chi2 = 0, change = 0, change_error = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<LoadedPiles> piles;
    for (const double x : {0.0, 0.035, 0.07, 0.105, 0.14, 0.176}) {
      LoadedPiles one;
      one.line.slope = x;
      const double thrust = at_zero + curvature * x * x / 2 + fourth * x * x * x * x;
      one.thrust = replicated_about(thrust, 3e-4, 32, engine);
      one.thrust_below = replicated_about(thrust + 0.1 * x * x, 3e-4, 32, engine);
      piles.push_back(one);
    }
    Replicated replicated;
    const ThrustCurvature found = fit_thrust(piles, &LoadLine::slope, &replicated);
    CHECK(estimate(replicated).standard_error == Approx(found.curvature.standard_error));
    const double away = (found.curvature.value - curvature) / found.curvature.standard_error;
    if (std::abs(away) < 1) ++covered;
    sum += away / trials;
    squares += away * away / trials;
    chi2 += found.test.chi2 / trials;
    change += found.curvature_change.value / trials;
    change_error += found.curvature_change.standard_error / trials;
    if (trial == 0) CHECK(std::abs(found.at_zero.value - at_zero) < 5 * found.at_zero.standard_error);
  }
  CAPTURE(covered, sum, squares, chi2, change, change_error);
  CHECK(std::abs(change - 0.2) < 4 * change_error / std::sqrt(trials));
  CHECK(change_error / std::sqrt(trials) < 0.02);
  CHECK(chi2 == Approx(3).margin(0.6));  // six loads, three numbers of the form
  CHECK(std::abs(sum) < 0.2);            // a bias less than a fifth of an error
  CHECK(covered == Approx(0.68 * trials).margin(0.09 * trials));
  CHECK(squares == Approx(1).margin(0.3));
  // Where the thrust is not of that form, chi^2 says so.
  std::vector<LoadedPiles> far;
  for (const double x : {0.0, 0.1, 0.2, 0.3, 0.4, 0.5}) {
    LoadedPiles one;
    one.line.slope = x;
    one.thrust = replicated_about(at_zero + 500 * std::pow(x, 6), 3e-4, 32, engine);
    one.thrust_below = one.thrust;
    far.push_back(one);
  }
  CHECK(fit_thrust(far, &LoadLine::slope).test.chi2 > 100);
}
