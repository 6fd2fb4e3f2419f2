// The smooth noise that weighs the modes of a fit: does it find what it is given, scatter less than what it is fitted
// to, and describe piles?
#include "analysis/noise_spectrum.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "analysis/fit_noise.h"
#include "analysis/layer_spectrum.h"
#include "ensemble/ensemble_runner.h"
#include "model/lattice.h"

using namespace granuscope;

namespace {

constexpr int columns = 200, modes = 99;
constexpr double damping = 0.08;

/// The integral of the model by the midpoint rule instead of its closed form, times a spectrum with a hump.
double expected_variance(int mode, double z) {
  constexpr int steps = 4000;
  const double k = 2 * std::numbers::pi * mode / columns;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) * z / steps;
    sum += std::pow(std::sin(tan30 * k * u), 2) * std::exp(-damping * k * k * u) * z / steps;
  }
  return 1e-4 * k * k * sum * std::exp(0.8 * k - 0.3 * std::pow(k - 2, 2));
}

/// Variances at five depths as measured from so many degrees of freedom; exact for 0.
std::vector<LayerVariances> measured(int degrees_of_freedom, std::uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::vector<LayerVariances> layers;
  for (const double z : {30.0, 45.0, 60.0, 75.0, 90.0}) {
    LayerVariances layer{z, {}};
    for (int m = 1; m <= modes; ++m) {
      double factor = 1;
      if (degrees_of_freedom > 0) {
        factor = std::chi_squared_distribution<double>(degrees_of_freedom)(generator) / degrees_of_freedom;
      }
      layer.variance.push_back(expected_variance(m, z) * factor);
    }
    layers.push_back(layer);
  }
  return layers;
}

}  // namespace

TEST_CASE("noise of waves: an exact spectrum is found again, at depths it was not fitted to as well") {
  const NoiseSpectrum noise(columns, measured(0, 1));
  CHECK(noise.damping() == Approx(damping).epsilon(0.1));
  for (const double z : {20.0, 50.0, 100.0}) {
    const std::vector<double> deviations = noise.standard_deviations(z);
    REQUIRE(deviations.size() == modes);
    for (int m = 1; m <= modes; ++m) {
      INFO("mode " << m << " at z = " << z);
      CHECK(std::pow(deviations[static_cast<std::size_t>(m - 1)], 2) == Approx(expected_variance(m, z)).epsilon(0.05));
    }
  }
}

TEST_CASE("noise of waves: the lowest modes scatter far less than what is measured of them") {
  // 31 degrees of freedom scatter by sqrt(2/31) = 0.25. Five coefficients of 99 modes at five depths that do not
  // fluctuate together, as these here do not, leave a few percent; those that do, as in piles, sqrt 5 times as much.
  constexpr int repetitions = 60;
  std::vector<std::vector<double>> deviations;
  for (int r = 1; r <= repetitions; ++r) {
    deviations.push_back(NoiseSpectrum(columns, measured(31, static_cast<std::uint64_t>(r))).standard_deviations(60));
  }
  for (const int mode : {1, 2, 5, 20}) {
    double squares = 0, mean = 0;
    for (const auto& each : deviations) {
      const double logarithm =
          std::log(std::pow(each[static_cast<std::size_t>(mode - 1)], 2) / expected_variance(mode, 60));
      squares += logarithm * logarithm / repetitions;
      mean += logarithm / repetitions;
    }
    INFO("mode " << mode << ": mean " << mean << ", rms " << std::sqrt(squares));
    CHECK(std::sqrt(squares) < 0.08);
    CHECK(std::abs(mean) < 0.03);
  }
}

TEST_CASE("noise of waves: ten times the variance is ten times the noise squared, and a mode without any is no harm") {
  std::vector<LayerVariances> layers = measured(31, 7);
  const NoiseSpectrum noise(columns, layers);
  for (LayerVariances& layer : layers) {
    for (double& variance : layer.variance) variance *= 10;
  }
  const std::vector<double> once = noise.standard_deviations(50), more = noise.refitted(layers).standard_deviations(50);
  for (std::size_t m = 0; m < modes; ++m) CHECK(more[m] * more[m] == Approx(10 * once[m] * once[m]).epsilon(1e-5));
  for (LayerVariances& layer : layers) layer.variance[3] = 0;
  for (const double deviation : NoiseSpectrum(columns, layers).standard_deviations(50)) {
    CHECK(std::isfinite(deviation));
    CHECK(deviation > 0);
  }
}

TEST_CASE("noise of waves: the noise of piles, over a thousandfold range of variances") {
  EnsembleSpec spec;
  spec.lattice = {120, 70};
  spec.sampler.mu = 0.3;
  spec.sampler.seed = 11;
  spec.layers = {25, 31, 37, 43, 49};
  const auto worst = [&](std::uint64_t samples, EstimatorName estimator) {
    spec.response.estimator = estimator;
    spec.response.samples = samples;
    const BlockSums sums = run_ensemble(spec, 0, nullptr).sums;
    const std::size_t first = sums.layers.front() == 0 ? 1 : 0;
    std::vector<std::size_t> rows;
    for (std::size_t row = first; row < sums.layers.size(); ++row) rows.push_back(row);
    const auto noise = fit_noise(sums, rows, 1);
    REQUIRE(noise);
    CHECK(noise->without_block.size() == static_cast<std::size_t>(sums.blocks()));
    // Bands of modes over all depths; the lowest three fluctuate alike at all of them.
    double largest = 0;
    const std::vector<std::size_t> bounds{0, 3, 8, 20, 40, 59};
    for (std::size_t band = 0; band + 1 < bounds.size(); ++band) {
      double ratio = 0, count = 0;
      for (const std::size_t row : rows) {
        const std::vector<double> measured = mode_variances(sums, row, 1).whole;
        const std::vector<double> model = noise->whole.standard_deviations(Lattice::depth(sums.layers[row]));
        for (std::size_t m = bounds[band]; m < bounds[band + 1]; ++m) {
          ratio += measured[m] / (model[m] * model[m]);
          count += 1;
        }
      }
      CAPTURE(band, ratio / count);
      CHECK(ratio / count > 0);
      largest = std::max(largest, std::abs(std::log(ratio / count)));
    }
    return largest;
  };
  CHECK(worst(1024, EstimatorName::multiplexed) < 0.25);
  CHECK(worst(2048, EstimatorName::point) < 0.25);
}

TEST_CASE("noise of waves: an ensemble without scatter has none") {
  EnsembleSpec spec;
  spec.lattice = {60, 50};
  spec.sampler.mu = 0;
  spec.response.samples = 256;
  spec.layers = {20, 23, 26};
  CHECK_FALSE(fit_noise(run_ensemble(spec, 0, nullptr).sums, {0, 1, 2}, 1));
}
