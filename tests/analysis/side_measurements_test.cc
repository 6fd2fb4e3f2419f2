#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/chain_share.h"
#include "analysis/counted_work.h"
#include "analysis/small_friction.h"
#include "ensemble/ensemble_runner.h"
#include "model/lattice.h"

using namespace granuscope;

namespace {

constexpr int blocks = 32;

/// Adds a quantity whose sums over each block's `samples` piles are samples * value(block, row, i).
template <typename Value>
void add_quantity(BlockSums& sums, const char* name, int width, Value value) {
  QuantitySums& q = sums.quantities[name];
  q.width = width;
  for (int b = 0; b < sums.blocks(); ++b) {
    for (int row = 0; row < static_cast<int>(sums.layers.size()); ++row) {
      for (int i = 0; i < width; ++i) {
        const double mean = value(b, row, i), count = static_cast<double>(sums.count[static_cast<std::size_t>(b)]);
        q.sum.push_back(count * mean);
        q.sum_of_squares.push_back(count * mean * mean);
      }
    }
  }
}

MeasuredEnsemble ensemble_of(double mu, LatticeSpec lattice, std::vector<int> layers) {
  MeasuredEnsemble ensemble;
  ensemble.spec.sampler.mu = mu;
  ensemble.spec.lattice = lattice;
  ensemble.record.sums.layers = std::move(layers);
  ensemble.record.sums.count.assign(blocks, 8);
  return ensemble;
}

}  // namespace

TEST_CASE("Without friction the whole response lies along the rays") {
  EnsembleSpec spec;
  spec.sampler.mu = 0;
  spec.lattice = {70, 80};
  spec.response.samples = 256;
  spec.layers = chain_layers(60);
  const ChainShare share = measure_chain_share({spec, run_ensemble(spec, 1, nullptr)});
  CHECK(share.layers == 60);
  CHECK(std::abs(share.c.value - tan30) < 1e-14);
  CHECK(std::abs(share.share.value - 1) < 1e-12);
  // From c0 z >= 6 on: z = 10.39, layer 12 of 0 .. 59.
  REQUIRE(share.depths.size() == 48);
  CHECK(share.depths.front().layer == 12);
  CHECK(share.depths.front().even_share == Approx(6 / (tan30 * Lattice::depth(12) + 3)));
}

TEST_CASE("A response spread evenly between the rays has the even share") {
  const LatticeSpec lattice{200, 100};
  MeasuredEnsemble ensemble = ensemble_of(0.3, lattice, chain_layers(80));
  const Lattice geometry(lattice);
  add_quantity(ensemble.record.sums, "thrust", 1, [](int, int, int) { return 0.81; });
  const double c = tan30 * 0.9;
  add_quantity(ensemble.record.sums, "weight", lattice.columns, [&](int, int row, int i) {
    const double reach = c * Lattice::depth(row) + chain_half_width, x = geometry.x(row, i);
    const double covered = std::max(0.0, std::min(x + 0.5, reach) - std::max(x - 0.5, -reach));
    return 1 + covered / (2 * reach);
  });
  const ChainShare share = measure_chain_share(ensemble);
  CHECK(share.c.value == Approx(c));
  for (const ChainShareAtDepth& depth : share.depths) {
    CAPTURE(depth.layer);
    // A bead that an edge of a band cuts is counted by width, whatever lies in it: an error of a few percent of a bead.
    CHECK(std::abs(depth.share.value - depth.even_share) < 0.5 / (c * depth.z + chain_half_width));
  }
  // Of an edge bead of which the part f is inside, f^2 is counted: on average 1/6 too little on either side.
  CHECK(share.share.value == Approx(share.even_share * (1 - 1 / (12 * chain_half_width))).epsilon(0.005));
}

TEST_CASE("Piles too shallow for two bands give a reason instead of a share") {
  MeasuredEnsemble ensemble = ensemble_of(0.3, {70, 30}, chain_layers(10));
  add_quantity(ensemble.record.sums, "thrust", 1, [](int, int, int) { return 0.9; });
  add_quantity(ensemble.record.sums, "weight", 70, [](int, int, int) { return 1.0; });
  const ChainShare share = measure_chain_share(ensemble);
  CHECK_FALSE(share.share.known());
  CHECK_FALSE(share.share.reason.empty());
}

TEST_CASE("The layers of a deep narrow pile are usable, ascending and of both row parities") {
  for (const int layers : {45, 260, 6020, 100'000}) {
    const std::vector<int> recorded = thrust_layers(layers);
    CAPTURE(layers);
    CHECK(std::is_sorted(recorded.begin(), recorded.end()));
    CHECK(recorded.back() == layers - bottom_margin - 1);
    CHECK(recorded.front() >= 0);
    CHECK(recorded.size() <= 1050);
    const auto odd = std::count_if(recorded.begin(), recorded.end(), [](int layer) { return layer % 2 == 1; });
    CHECK(std::abs(2.0 * static_cast<double>(odd) - static_cast<double>(recorded.size())) <=
          0.2 * static_cast<double>(recorded.size()) + 4);
  }
}

TEST_CASE("A thrust that falls as mu squared gives the exponent 2 within its error") {
  const std::vector<double> friction{0.02, 0.03, 0.05, 0.1};
  constexpr double prefactor = 0.25;  // c0 - c = 0.25 mu^2
  std::mt19937_64 random(7);
  std::vector<MeasuredSmallFriction> measured;
  for (const double mu : friction) {
    MeasuredEnsemble ensemble = ensemble_of(mu, {64, 400}, thrust_layers(400));
    const double c = tan30 - prefactor * mu * mu, alpha = c * c / (tan30 * tan30);
    std::normal_distribution<double> noise(0.0, 0.05 * (1 - alpha));
    add_quantity(ensemble.record.sums, "thrust", 1, [&](int, int, int) { return alpha + noise(random); });
    add_quantity(ensemble.record.sums, "weight_variance", 1, [](int, int, int) { return 0.15; });
    measured.push_back(measure_small_friction(ensemble));
    const SmallFriction& result = measured.back().result;
    CAPTURE(mu);
    CHECK(result.depth_over_saturation == Approx(400 * mu * mu / 0.6));
    CHECK(result.first_layer == 190);
    CHECK(result.last_layer == 379);
    CHECK(std::abs(result.c0_minus_c.value - prefactor * mu * mu) < 4 * result.c0_minus_c.standard_error);
    CHECK(result.c0_minus_c.standard_error < 0.01 * prefactor * mu * mu);
  }
  const ScalingFit fit = fit_small_friction(measured);
  REQUIRE(fit.exponent.known());
  CHECK(fit.points == 4);
  CHECK(fit.window == std::array<double, 2>{0.02, 0.1});
  CHECK(std::abs(fit.exponent.value - 2) < 4 * fit.exponent.standard_error);
  CHECK(fit.exponent.standard_error < 0.01);
}

TEST_CASE("Counted work divides the counts by the beads that were completed") {
  MeasuredEnsemble ensemble = ensemble_of(0.3, {10, 30}, {5});
  ensemble.record.counts.beads = 1000;
  ensemble.record.counts.uniforms = 1500;
  ensemble.record.counts.mended_by_pair = 100;
  ensemble.record.counts.mended_by_arc = 20;
  ensemble.record.counts.mended_by_ring = 3;
  ensemble.record.counts.climbed = 7;
  ensemble.record.failed.push_back({3, 4, ""});
  const CountedWork work = counted_work(ensemble);
  CHECK(work.samples == 256);
  CHECK(work.failed == 1);
  CHECK(work.draws_per_bead == 1.5);
  CHECK(work.mended_per_bead == 0.123);
  CHECK(work.climbed_per_bead == 0.007);
  ensemble.record.counts = {};
  CHECK_FALSE(std::isfinite(counted_work(ensemble).draws_per_bead));
}
