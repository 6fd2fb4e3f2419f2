#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/mean_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "kit/linear_response.h"
#include "support/error.h"

using namespace granuscope;

namespace {

EnsembleSpec multiplexed(double mu, int columns, int layers) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = mu;
  spec.sampler.seed = 3;
  spec.lattice = {.columns = columns, .layers = layers};
  spec.response.samples = 128;
  spec.response.blocks = 16;
  return spec;
}

}  // namespace

TEST_CASE("multiplexed: the top layers respond as geometry has it, and every layer carries the whole load") {
  for (const int columns : {20, 21}) {
    const EnsembleSpec spec = multiplexed(0.5, columns, 30);
    const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
    const Lattice lattice(spec.lattice);
    for (std::size_t row = 0; row < 30; ++row) {
      const BlockMeans response = mean_response(record.sums, row, 1);
      const auto check = [&](const std::vector<double>& profile) {
        double sum = 0;
        for (int i = 0; i < columns; ++i) {
          const double value = profile[static_cast<std::size_t>(i)];
          sum += value;
          const double x = lattice.x(static_cast<int>(row), i);
          if (row == 0) CHECK(value == Approx(x == 0 ? 1 : 0).margin(1e-12));
          // Each of the two beads below takes half, whatever their splits.
          if (row == 1) CHECK(value == Approx(std::abs(x) == 0.5 ? 0.5 : 0).margin(1e-12));
        }
        CHECK(sum == Approx(1).epsilon(1e-11));
      };
      check(response.whole);
      check(response.without_block[7]);
    }
  }
}

TEST_CASE("multiplexed: modes are those of the mean response") {
  const EnsembleSpec spec = multiplexed(0.5, 30, 40);
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  for (const int layer : {18, 19}) {
    const Lattice lattice(spec.lattice);
    const auto row = static_cast<std::size_t>(layer);
    const LayerSpectrum spectrum = layer_spectrum(record.sums, row, 1);
    const BlockMeans response = mean_response(record.sums, row, 1);
    REQUIRE(spectrum.whole.size() == 14);
    for (int m = 1; m <= 14; ++m) {
      double whole = 0, without = 0;
      for (int i = 0; i < 30; ++i) {
        const double cosine = std::cos(2 * std::numbers::pi * m * lattice.x(layer, i) / 30);
        whole += response.whole[static_cast<std::size_t>(i)] * cosine;
        without += response.without_block[4][static_cast<std::size_t>(i)] * cosine;
      }
      const auto at = static_cast<std::size_t>(m) - 1;
      CHECK(spectrum.whole[at] == Approx(whole).margin(1e-11));
      CHECK(spectrum.without_block[4][at] == Approx(without).margin(1e-11));
      CHECK(spectrum.noise[at] > 0);
    }
  }
}

// The eight piles of a chain share their loads: one pattern of signs in each block, which may lack a mode altogether.
TEST_CASE("multiplexed: a block whose loads lack a mode says nothing about it, and leaves its noise known") {
  EnsembleSpec spec = multiplexed(0.5, 20, 30);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  constexpr std::size_t row = 6, mode = 3, block = 2, columns = 20, layers = 30;
  const double before = layer_spectrum(record.sums, row, 1).noise[mode - 1];
  std::vector<double>& sums = record.sums.quantities.at("correlation").sum;
  for (const std::size_t at : {std::size_t{0}, row}) {
    for (const std::size_t part : {2 * mode - 1, 2 * mode}) sums[(block * layers + at) * columns + part] = 0;
  }
  const LayerSpectrum spectrum = layer_spectrum(record.sums, row, 1);
  CHECK(std::isfinite(spectrum.whole[mode - 1]));
  for (const double noise : spectrum.noise) CHECK(std::isfinite(noise));
  CHECK(spectrum.noise[mode - 1] > before / 2);
  CHECK(spectrum.noise[mode - 1] < before * 2);
}

TEST_CASE("multiplexed: without friction c is tan 30 degrees and D is 0, exactly") {
  FitSpec fit;
  fit.first_layer = 20;
  fit.last_layer = 60;
  fit.shallow_layer = 20;
  EnsembleSpec spec = multiplexed(0, 100, 81);
  spec.layers = layers_to_record(fit, {});
  const Transport t = measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
  CHECK(t.exact);
  CHECK(t.c.value == Approx(tan30).epsilon(1e-11));
  CHECK(std::abs(t.D.value) < 1e-10);
  CHECK(t.c.standard_error == 0);
  CHECK(t.depths.front().layer == 21);  // layer 0 is no depth of the fit
}

TEST_CASE("multiplexed: without layer 0 there is no response") {
  const EnsembleSpec spec = multiplexed(0.5, 20, 30);
  EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  record.sums.layers.front() = 1;
  CHECK_THROWS_AS(mean_response(record.sums, 5, 1), InputError);
}

TEST_CASE("an ensemble without profiles has no response") {
  EnsembleSpec spec = multiplexed(0.5, 20, 30);
  spec.response.estimator = EstimatorName::point;
  spec.record_profiles = false;
  CHECK_THROWS_AS(mean_response(run_ensemble(spec, 0, nullptr).sums, 5, 1), InputError);
}

TEST_CASE("multiplexed and point agree where the response is nearly linear", "[long]") {
  const FitSpec fit;
  for (const auto& [mu, c, c_error, D, D_error] : test::linear_response) {
    EnsembleSpec spec = multiplexed(mu, 500, 200);
    spec.response.samples = 1536;
    spec.response.blocks = 32;
    spec.layers = layers_to_record(fit, {});
    const Transport t = measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
    CAPTURE(mu, t.c.value, t.c.standard_error, t.D.value, t.D.standard_error);
    REQUIRE(t.c.known());
    // Half a unit of the last digit printed by the other code.
    CHECK(std::abs(t.c.value - c) <= 3 * std::hypot(t.c.standard_error, c_error) + 0.5e-4);
    CHECK(std::abs(t.D.value - D) <= 3 * std::hypot(t.D.standard_error, D_error) + 0.5e-4);
    CHECK(t.c.standard_error <= 2 * c_error);
    CHECK(t.D.standard_error <= 1.5 * D_error);
  }
}
