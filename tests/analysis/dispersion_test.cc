// c(k) and D(k) from the correlations of layers: against a linear model whose modes have one c and one D, and against
// waves whose c and D change with k in a known way.
#include "analysis/dispersion.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/linear_model.h"

using namespace granuscope;
using test::LinearModel;

namespace {

const std::vector<double> edges{0.05, 0.1, 0.2, 0.4};

/// Sums without noise, in two blocks that are alike: fields of amplitudes 1 and s, of which mode k travels at c(k),
/// decays by D(k), and starts with an amplitude and an offset of its own.
template <typename Speed, typename Diffusion>
BlockSums exact_waves(int columns, const std::vector<int>& lags, double s, Speed c, Diffusion D) {
  BlockSums sums;
  sums.layers = lags;
  sums.count = {8, 8};
  const auto width = static_cast<std::size_t>(2 * columns);
  std::vector<double> sum(2 * lags.size() * width);
  for (std::size_t block = 0; block < 2; ++block) {
    for (std::size_t row = 0; row < lags.size(); ++row) {
      const double z = Lattice::depth(lags[row]) - Lattice::depth(0);
      for (int m = 1; 4 * m <= columns; ++m) {
        const double k = 2 * std::numbers::pi * m / columns;
        const double size = 8 * (1 + 0.1 * k) * std::exp(-k * k * (0.7 + D(k) * z) / 2), phase = k * (0.3 + c(k) * z);
        double* const part = &sum[(block * lags.size() + row) * width + 4 * (static_cast<std::size_t>(m) - 1)];
        part[0] = size * std::cos(phase);
        part[1] = size * s * s * std::cos(phase);
        part[2] = part[3] = -size * s * std::sin(phase);
      }
    }
  }
  sums.quantities["propagation"] = {2 * columns, sum, std::vector<double>(sum.size())};
  return sums;
}

}  // namespace

TEST_CASE("a band of modes between edges gives the c and D with which it travels, free of amplitude and offset") {
  const BlockSums sums = exact_waves(
      400, {0, 30, 70}, 0.53, [](double) { return 0.55; }, [](double) { return 0.2; });
  for (const double c_start : {0.53, 0.57}) {
    const auto bands = measure_dispersion(sums, 1, 2, edges, {c_start, 0.1});
    REQUIRE(bands.size() == 3);
    int modes = 0;
    for (const BandOfModes& band : bands) {
      CHECK(band.c.value == Approx(0.55).epsilon(1e-9));
      CHECK(band.D.value == Approx(0.2).epsilon(1e-8));
      CHECK(band.k > band.k_from);
      CHECK(band.k < band.k_to);
      CHECK(band.z_to - band.z_from == Approx(40 * std::sqrt(3) / 2));
      modes += band.modes;
    }
    // Of the modes 0.0157 m, those from 0.05 to 0.4: 4 to 25.
    CHECK(modes == 22);
  }
}

TEST_CASE("c and D that change with k are found band by band") {
  const auto c = [](double k) { return 0.55 - 0.05 * k * k; };
  const auto D = [](double k) { return 0.05 / std::sqrt(k); };
  const BlockSums sums = exact_waves(4000, {0, 60, 120}, 0.5, c, D);
  std::vector<double> narrow;
  for (double k = 0.1; k < 0.4; k += 0.02) narrow.push_back(k);
  for (const BandOfModes& band : measure_dispersion(sums, 1, 2, narrow, {0.55, 0.1})) {
    CHECK(band.c.value == Approx(c(band.k)).epsilon(1e-4));
    CHECK(band.D.value == Approx(D(band.k)).epsilon(1e-2));
  }
}

TEST_CASE("bands without modes are left out, and a band that nothing describes is unknown") {
  BlockSums sums = exact_waves(
      40, {0, 30, 70}, 0.5, [](double) { return 0.55; }, [](double) { return 0.1; });
  const auto bands = measure_dispersion(sums, 1, 2, edges, {0.55, 0.1});
  REQUIRE(bands.size() == 2);  // the first mode is 0.157
  for (double& part : sums.quantities.at("propagation").sum) part = 0;
  CHECK(measure_dispersion(sums, 1, 2, edges, {0.55, 0.1}).empty());
  BlockSums turned = exact_waves(
      40, {0, 30, 70}, 0.5, [](double) { return 0.55; }, [](double) { return 0.1; });
  std::vector<double>& sum = turned.quantities.at("propagation").sum;
  for (std::size_t at = 0; at < sum.size(); at += 4) sum[at + 2] = -sum[at + 2];
  for (const BandOfModes& band : measure_dispersion(turned, 1, 2, edges, {0.55, 0.1})) {
    CHECK_FALSE(band.c.known());
    CHECK(band.c.reason.find("two modes of sound") != std::string::npos);
  }
  const auto widest = half_octave_bands(1536);
  CHECK(widest.back() == Approx(1));
  CHECK(widest.front() <= 2 * std::numbers::pi / 1536);
  CHECK(widest[1] > 2 * std::numbers::pi / 1536);
}

TEST_CASE("the dispersion of a linear model covers its c and D", "[long]") {
  constexpr int ensembles = 100;
  int inside = 0, numbers = 0;
  double pulls = 0;
  for (std::uint64_t r = 0; r < ensembles; ++r) {
    const MeasuredEnsemble ensemble = test::linear_ensemble({}, 5000 + r, 24, {30, 60}, 32, 2);
    for (const BandOfModes& band : measure_dispersion(ensemble.record.sums, 1, 2, edges, {0.55, 0.1})) {
      REQUIRE(band.c.known());
      for (const double pull : {(band.c.value - LinearModel::c) / band.c.standard_error,
                                (band.D.value - LinearModel::D) / band.D.standard_error}) {
        inside += std::abs(pull) <= 1 ? 1 : 0;
        ++numbers;
        pulls += pull;
      }
    }
  }
  CHECK(numbers >= 4 * ensembles);
  CHECK(static_cast<double>(inside) / numbers == Approx(0.683).margin(0.05));
  CHECK(std::abs(pulls / numbers) < 0.15);
}
