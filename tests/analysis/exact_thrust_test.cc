// Sources: sums made by hand; and the law rejection by sequential Monte Carlo, a code of its own that shares nothing
// with the program (40 000 particles that are drawn layer by layer from survivors of the layer above, four runs): alpha
// of layers 5 to 25 of 30 on six columns is 0.992 at mu = 0.1 and 0.968 at 0.2, and on 6, 8 and 12 columns 0.927 at
// 0.3.
#include "analysis/exact_thrust.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

EnsembleSpec rejected_piles(double mu, LatticeSpec lattice, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.sampler.law = Law::rejection;
  spec.sampler.mu = mu;
  spec.lattice = lattice;
  spec.load = Load::uniform;
  spec.record_profiles = false;
  spec.response.samples = samples;
  spec.response.blocks = 32;
  return spec;
}

}  // namespace

TEST_CASE("The bulk leaves out a margin at both ends; its halves leave out the middle layer of an odd number") {
  const EnsembleSpec spec = rejected_piles(0.3, {4, 13}, 256);
  EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  BlockSums& sums = record.sums;
  const auto set_thrust = [&](const auto& alpha_of) {
    auto& sum = sums.quantities.at("thrust").sum;
    for (std::size_t block = 0; block < sums.count.size(); ++block) {
      for (std::size_t row = 0; row < sums.layers.size(); ++row) {
        sum[block * sums.layers.size() + row] = static_cast<double>(sums.count[block]) * alpha_of(sums.layers[row]);
      }
    }
  };
  set_thrust([](int layer) { return layer < 4 || layer > 8 ? 100.0 : 0.9 + 0.01 * layer; });
  const ExactThrust measured = measure_exact_thrust(spec, record, 4);
  CHECK(measured.first_layer == 4);
  CHECK(measured.last_layer == 8);
  CHECK(measured.samples == 256);
  CHECK(measured.alpha.value == Approx(0.96));
  CHECK(measured.deficit_over_mu2.value == Approx(0.04 / 0.09));
  CHECK(measured.change_with_depth.value == Approx(0.03));  // layers 7, 8 over 4, 5
  CHECK(measured.alpha_of_last_layer.value == Approx(100));
}

TEST_CASE("Under the exact law the thrust ratio settles below 1 by a share of mu squared, as another code has it") {
  struct Known {
    double mu;
    LatticeSpec lattice;
    double alpha;
  };
  for (const auto& [mu, lattice, alpha] : {Known{0.1, {6, 30}, 0.992}, {0.2, {6, 20}, 0.968}, {0.3, {6, 13}, 0.927}}) {
    const EnsembleSpec spec = rejected_piles(mu, lattice, 1024);
    const ExactThrust measured = measure_exact_thrust(spec, run_ensemble(spec, 2, nullptr), 4);
    CAPTURE(mu, measured.alpha.value, measured.alpha.standard_error, measured.change_with_depth.value);
    REQUIRE(measured.alpha.known());
    const double printed = 0.002;  // layers of the bulk differ by as much
    CHECK(std::abs(measured.alpha.value - alpha) < printed + 5 * measured.alpha.standard_error);
    CHECK(1 - measured.alpha.value > 5 * measured.alpha.standard_error);
    CHECK(measured.deficit_over_mu2.value == Approx((1 - measured.alpha.value) / (mu * mu)));
  }
}

TEST_CASE("Piles for the exact thrust have about as many beads at each width, and a bulk between the margins") {
  for (const double mu : {1e-3, 0.05, 0.1, 0.2, 0.25, 0.3}) {
    const auto sizes = exact_thrust_sizes(mu);
    REQUIRE(sizes.size() == 3);
    for (const ExactThrustSize& size : sizes) {
      CAPTURE(mu, size.lattice.columns, size.lattice.layers, size.margin);
      CHECK(size.margin >= 4);
      CHECK(size.lattice.layers - 2 * size.margin >= 2);
      CHECK(size.lattice.layers <= 400);
    }
    CHECK(sizes.front().lattice.columns < sizes.back().lattice.columns);
    CHECK(sizes.front().margin == sizes.back().margin);
  }
}
