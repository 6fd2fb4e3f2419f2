#include "analysis/shape_fit.h"
#include "kit/fourier_mode.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using namespace granuscope;

namespace {

constexpr int spectrum_columns = 300;

LayerSpectrum spectrum_of(std::vector<std::pair<double, DoubleGaussian>> shares) {
  LayerSpectrum spectrum;
  spectrum.columns = spectrum_columns;
  spectrum.whole.assign((spectrum_columns - 1) / 2, 0.0);
  spectrum.noise.assign(spectrum.whole.size(), 1.0);
  std::vector<ModeValue> modes(spectrum.whole.size());
  for (const auto& [share, shape] : shares) {
    fourier_modes(shape, spectrum_columns, false, modes);
    for (std::size_t i = 0; i < modes.size(); ++i) spectrum.whole[i] += share * modes[i].value;
  }
  return spectrum;
}

/// What the fit makes least, with the weights of the width `of_weights`.
double sum_of_squares(const LayerSpectrum& spectrum, ModeWeights weights, DoubleGaussian shape, double of_weights) {
  double sum = 0;
  for (std::size_t i = 0; i < spectrum.whole.size(); ++i) {
    const double k = 2 * std::numbers::pi * static_cast<double>(i + 1) / spectrum_columns;
    const double weight = weights == ModeWeights::equal ? 1 : std::exp(-k * k * (of_weights * of_weights + 1) / 4);
    const double missed =
        spectrum.whole[i] - test::fourier_mode(shape, static_cast<int>(i + 1), spectrum_columns, false).value;
    sum += weight * missed * missed;
  }
  return sum;
}

}  // namespace

TEST_CASE("a weighted fit finds two true Gaussians, merged or narrower than a bead as well") {
  for (const ModeWeights weights : {ModeWeights::by_width, ModeWeights::equal}) {
    for (const DoubleGaussian truth : {DoubleGaussian{40, 3}, {40, 0.4}, {12, 9}, {0, 5}, {70, 12}}) {
      const LayerSpectrum spectrum = spectrum_of({{1, truth}});
      const auto found =
          weighted_shape(spectrum, spectrum.modes(), weights, {truth.peak + 0.3 * truth.width, 1.3 * truth.width});
      CAPTURE(truth.peak, truth.width);
      REQUIRE(found);
      CHECK(found->peak == Approx(truth.peak).margin(0.01));
      CHECK(found->width == Approx(truth.width).epsilon(1e-5));
    }
  }
}

TEST_CASE("a weighted fit is the least of its own sum of squares, whatever the noise") {
  // Peaks with tails: no two Gaussians.
  LayerSpectrum spectrum = spectrum_of({{0.7, {40, 3}}, {0.3, {39, 6}}});
  double width_before = 0;
  for (const ModeWeights weights : {ModeWeights::by_width, ModeWeights::equal}) {
    const auto found = weighted_shape(spectrum, spectrum.modes(), weights, {40, 4});
    REQUIRE(found);
    const double least = sum_of_squares(spectrum, weights, *found, found->width);
    for (const auto& [peak, width] : {std::pair{1e-4, 0.0}, {-1e-4, 0.0}, {0.0, 1e-4}, {0.0, -1e-4}}) {
      CHECK(sum_of_squares(spectrum, weights, {found->peak + peak, found->width + width}, found->width) > least);
    }
    // Long waves count more: the tails make the peaks wider.
    if (weights == ModeWeights::equal) CHECK(found->width < width_before - 0.05);
    width_before = found->width;
    LayerSpectrum noisy = spectrum;
    for (std::size_t i = 0; i < noisy.noise.size(); ++i) noisy.noise[i] = 1.0 + static_cast<double>(i);
    const auto again = weighted_shape(noisy, noisy.modes(), weights, {38, 5});
    REQUIRE(again);
    CHECK(again->peak == Approx(found->peak).epsilon(1e-7));
    CHECK(again->width == Approx(found->width).epsilon(1e-7));
  }
}

TEST_CASE("sines fit to a peak that has gone around half of the ring") {
  const DoubleGaussian truth{230, 9};
  LayerSpectrum spectrum = spectrum_of({{1, truth}});
  std::vector<ModeValue> cosines(spectrum.whole.size()), sines(spectrum.whole.size());
  fourier_modes(truth, spectrum_columns, false, cosines, sines);
  for (const ModeValue& sine : sines) spectrum.sines.whole.push_back(sine.value);
  for (const double start : {67.0, 72.0, 232.0}) {
    const auto found = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {start, 7});
    REQUIRE(found);
    CHECK(found->peak == Approx(spectrum_columns - truth.peak));  // the smaller of the two
    CHECK(found->width == Approx(truth.width));
  }
  // Of the peak that moves to the other side they are no sines of it.
  for (double& sine : spectrum.sines.whole) sine = -sine;
  const auto mirrored = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {67, 7});
  REQUIRE(mirrored);
  CHECK(mirrored->peak == Approx(spectrum_columns - truth.peak));
  CHECK(mirrored->width == Approx(truth.width));
}

TEST_CASE("sines up to a factor fit as those to scale, with the factor that fits best") {
  const DoubleGaussian truth{230, 9};
  LayerSpectrum spectrum = spectrum_of({{1, truth}});
  std::vector<ModeValue> cosines(spectrum.whole.size()), sines(spectrum.whole.size());
  fourier_modes(truth, spectrum_columns, false, cosines, sines);
  spectrum.sines_to_scale = false;
  std::mt19937_64 random(5);
  std::normal_distribution<double> gauss(0, 0.02);
  for (const double noisy : {0.0, 1.0}) {
    spectrum.sines.whole.clear();
    for (std::size_t i = 0; i < sines.size(); ++i) {
      spectrum.sines.whole.push_back(0.93 * sines[i].value + noisy * gauss(random));
      spectrum.whole[i] += noisy * gauss(random);
    }
    const auto found = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {67, 7});
    REQUIRE(found);
    if (noisy == 0) {
      CHECK(found->peak == Approx(spectrum_columns - truth.peak));
      CHECK(found->width == Approx(truth.width));
      continue;
    }
    CHECK(std::abs(found->peak - (spectrum_columns - truth.peak)) > 1e-3);
    // With the weights of the width found, no other peak, width and factor leave less.
    const auto squares = [&](double peak, double width, double factor) {
      double sum = sum_of_squares(spectrum, ModeWeights::by_width, {spectrum_columns - peak, width}, found->width);
      fourier_modes({spectrum_columns - peak, width}, spectrum_columns, false, cosines, sines);
      for (std::size_t i = 0; i < sines.size(); ++i) {
        const double k = 2 * std::numbers::pi * static_cast<double>(i + 1) / spectrum_columns;
        const double missed = spectrum.sines.whole[i] - factor * sines[i].value;
        sum += std::exp(-k * k * (found->width * found->width + 1) / 4) * missed * missed;
      }
      return sum;
    };
    const auto least_over_factors = [&](double peak, double width) {
      // A parabola in the factor.
      const double at_0 = squares(peak, width, 0), at_1 = squares(peak, width, 1), at_2 = squares(peak, width, 2);
      const double curvature = at_2 - 2 * at_1 + at_0, slope = (at_2 - at_0) / 2;
      return at_1 - slope * slope / (2 * curvature);
    };
    const double least = least_over_factors(found->peak, found->width);
    for (const auto& [peak, width] : {std::pair{1e-3, 0.0}, {-1e-3, 0.0}, {0.0, 1e-3}, {0.0, -1e-3}}) {
      CHECK(least_over_factors(found->peak + peak, found->width + width) > least);
    }
  }
}

TEST_CASE("modes that are no number are not fitted") {
  LayerSpectrum spectrum = spectrum_of({{1, {40, 3}}});
  spectrum.whole[5] = std::nan("");
  CHECK_FALSE(weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, {40, 3}));
}
