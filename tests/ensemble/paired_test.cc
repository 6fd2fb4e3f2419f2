// Source of the expected numbers: each pair of piles drawn by itself and summed straight from the definitions.
#include <catch2/catch.hpp>
#include <cmath>

#include "ensemble/ensemble_runner.h"
#include "ensemble/point_estimator.h"
#include "ensemble/small_ensemble.h"
#include "sampling/pile_group.h"

namespace granuscope {
namespace {

EnsembleSpec small_ensemble() {
  return test::small_ensemble({.estimator = EstimatorName::paired, .overload = 0.5}, 24);
}

}  // namespace

TEST_CASE("paired: block sums are those of separately drawn pairs") {
  const EnsembleSpec spec = small_ensemble();
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  std::vector<double> load(24, 1.0), overloaded = load;
  overloaded[12] += 0.5;
  Pile before(lattice), after(lattice);
  std::vector<unsigned char> redrawn;
  const std::size_t block = 3, layer = 22;
  std::vector<double> response(24);
  double share = 0, below = 0, thrust = 0, response_thrust = 0;
  for (std::uint64_t sample = 24; sample < 32; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, load, before).has_value());
    REQUIRE_FALSE(sampler->draw_again(sample, overloaded, before, after).has_value());
    find_redrawn(before, after, redrawn);
    double H = 0, H_after = 0;
    int redrawn_here = 0;
    for (std::size_t i = 0; i < 24; ++i) {
      const std::size_t at = layer * 24 + i;
      response[i] += (after.V_R[at] + after.V_L[at] - before.V_R[at] - before.V_L[at]) / 0.5;
      redrawn_here += redrawn[at];
      H += before.H_R[at] - before.H_L[at];
      H_after += after.H_R[at] - after.H_L[at];
    }
    share += redrawn_here / 24.0;
    below += redrawn_here / 24.0;  // z = 19.6: the whole ring of 24 lies within |x| <= z
    thrust += sqrt3 * H / 24;
    response_thrust += sqrt3 * (H_after - H) / 0.5;
  }
  const std::size_t row = block * 30 + layer;
  CHECK(record.sums.count[block] == 8);
  CHECK(record.sums.quantities.at("redrawn").sum[row] == Approx(share).epsilon(1e-13));
  CHECK(record.sums.quantities.at("redrawn_below_overload").sum[row] == Approx(below).epsilon(1e-13));
  CHECK(record.sums.quantities.at("thrust").sum[row] == Approx(thrust).epsilon(1e-13));
  CHECK(record.sums.quantities.at("response_thrust").sum[row] == Approx(response_thrust).epsilon(1e-11));
  CHECK(share > 0);
  double sum = 0;
  for (std::size_t i = 0; i < 24; ++i) {
    CHECK(record.sums.quantities.at("response").sum[row * 24 + i] == Approx(response[i]).margin(1e-11));
    sum += record.sums.quantities.at("response").sum[row * 24 + i];
  }
  CHECK(sum == Approx(8).epsilon(1e-11));  // the overload arrives whole in every layer, in every sample
}

TEST_CASE("paired: near the top the response is that of the geometry") {
  // Layer 0 carries the overload itself; in layer 1 the two beads below share it, whatever the splits.
  const EnsembleSpec spec = small_ensemble();
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const std::vector<double>& sum = record.sums.quantities.at("response").sum;
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 24; ++i) {
      CHECK(sum[b * 30 * 24 + i] == Approx(i == 12 ? 8 : 0).margin(1e-12));
      CHECK(sum[(b * 30 + 1) * 24 + i] == Approx(i == 11 || i == 12 ? 4 : 0).margin(1e-12));
    }
  }
}

TEST_CASE("paired: any number of threads gives the same bytes") {
  EnsembleSpec spec = small_ensemble();
  spec.response.blocks = 9;
  spec.response.samples = 8 * 11 + 3;
  const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
  for (const int threads : {2, 5}) CHECK(test::same_bytes(run_ensemble(spec, threads, nullptr), one));
}

TEST_CASE("paired: without friction nothing is redrawn") {
  EnsembleSpec spec = small_ensemble();
  spec.sampler.mu = 0;
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  for (const double share : record.sums.quantities.at("redrawn").sum) CHECK(share == 0);
}

TEST_CASE("ensembles of different estimators, overloads and epsilons are told apart") {
  EnsembleSpec point = small_ensemble(), paired = point, stronger = point;
  point.response.estimator = EstimatorName::point;
  stronger.response.overload = 1;
  CHECK(configuration_text(point) != configuration_text(paired));
  CHECK(configuration_text(stronger) != configuration_text(paired));
  CHECK(estimator_named("paired") == EstimatorName::paired);
  CHECK(name_of(EstimatorName::multiplexed) == "multiplexed");
}

}  // namespace granuscope
