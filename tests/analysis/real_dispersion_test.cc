// c(k) of real piles: against the speed that follows from their thrust, which long waves should have, and in bases that
// lie where long waves still build up.
#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "analysis/dispersion.h"
#include "analysis/mean_response.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

struct WavesOfPiles {
  Estimate c_thrust;
  std::vector<BandOfModes> bands;
};

/// Over the way from the reference lag to `lag` layers below it.
WavesOfPiles waves(double mu, LatticeSpec lattice, std::uint64_t piles, int first_base, int lag,
                   const std::vector<double>& edges, double D) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::fluctuation;
  spec.response.samples = piles;
  spec.response.first_base = first_base;
  spec.sampler.mu = mu;
  spec.sampler.seed = 41;
  spec.lattice = lattice;
  spec.layers = {lag};
  const BlockSums sums = run_ensemble(spec, 0, nullptr).sums;
  const Estimate c_thrust = estimate(thrust_speed(sums, 0));
  return {c_thrust, measure_dispersion(sums, 0, 1, edges, {c_thrust.value, D})};
}

/// c(k) less c_thrust, whose error is far smaller.
Estimate above_thrust(const WavesOfPiles& piles, std::size_t band) {
  const Estimate& c = piles.bands.at(band).c;
  return {.value = c.value - piles.c_thrust.value,
          .standard_error = std::hypot(c.standard_error, piles.c_thrust.standard_error),
          .reason = c.reason};
}

}  // namespace

TEST_CASE("long waves have the speed of the thrust at small friction, shorter ones less", "[unsanitized]") {
  // 1024 piles of 1500 layers once: -1.2(5)e-4, -2.4(4)e-4, -3.3(2)e-4 and -5.9(2)e-4 at k = 0.125 to 0.25, to 0.37, to
  // 0.74 and to 1.1, nearly in proportion to k.
  const WavesOfPiles piles = waves(0.1, {300, 900}, 512, 0, 60, {0.06, 0.125, 0.25, 0.37, 0.74, 1.1}, 0.005);
  for (const std::size_t longest : {0U, 1U}) {
    const Estimate off = above_thrust(piles, longest);
    CAPTURE(longest, off.value, off.standard_error);
    CHECK(std::abs(off.value) < 4 * off.standard_error);
  }
  CHECK(above_thrust(piles, 1).standard_error < 2e-4);
  const Estimate shorter = above_thrust(piles, 3), shortest = above_thrust(piles, 4);
  CAPTURE(shorter.value, shorter.standard_error, shortest.value, shortest.standard_error);
  CHECK(shorter.value < -4 * shorter.standard_error);
  CHECK(shortest.value < shorter.value);
  CHECK(shortest.value > -1e-3);
}

TEST_CASE("at mu = 0.3 waves are faster than their thrust has it, unless they are very long", "[long]") {
  // Once with 1024 piles: 0.0016(3), 0.00157(9), 0.00209(6) and 0.00231(8) at k = 0.03 to 0.06, to 0.125, to 0.25 and
  // to 0.37, and 0.001(1) below: the limit is not yet seen, but c(k) comes nearer to it.
  const WavesOfPiles piles = waves(0.3, {600, 1600}, 512, 600, 240, {0.015, 0.03, 0.06, 0.125, 0.25, 0.37}, 0.09);
  const Estimate lowest = above_thrust(piles, 0), low = above_thrust(piles, 2), high = above_thrust(piles, 4);
  CAPTURE(lowest.value, lowest.standard_error, low.value, low.standard_error, high.value, high.standard_error);
  CHECK(std::abs(lowest.value) < 4 * lowest.standard_error);
  CHECK(lowest.standard_error < 2e-3);
  CHECK(low.value > 4 * low.standard_error);
  CHECK(high.value - low.value > 2 * std::hypot(low.standard_error, high.standard_error));
  CHECK(std::abs(high.value) < 0.004);
}

TEST_CASE("bases from layer 60 on give no faster waves than deep ones at mu = 0.5", "[long]") {
  // Waves that are not saturated might seem faster by 0.003. They are not: -0.0011(9) at k = 0.06 to 0.1 and -0.0015(5)
  // at 0.1 to 0.2, with four times the deep piles.
  const std::vector<double> edges{0.06, 0.1, 0.2};
  const WavesOfPiles shallow = waves(0.5, {1024, 420}, 2048, 60, 240, edges, 0.37),
                     deep = waves(0.5, {1024, 1600}, 256, 800, 240, edges, 0.37);
  for (const std::size_t band : {0U, 1U}) {
    const Estimate &top = shallow.bands.at(band).c, &bottom = deep.bands.at(band).c;
    const double faster = top.value - bottom.value, error = std::hypot(top.standard_error, bottom.standard_error);
    CAPTURE(band, faster, error);
    CHECK(0.003 - faster > 3 * error);
    CHECK(faster > -0.003 - 3 * error);
    CHECK(error < 0.0013);
  }
}
