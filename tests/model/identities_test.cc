// Source: the balances of neighbouring beads, eliminated by hand. The sum of w is the sum of the loads; and two layers
// apart w_{n+1}(x) - w_{n-1}(x) = sqrt(3) [H_n(x - 1/2) - H_n(x + 1/2)].
#include "model/audit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "central_pile.h"

namespace granuscope {
namespace {

using test::central_pile;
using test::uniform_frictionless_pile;

TEST_CASE("the identities hold on piles in balance") {
  for (const double mu : {0.1, 0.5, 1.0, 1.6}) {
    for (const int columns : {4, 5, 12}) {
      INFO("mu " << mu << ", columns " << columns);
      const Pile pile = central_pile(Lattice({.columns = columns, .layers = 6}), mu, 9);
      const IdentityResiduals residuals = identity_residuals(pile);
      CHECK(residuals.weight_sum <= 1e-14);
      CHECK(residuals.wave_equation <= 1e-14);
      CHECK_NOTHROW(assert_identities(pile));
    }
  }
}

TEST_CASE("a corrupted vertical force breaks the sum of weights by its amount") {
  const Pile sound = uniform_frictionless_pile(Lattice({.columns = 5, .layers = 6}));
  for (auto array : {&Pile::V_R, &Pile::V_L}) {
    Pile broken = sound;
    (broken.*array)[sound.lattice.index(5, 4)] += 5e-9;  // of a total of 5
    CHECK(identity_residuals(broken).weight_sum == Approx(1e-9).epsilon(1e-5));
    CHECK_THROWS_AS(assert_identities(broken), std::logic_error);
  }
}

TEST_CASE("a corrupted horizontal force breaks the local wave equation by its amount") {
  const Pile sound = uniform_frictionless_pile(Lattice({.columns = 5, .layers = 6}));
  for (auto array : {&Pile::H_R, &Pile::H_L}) {
    for (int n = 1; n < 5; ++n) {
      Pile broken = sound;
      (broken.*array)[sound.lattice.index(n, 3)] += 1e-9;  // every w is 1
      CHECK(identity_residuals(broken).wave_equation == Approx(std::sqrt(3.0) * 1e-9).epsilon(1e-5));
      CHECK_THROWS_AS(assert_identities(broken), std::logic_error);
    }
  }
}

TEST_CASE("weight moved sideways keeps the sum and breaks the wave equation") {
  Pile pile = central_pile(Lattice({.columns = 8, .layers = 6}), 0.9, 2);
  pile.V_R[pile.lattice.index(3, 2)] += 1e-6;
  pile.V_R[pile.lattice.index(3, 3)] -= 1e-6;
  CHECK(identity_residuals(pile).weight_sum <= 1e-14);
  CHECK(identity_residuals(pile).wave_equation > 1e-7);
  CHECK_THROWS_AS(assert_identities(pile), std::logic_error);
}

TEST_CASE("a force that is not a number breaks the identities") {
  const Lattice lattice({.columns = 5, .layers = 6});
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Pile pile = uniform_frictionless_pile(lattice);
      (pile.*array)[lattice.index(3, 2)] = value;
      CHECK_THROWS_AS(assert_identities(pile), std::logic_error);
    }
  }
}

}  // namespace
}  // namespace granuscope
