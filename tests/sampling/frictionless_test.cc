// Source: without friction every half of a load runs straight down its lattice row (the paper's exact path: c = tan 30
// degrees, no width). The rows are followed here by x, not through the lattice's neighbours.
#include "sampling/simple_laws.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "model/audit.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

TEST_CASE("an overload splits into two halves that run straight down, exactly") {
  for (const Law law : {Law::granusolve, Law::rejection}) {
    for (const int columns : {4, 5, 40, 41}) {
      const Lattice lattice({.columns = columns, .layers = 60});
      SamplerSpec spec;
      spec.law = law;
      spec.mu = 0;
      const auto sampler = make_sampler(spec, lattice);
      Pile pile(lattice);
      std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
      load[static_cast<std::size_t>(lattice.middle())] = 2;
      REQUIRE_FALSE(sampler->draw(0, load, pile).has_value());
      for (int n = 0; n < lattice.layers(); ++n) {
        for (int i = 0; i < columns; ++i) {
          // After n layers the halves stand at x = +n/2 and x = -n/2, wrapped around the ring.
          const auto meets = [&](double position) {
            const double distance = lattice.x(n, i) - position;
            return std::abs(distance - columns * std::round(distance / columns)) < 0.25;
          };
          const std::size_t at = lattice.index(n, i);
          REQUIRE(pile.V_R[at] == (meets(0.5 * n) ? 1.0 : 0.5));
          REQUIRE(pile.V_L[at] == (meets(-0.5 * n) ? 1.0 : 0.5));
          REQUIRE(pile.H_R[at] == pile.V_R[at] * tan30);
          REQUIRE(pile.H_L[at] == -pile.V_L[at] * tan30);
        }
      }
      CHECK(pile.mu == 0);
      CHECK(pile.law == name_of(law));
      CHECK(pile.load == load);
      CHECK(audit(pile).max_balance_residual <= 1e-15);
      CHECK(audit(pile).max_cone_violation <= 1e-15);
      CHECK_NOTHROW(assert_identities(pile));
      CHECK(sampler->counts().uniforms == 0);
    }
  }
}

TEST_CASE("with next to no friction the sampled pile is the frictionless one up to the width of the cone") {
  // Over 10 layers the forces are sums of at most some 2^10 terms, each within mu of the contact's direction.
  constexpr double mu = 1e-9;
  const Lattice lattice({.columns = 12, .layers = 10});
  SamplerSpec spec;
  spec.mu = mu;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice), straight(lattice);
  std::vector<double> load(12, 1.0);
  load[6] = 2;
  REQUIRE_FALSE(sampler->draw(0, load, pile).has_value());
  fill_frictionless(load, straight);
  for (std::size_t at = 0; at < lattice.beads(); ++at) {
    REQUIRE(std::abs(pile.V_R[at] - straight.V_R[at]) < 1024 * mu);
    REQUIRE(std::abs(pile.H_L[at] - straight.H_L[at]) < 1024 * mu);
  }
  CHECK(audit(pile).max_cone_violation <= 1e-12);
}

}  // namespace
}  // namespace granuscope
