// Sources: sums made by hand; and naive_rejection.h, the law rejection by sequential Monte Carlo, a code of its own
// that shares nothing with the program.
#include "studies/thrust_studies.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "ensemble/ensemble_runner.h"
#include "kit/estimates.h"
#include "kit/naive_rejection.h"
#include "kit/sanitized.h"
#include "kit/small_piles.h"
#include "kit/text_parts.h"
#include "studies/study_page.h"

using namespace granuscope;
using test::contains;
using test::known;
using test::piles_of;

TEST_CASE("The bulk leaves out a margin at both ends; its halves leave out the middle layer of an odd number") {
  const EnsembleSpec spec = piles_of(Law::rejection, 0.3, {4, 13}, 256);
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
  const RejectionThrust measured = measure_rejection_thrust({spec, record}, 4);
  CHECK(measured.first_layer == 4);
  CHECK(measured.last_layer == 8);
  CHECK(measured.samples == 256);
  CHECK(measured.alpha.value == Approx(0.96));
  CHECK(measured.deficit_over_mu2.value == Approx(0.04 / 0.09));
  CHECK(measured.change_with_depth.value == Approx(0.03));  // layers 7, 8 over 4, 5
  CHECK(measured.alpha_of_last_layer.value == Approx(100));
}

TEST_CASE("Under the exact law the thrust ratio settles below 1 by a share of mu squared, as another code has it",
          "[unsanitized]") {
  struct Size {
    double mu;
    LatticeSpec lattice;
  };
  constexpr std::size_t particles = test::sanitized ? 2000 : 10'000;
  for (const auto& [mu, lattice] : {Size{0.1, {6, 30}}, {0.2, {6, 20}}, {0.3, {6, 13}}}) {
    const EnsembleSpec spec = piles_of(Law::rejection, mu, lattice, 1024);
    const RejectionThrust measured = measure_rejection_thrust({spec, run_ensemble(spec, 2, nullptr)}, 4);
    const test::Estimated expected = test::naive_rejection_thrust(
        mu, lattice.columns, lattice.layers, measured.first_layer, measured.last_layer, particles, 8, 11);
    CAPTURE(mu, measured.alpha.value, measured.alpha.standard_error, measured.change_with_depth.value);
    CAPTURE(expected.value, expected.error);
    REQUIRE(measured.alpha.known());
    CHECK(std::abs(measured.alpha.value - expected.value) <
          5 * std::hypot(measured.alpha.standard_error, expected.error));
    CHECK(expected.error < 0.002);
    CHECK(1 - measured.alpha.value > 5 * measured.alpha.standard_error);
    CHECK(measured.deficit_over_mu2.value == Approx((1 - measured.alpha.value) / (mu * mu)));
  }
}

TEST_CASE("Piles for the exact thrust have about as many beads at each width, and a bulk between the margins") {
  for (const double mu : {1e-3, 0.05, 0.1, 0.2, 0.25, 0.3}) {
    const auto sizes = rejection_thrust_sizes(mu);
    REQUIRE(sizes.size() == 3);
    for (const RejectionThrustSize& size : sizes) {
      CAPTURE(mu, size.lattice.columns, size.lattice.layers, size.margin);
      CHECK(size.margin >= 4);
      CHECK(size.lattice.layers - 2 * size.margin >= 2);
      CHECK(size.lattice.layers <= 400);
    }
    CHECK(sizes.front().lattice.columns < sizes.back().lattice.columns);
    CHECK(sizes.front().margin == sizes.back().margin);
  }
}

TEST_CASE("The thrust of the exact law is said to settle below 1 only where the numbers say so") {
  const auto page = [](const std::vector<RejectionThrust>& measured) {
    return study_page(*rejection_thrust_study(measured));
  };
  CHECK_FALSE(contains(page({}).html, "tend to 1 under the exact law"));
  RejectionThrust one;
  one.spec.sampler.mu = 0.3;
  one.spec.lattice = {4, 20};
  one.alpha = known(0.93, 0.001);
  one.deficit_over_mu2 = known(0.78, 0.01);
  one.change_with_depth = known(0.002, 0.002);
  one.alpha_of_last_layer = known(0.99, 0.002);
  std::vector<RejectionThrust> measured(2, one);
  const auto settles = [&] { return contains(page(measured).html, "It does not: at every friction"); };
  CHECK(settles());
  CHECK(page(measured).texts.at("/studies/rejection_thrust/1/deficit_over_mu_squared") == "0.780(10)");
  measured[1].alpha = known(0.996, 0.001);
  CHECK_FALSE(settles());
  measured[1] = one;
  measured[1].change_with_depth = known(0.03, 0.01);
  CHECK_FALSE(settles());
  measured[1].change_with_depth = test::unknown("too few");
  CHECK_FALSE(settles());
  CHECK(contains(page(measured).html, "These piles do not decide it"));
}
