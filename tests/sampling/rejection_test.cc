// Source of the expected numbers: naive_rejection.h, the law written a second time, which draws its own piles of 6 x 6
// beads at mu = 0.3 under a uniform load.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "kit/naive_rejection.h"
#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::Estimated;
using test::RunningMean;

constexpr std::size_t comparisons = 11;  ///< six thrust ratios, four variances, the acceptance

bool agree(Estimated measured, Estimated expected) {
  return std::abs(measured.value - expected.value) <=
         test::sigma_bound(comparisons) * std::hypot(measured.error, expected.error);
}

TEST_CASE("the rejection law meets a second implementation on 6 x 6 beads") {
  constexpr int accepted = 200'000 / test::share_of_samples;
  const Lattice lattice({.columns = 6, .layers = 6});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.seed = 3;
  CAPTURE(spec.seed, accepted);
  const auto expected = test::naive_rejection_moments(0.3, 6, 6, accepted, 5);
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(6, 1.0);
  Pile pile(lattice);
  std::array<RunningMean, 6> alpha, variance;
  for (std::uint64_t sample = 0; sample < accepted; ++sample) {
    if (sampler->draw(sample, load, pile)) throw std::runtime_error("no pile accepted");
    for (int n = 0; n < 6; ++n) {
      double thrust = 0, squares = 0;
      for (int i = 0; i < 6; ++i) {
        const std::size_t at = lattice.index(n, i);
        thrust += pile.H_R[at] - pile.H_L[at];
        squares += std::pow(pile.V_R[at] + pile.V_L[at] - 1, 2);
      }
      alpha[static_cast<std::size_t>(n)].add(std::sqrt(3.0) * thrust / 6);
      variance[static_cast<std::size_t>(n)].add(squares / 6);
    }
    if (sample % 100 == 0) {
      const AuditResult result = audit(pile);
      REQUIRE(result.max_balance_residual <= 1e-12);
      REQUIRE(result.max_cone_violation <= 1e-12);
      assert_identities(pile);
    }
  }
  for (std::size_t n = 0; n < 6; ++n) {
    const Estimated measured_alpha = alpha[n].estimate(), measured_variance = variance[n].estimate();
    const Estimated expected_alpha = expected.thrust_ratio[n].estimate();
    const Estimated expected_variance = expected.weight_variance[n].estimate();
    CAPTURE(n, measured_alpha.value, measured_alpha.error, measured_variance.value, measured_variance.error);
    CAPTURE(expected_alpha.value, expected_alpha.error, expected_variance.value, expected_variance.error);
    CHECK(agree(measured_alpha, expected_alpha));
    // Enough piles to tell neighbouring layers apart.
    CHECK(measured_alpha.error < (test::sanitized ? 4e-3 : 1e-3));
    if (n < 2) {
      // The load alone fixes the weights of the first two layers.
      CHECK(std::abs(measured_variance.value) < 1e-28);
    } else {
      CHECK(agree(measured_variance, expected_variance));
      CHECK(measured_variance.error < (test::sanitized ? 4e-3 : 1e-3));
    }
  }
  const auto tries = static_cast<double>(sampler->counts().tries);
  const double acceptance = accepted / tries;
  const double acceptance_error = std::sqrt(acceptance * (1 - acceptance) / tries);
  CAPTURE(acceptance, acceptance_error, expected.acceptance.value);
  CHECK(agree({acceptance, acceptance_error}, expected.acceptance));
  CHECK(acceptance_error < (test::sanitized ? 5e-4 : 1.5e-4));
}

// What is often expected of the exact law, and what the last layer alone looks like: beads below it would have to be
// solvable, too.
TEST_CASE("under the law rejection the thrust ratio settles below 1, and only the last layer comes near it") {
  constexpr int layers = 14, columns = 4, piles = test::sanitized ? 1000 : 8000;
  const Lattice lattice({.columns = columns, .layers = layers});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.seed = 4;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  std::array<RunningMean, layers> alpha;
  for (std::uint64_t sample = 0; sample < piles; ++sample) {
    if (sampler->draw(sample, std::vector<double>(columns, 1.0), pile)) throw std::runtime_error("no pile accepted");
    for (int n = 0; n < layers; ++n) {
      double thrust = 0;
      for (int i = 0; i < columns; ++i) thrust += pile.H_R[lattice.index(n, i)] - pile.H_L[lattice.index(n, i)];
      alpha[static_cast<std::size_t>(n)].add(std::sqrt(3.0) * thrust / columns);
    }
  }
  const double bound = test::sigma_bound(layers);
  const Estimated last = alpha.back().estimate();
  // From the third layer on, five above the bottom: at least 0.04 below 1, and below the last layer.
  for (std::size_t n = 3; n + 3 < layers; ++n) {
    const Estimated one = alpha[n].estimate();
    CAPTURE(n, one.value, one.error, last.value);
    CHECK(one.value + bound * one.error < (test::sanitized ? 1.0 : 0.97));
    CHECK(test::sigmas(last, one) > bound);
    CHECK(bound * one.error < (test::sanitized ? 0.05 : 0.02));
  }
  CHECK(std::abs(last.value - 1) < 0.03);
}

TEST_CASE("a pile that rejection cannot find within its tries is a named failure") {
  const Lattice lattice({.columns = 20, .layers = 20});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.max_tries = 50;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  const auto failure = sampler->draw(0, std::vector<double>(20, 1.0), pile);
  REQUIRE(failure.has_value());
  CHECK(failure->layer > 0);
  CHECK(failure->layer < 20);
  CHECK(sampler->counts().tries == 50);
}

}  // namespace
}  // namespace granuscope
