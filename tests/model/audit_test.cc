// Source of the expected numbers: algebra. A force changed by d breaks the balance of its bead by exactly d; the
// violation of a cone by a known force is written down beside each case.
#include "model/audit.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "central_pile.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::central_pile;
using test::uniform_frictionless_pile;

double largest_force(const Pile& pile, int layer) {
  double largest = 0;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    largest = std::max({largest, std::hypot(pile.V_R[at], pile.H_R[at]), std::hypot(pile.V_L[at], pile.H_L[at])});
  }
  return largest;
}

TEST_CASE("a pile in balance passes the audit") {
  for (const double mu : {0.1, 0.5, 1.0, 1.6}) {
    for (const int columns : {4, 5, 12}) {
      INFO("mu " << mu << ", columns " << columns);
      const AuditResult result = audit(central_pile(Lattice({.columns = columns, .layers = 6}), mu, 5));
      CHECK(result.max_balance_residual <= 1e-14);
      CHECK(result.max_balance_residual > 0);  // real forces round
      CHECK(result.max_cone_violation <= 1e-15);
    }
  }
}

TEST_CASE("a torque alone that does not balance is found") {
  const Lattice lattice({.columns = 5, .layers = 6});
  const Pile sound = central_pile(lattice, 0.8, 11);
  // Nothing hangs below the last layer: taking from one of a bead's contacts what the other gets turns the bead only.
  const std::size_t bead = lattice.index(5, 2);
  for (const double shift : {1e-9, -1e-9}) {
    Pile turned = sound;
    turned.V_R[bead] += shift * largest_force(sound, 5);
    turned.V_L[bead] -= shift * largest_force(sound, 5);
    const AuditResult result = audit(turned);
    CHECK(result.max_balance_residual == Approx(1e-9).epsilon(0.01));
    CHECK(result.balance_layer == 5);
  }
}

TEST_CASE("one force wrong by a billionth is found, in any array, layer and bead") {
  const Lattice lattice({.columns = 5, .layers = 6});
  const Pile sound = central_pile(lattice, 0.8, 11);
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (int n = 0; n < lattice.layers(); ++n) {
      for (int i = 0; i < lattice.columns(); ++i) {
        for (const double sign : {1.0, -1.0}) {
          INFO("layer " << n << ", bead " << i);
          Pile broken = sound;
          (broken.*array)[lattice.index(n, i)] += sign * 1e-9 * largest_force(sound, n);
          const AuditResult result = audit(broken);
          REQUIRE(result.max_balance_residual >= 0.999e-9);
          REQUIRE(result.max_balance_residual < 1e-8);
          REQUIRE((result.balance_layer == n || result.balance_layer == n + 1));
        }
      }
    }
  }
}

TEST_CASE("a load that is not the one carried is found") {
  Pile pile = central_pile(Lattice({.columns = 6, .layers = 3}), 0.8, 3);
  pile.load[4] *= 1 + 1e-9;
  const AuditResult result = audit(pile);
  CHECK(result.max_balance_residual > 1e-10);
  CHECK(result.balance_layer == 0);
}

TEST_CASE("a pile without friction has neither residual nor violation") {
  Pile pile = uniform_frictionless_pile(Lattice({.columns = 6, .layers = 5}));
  const AuditResult result = audit(pile);
  // |T| of a contact along its direction is one rounding of V/2.
  CHECK(result.max_balance_residual <= 2 * std::numeric_limits<double>::epsilon());
  CHECK(result.max_cone_violation <= 2 * std::numeric_limits<double>::epsilon());
}

TEST_CASE("a cone is violated by the known amount") {
  const Lattice lattice({.columns = 6, .layers = 5});
  const double N = 1 / std::sqrt(3.0);  // of every contact: V = 1/2 along 30 degrees
  const std::size_t at = lattice.index(3, 2);
  for (const double mu : {0.0, 0.1, 0.4}) {
    for (const double shift : {1e-6, 0.3}) {
      Pile pile = uniform_frictionless_pile(lattice);
      pile.mu = mu;
      // Tangent of the right contact: (V, H) = (-1/2, sqrt(3)/2), of the left one (1/2, sqrt(3)/2).
      const double T = mu * N + shift;
      SECTION("right, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_R[at] -= T / 2, pile.H_R[at] += T * std::sqrt(3.0) / 2;
      }
      SECTION("left, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_L[at] += T / 2, pile.H_L[at] += T * std::sqrt(3.0) / 2;
      }
      SECTION("left, other way, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_L[at] -= T / 2, pile.H_L[at] -= T * std::sqrt(3.0) / 2;
      }
      if (pile.V_R[at] == 0.5 && pile.V_L[at] == 0.5) continue;
      const AuditResult result = audit(pile);
      CHECK(result.max_cone_violation == Approx(shift / std::hypot(N, T)).epsilon(1e-9));
      CHECK(result.cone_layer == 3);
    }
  }
}

TEST_CASE("a contact that pulls is a violation even where |T| is small") {
  const Lattice lattice({.columns = 6, .layers = 5});
  Pile pile = uniform_frictionless_pile(lattice);
  pile.mu = 1.0;
  const std::size_t at = lattice.index(4, 0);
  pile.V_R[at] = -0.5, pile.H_R[at] = -0.5 / std::sqrt(3.0);
  // N = -1/sqrt 3, as large as any force: |T| - mu N = 1/sqrt 3, too.
  const AuditResult result = audit(pile);
  CHECK(result.max_cone_violation == Approx(1).epsilon(1e-14));
  CHECK(result.cone_layer == 4);
}

TEST_CASE("a force that is not a number is refused") {
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L, &Pile::load}) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Pile pile = uniform_frictionless_pile(Lattice({.columns = 4, .layers = 3}));
      (pile.*array).back() = value;
      CHECK_THROWS_AS(audit(pile), InputError);
    }
  }
  Pile pile = uniform_frictionless_pile(Lattice({.columns = 4, .layers = 3}));
  pile.mu = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(audit(pile), InputError);
}

TEST_CASE("residuals are relative to their own layer and do not depend on the unit of force") {
  Pile pile = central_pile(Lattice({.columns = 7, .layers = 6}), 0.9, 21);
  pile.H_R[pile.lattice.index(2, 3)] += 1e-7;
  const AuditResult result = audit(pile);
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L, &Pile::load}) {
    for (double& force : pile.*array) force = std::ldexp(force, 100);
  }
  const AuditResult scaled = audit(pile);
  CHECK(scaled.max_balance_residual == result.max_balance_residual);
  CHECK(scaled.max_cone_violation == result.max_cone_violation);
}

}  // namespace
}  // namespace granuscope
