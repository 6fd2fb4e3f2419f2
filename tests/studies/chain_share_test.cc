#include "studies/thrust_studies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "analysis/claims.h"
#include "ensemble/ensemble_runner.h"
#include "kit/estimates.h"
#include "model/lattice.h"
#include "studies/made_up_ensemble.h"

using namespace granuscope;
using namespace granuscope::made_up;
using granuscope::test::known;

namespace {

/// Every layer down to the last one shown.
std::vector<int> shown_layers(int count) {
  std::vector<int> layers(static_cast<std::size_t>(count));
  std::iota(layers.begin(), layers.end(), 0);
  return layers;
}

}  // namespace

TEST_CASE("Without friction the whole response lies along the rays") {
  EnsembleSpec spec;
  spec.sampler.mu = 0;
  spec.lattice = {70, 80};
  spec.response.samples = 256;
  spec.layers = shown_layers(60);
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
  MeasuredEnsemble ensemble = ensemble_of(0.3, lattice, shown_layers(80));
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
  MeasuredEnsemble ensemble = ensemble_of(0.3, {70, 30}, shown_layers(10));
  add_quantity(ensemble.record.sums, "thrust", 1, [](int, int, int) { return 0.9; });
  add_quantity(ensemble.record.sums, "weight", 70, [](int, int, int) { return 1.0; });
  const ChainShare share = measure_chain_share(ensemble);
  CHECK_FALSE(share.share.known());
  CHECK_FALSE(share.share.reason.empty());
}

TEST_CASE("Force chains carry more than half of the response and more than an even spread would put there") {
  ChainShare chains;
  chains.spec.sampler.mu = 0.1;
  chains.spec.lattice.columns = 70;
  chains.layers = 60;
  chains.samples = 512;
  chains.c = known(0.575, 0.001);
  chains.even_share = 0.3;
  chains.share = known(0.8, 0.01);
  chains.shown = known(0.9, 0);
  CHECK(judge_force_chains({chains}, 0.5).verdict == reproduced);
  CHECK(judge_force_chains({chains}, 0.5).measured.value == 0.9);
  chains.shown = known(0.4, 0);  // in the pile shown, whatever the mean
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_reproduced);
  chains.shown = known(0.6, 0);
  chains.even_share = 0.7;
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_reproduced);
  chains.shown = test::unknown("no layer lies deep enough");
  CHECK(judge_force_chains({chains}, 0.5).verdict == not_tested);
}

TEST_CASE("The share of the pile shown is that of the sample of the picture") {
  EnsembleSpec spec;
  spec.lattice = {70, 60 + bottom_margin};
  spec.sampler.mu = 0.1;
  spec.response.samples = 256;
  spec.layers = shown_layers(60);
  ChainShare chains = measure_chain_share({spec, run_ensemble(spec, 1, nullptr)});
  double sum = 0;
  for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
    measure_shown_pile(chains, sample);
    REQUIRE(chains.shown.known());
    sum += chains.shown.value;
  }
  // The same piles: their shares average to that of their mean.
  CHECK(sum / 256 == Approx(chains.share.value).epsilon(1e-9));
}
