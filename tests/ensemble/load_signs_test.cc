#include "ensemble/multiplexed_estimator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <vector>

#include "sampling/random_key.h"

namespace granuscope {
namespace {

std::vector<double> signs_of(std::uint64_t sample, int run, std::size_t columns) {
  std::vector<double> signs(columns);
  draw_signs(9, sample, run, signs);
  return signs;
}

}  // namespace

TEST_CASE("signs of the loads: runs of one bead are the fair bits of the key") {
  const std::vector<double> signs = signs_of(4, 1, 77);
  for (std::size_t i = 0; i < signs.size(); ++i) {
    CHECK(signs[i] == (RandomKey(9, 4).load_bit(static_cast<int>(i)) ? 1 : -1));
  }
}

TEST_CASE("signs of the loads: runs have the length asked for or one bead more, and every sample its own") {
  for (const int run : {2, 3, 7}) {
    const auto shortest = static_cast<std::size_t>(run);
    std::set<std::vector<double>> seen;
    double sum = 0;
    constexpr std::size_t columns = 120;
    constexpr std::uint64_t samples = 400;
    for (std::uint64_t sample = 0; sample < samples; ++sample) {
      const std::vector<double> signs = signs_of(sample, run, columns);
      seen.insert(signs);
      std::size_t since = 0;
      for (std::size_t i = 0; i < columns; ++i) {
        REQUIRE(std::abs(signs[i]) == 1);
        sum += signs[i];
        ++since;
        if (i + 1 < columns && signs[i + 1] == signs[i]) continue;
        // Neighbouring runs may share their sign: a stretch is a sum of lengths `run` and `run` + 1.
        const std::size_t runs = since / shortest;
        if (i + 1 < columns) CHECK((runs >= 1 && since <= runs * (shortest + 1)));
        since = 0;
      }
    }
    CHECK(seen.size() == samples);
    // Five sigma; the mean of a sample has the variance of its number of runs.
    CHECK(std::abs(sum / (columns * samples)) < 5 * std::sqrt((run + 1.0) / (columns * samples)));
  }
}

TEST_CASE("signs of the loads: runs move power to long waves and leave none without") {
  constexpr std::size_t columns = 96;
  constexpr std::uint64_t samples = 3000;
  const RealSpectrum fourier(columns);
  for (const int run : {2, 3}) {
    std::vector<double> power(columns / 2 + 1);
    for (std::uint64_t sample = 0; sample < samples; ++sample) {
      std::vector<double> signs = signs_of(sample, run, columns);
      fourier.transform(signs);
      for (std::size_t m = 1; 2 * m < columns; ++m) {
        power[m] += (signs[2 * m - 1] * signs[2 * m - 1] + signs[2 * m] * signs[2 * m]) / (columns * samples);
      }
    }
    // One fair sign a bead has the power 1 at every wave. Runs of L and L + 1 beads have
    //   sum of sin^2(k L/2)/sin^2(k/2) over both lengths / (2 L + 1),
    // apart from the last run of the ring, which is cut off.
    for (std::size_t m = 2; 2 * m < columns; m += 5) {
      const double half_k = M_PI * static_cast<double>(m) / columns, sine = std::sin(half_k);
      const double expected =
          (std::pow(std::sin(half_k * run) / sine, 2) + std::pow(std::sin(half_k * (run + 1)) / sine, 2)) /
          (2 * run + 1);
      CHECK(power[m] == Approx(expected).epsilon(0.1 + 5 / std::sqrt(double(samples))).margin(0.02));
      CHECK(power[m] > 0.05);
    }
    CHECK(power[2] > 0.9 * (run + 0.5));
  }
}

}  // namespace granuscope
