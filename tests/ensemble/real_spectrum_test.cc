#include "ensemble/multiplexed_estimator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

using namespace granuscope;

TEST_CASE("the spectrum of a ring is its Fourier sum, and the inverse gives the ring back") {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const std::size_t n : {4U, 5U, 7U, 12U, 97U, 500U}) {
    std::vector<double> ring(n);
    for (double& value : ring) value = uniform(generator);
    std::vector<double> spectrum = ring;
    const RealSpectrum fourier(n);
    fourier.transform(spectrum);
    INFO("ring of " << n);
    for (std::size_t m = 0; m <= n / 2; ++m) {
      std::complex<double> sum = 0;
      for (std::size_t j = 0; j < n; ++j) {
        sum +=
            ring[j] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(m * j % n) / static_cast<double>(n));
      }
      CHECK(spectrum[m == 0 ? 0 : 2 * m - 1] == Approx(sum.real()).margin(1e-12 * static_cast<double>(n)));
      if (m > 0 && 2 * m < n) CHECK(spectrum[2 * m] == Approx(sum.imag()).margin(1e-12 * static_cast<double>(n)));
    }
    fourier.inverse(spectrum);
    for (std::size_t j = 0; j < n; ++j) CHECK(spectrum[j] == Approx(ring[j]).margin(1e-13));
    CHECK_THROWS_AS(fourier.transform(std::span<double>(spectrum).first(n - 1)), std::logic_error);
  }
}
