// Source: the rule itself. What misses its band by up to 64 units in the last place of the forces summed is put onto
// the band's end; what misses it by more is a failure.
#include "sampling/random_key.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "model/lattice.h"

namespace granuscope {
namespace {

TEST_CASE("a bead may miss its band by 64 units in the last place and no more, and is put onto the band's end") {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> uniform(0.1, 2);
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  for (const double mu : {0.1, 0.3, 0.8, 1.3, 1.7}) {
    const FrictionCone cone(mu);
    for (int k = 0; k < 1000; ++k) {
      const double V_UL = uniform(engine), V_UR = uniform(engine);
      const Interval band = solvable_band(cone, V_UL, V_UR);
      for (const bool above : {false, true}) {
        const double end = above ? band.high : band.low;
        const double ulp = epsilon * (V_UL + V_UR + std::abs(end));
        for (const auto& [ulps, forgiven] : {std::pair{1.0, true}, {62.0, true}, {66.0, false}, {1000.0, false}}) {
          const Incoming in{V_UL, V_UR, above ? end + ulps * ulp : end - ulps * ulp};
          CAPTURE(mu, V_UL, V_UR, above, ulps);
          CHECK(misses_by_rounding(cone, in) == forgiven);
          CHECK(nearest_solvable(cone, in) == end);
        }
      }
      const double inside = band.low + (band.high - band.low) / 3;
      CHECK(nearest_solvable(cone, {V_UL, V_UR, inside}) == inside);
    }
  }
}

}  // namespace
}  // namespace granuscope
