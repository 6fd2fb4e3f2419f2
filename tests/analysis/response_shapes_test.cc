// Source of the expected classes: profiles made of each shape itself, with noise of known size.
#include "analysis/double_gaussian.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using namespace granuscope;

namespace {

constexpr int columns = 256;
constexpr double z = 60;
/// Of each mode. The nearest two shapes, two Gaussians and an orthotropic half plane, then differ by 100 in chi^2, ten
/// standard deviations of the noise that decides; twice the noise would confuse one in two hundred of these.
constexpr double noise_of_a_mode = 0.005;

/// The modes of a shape at depth z, as a response has them that was measured with this noise in each.
LayerSpectrum spectrum_of(ResponseShape shape, double noise, std::mt19937_64& generator) {
  LayerSpectrum spectrum;
  spectrum.columns = columns;
  std::normal_distribution<double> normal;
  for (int m = 1; m <= (columns - 1) / 2; ++m) {
    const double k = 2 * std::numbers::pi * m / columns, bin = std::sin(k / 2) / (k / 2);
    const double q = k * 0.5 * z, a = 1.6;  // an orthotropic one with two peaks
    double value = 0;
    if (shape == ResponseShape::two_gaussians) value = fourier_mode({0.5 * z, 4}, m, columns, false).value;
    if (shape == ResponseShape::one_gaussian) value = fourier_mode({0, 5}, m, columns, false).value;
    if (shape == ResponseShape::isotropic) value = (1 + q) * std::exp(-q) * bin;
    if (shape == ResponseShape::orthotropic) value = (std::cos(a * q) + std::sin(a * q) / a) * std::exp(-q) * bin;
    spectrum.whole.push_back(value + noise * normal(generator));
    spectrum.noise.push_back(noise);
  }
  return spectrum;
}

}  // namespace

TEST_CASE("each of eight noisy profiles of every class is recognised") {
  std::mt19937_64 generator(7);
  for (const ResponseShape shape : all_response_shapes) {
    int recognised = 0;
    for (int k = 0; k < 8; ++k) {
      recognised += best_shape(fit_response_shapes(spectrum_of(shape, noise_of_a_mode, generator), z)) == shape ? 1 : 0;
    }
    INFO(name_of(shape));
    CHECK(recognised == 8);
  }
}

TEST_CASE("the confusion matrix of 200 noisy profiles of each class", "[long]") {
  std::mt19937_64 generator(8);
  std::array<std::array<int, 4>, 4> confused{};
  for (const ResponseShape shape : all_response_shapes) {
    for (int k = 0; k < 200; ++k) {
      const auto found = best_shape(fit_response_shapes(spectrum_of(shape, noise_of_a_mode, generator), z));
      ++confused[static_cast<std::size_t>(shape)][static_cast<std::size_t>(found)];
    }
  }
  for (const ResponseShape shape : all_response_shapes) {
    const auto& row = confused[static_cast<std::size_t>(shape)];
    INFO(name_of(shape) << ": taken for " << row[0] << ", " << row[1] << ", " << row[2] << ", " << row[3]);
    CHECK(row[static_cast<std::size_t>(shape)] >= 197);  // a spare parameter gains 9 by chance in one of 400
  }
}

TEST_CASE("a single Gaussian gives back its width, and an elastic shape its scale") {
  std::mt19937_64 generator(9);
  const LayerSpectrum gaussian = spectrum_of(ResponseShape::one_gaussian, 1e-6, generator);
  CHECK(single_width_squared(gaussian, gaussian.whole) == Approx(25).epsilon(1e-3));
  const auto fits = fit_response_shapes(spectrum_of(ResponseShape::isotropic, 1e-6, generator), z);
  CHECK(fits[static_cast<std::size_t>(ResponseShape::isotropic)].width == Approx(0.5 * z).epsilon(1e-3));
  const auto two = fit_response_shapes(spectrum_of(ResponseShape::orthotropic, 1e-6, generator), z);
  CHECK(two[static_cast<std::size_t>(ResponseShape::orthotropic)].position ==
        Approx(0.5 * z * std::sqrt(1.6 * 1.6 - 1)).epsilon(1e-2));
}
