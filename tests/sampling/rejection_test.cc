// Source of the expected numbers: an independent implementation of the rejection law, 800 000 accepted piles of 6 x 6
// beads at mu = 0.3 under a uniform load, printed to four digits.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "model/audit.h"
#include "model/identities.h"
#include "sampling/sampler.h"
#include "sampling_statistics.h"

namespace granuscope {
namespace {

using test::Estimated;
using test::RunningMean;

// s_n = (1 - alpha_n)/2 of the contacts leaving layer n, and the variance of the weight of the layer's beads about 1.
constexpr std::array<double, 6> expected_s = {-0.0547, 0.0637, 0.0532, 0.0289, 0.0288, 0.0090};
constexpr std::array<double, 6> expected_variance = {0, 0, 0.1351, 0.1027, 0.1189, 0.1247};
// Standard errors of the independent implementation, and half a unit of its last printed digit.
constexpr double error_of_s = 2e-4, error_of_variance = 4e-4, printed = 5e-5;
constexpr double expected_acceptance = 0.045, acceptance_printed = 5e-4;

constexpr std::size_t comparisons = 11;  ///< six s, four variances, the acceptance

bool agree(Estimated measured, Estimated expected) {
  return std::abs(measured.value - expected.value) <=
         test::sigma_bound(comparisons) * std::hypot(measured.error, expected.error) + printed;
}

TEST_CASE("the rejection law meets an independent implementation on 6 x 6 beads") {
  constexpr int accepted = 200'000 / test::share_of_samples;
  const Lattice lattice({.columns = 6, .layers = 6});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.seed = 3;
  CAPTURE(spec.seed, accepted);
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(6, 1.0);
  Pile pile(lattice);
  std::array<RunningMean, 6> s, variance;
  for (std::uint64_t sample = 0; sample < accepted; ++sample) {
    if (sampler->draw(sample, load, pile)) throw std::runtime_error("no pile accepted");
    for (int n = 0; n < 6; ++n) {
      double thrust = 0, squares = 0;
      for (int i = 0; i < 6; ++i) {
        const std::size_t at = lattice.index(n, i);
        thrust += pile.H_R[at] - pile.H_L[at];
        squares += std::pow(pile.V_R[at] + pile.V_L[at] - 1, 2);
      }
      s[static_cast<std::size_t>(n)].add((1 - std::sqrt(3.0) * thrust / 6) / 2);
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
    const Estimated measured_s = s[n].estimate(), measured_variance = variance[n].estimate();
    CAPTURE(n, measured_s.value, measured_s.error, measured_variance.value, measured_variance.error);
    CHECK(agree(measured_s, {expected_s[n], error_of_s}));
    // Enough piles to tell neighbouring layers apart.
    CHECK(measured_s.error < (test::sanitized ? 2e-3 : 5e-4));
    if (n < 2) {
      // The load alone fixes the weights of the first two layers.
      CHECK(std::abs(measured_variance.value) < 1e-28);
    } else {
      CHECK(agree(measured_variance, {expected_variance[n], error_of_variance}));
      CHECK(measured_variance.error < (test::sanitized ? 4e-3 : 1e-3));
    }
  }
  const auto tries = static_cast<double>(sampler->counts().tries);
  const double acceptance = accepted / tries;
  const double acceptance_error = std::sqrt(expected_acceptance * (1 - expected_acceptance) / tries);
  CAPTURE(acceptance, acceptance_error);
  CHECK(std::abs(acceptance - expected_acceptance) <=
        acceptance_printed + test::sigma_bound(comparisons) * acceptance_error);
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
