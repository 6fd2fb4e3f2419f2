#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <stdexcept>

#include "model/pile.h"

namespace granuscope::test {

/// A pile for tests of what every pile obeys. Solved here from Coulomb's cone by angles, without the program's own
/// equilibrium: each bead takes a random point near the one where both contacts stand closest to their directions; a
/// pile that gets stuck is thrown away and the next one keeps nearer to it.
inline Pile central_pile(Lattice lattice, double mu, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Pile pile(lattice);
  pile.mu = mu;
  pile.law = "central";
  pile.seed = seed;
  const double thirty_degrees = std::atan(1 / std::sqrt(3.0));
  const double flat = std::tan(thirty_degrees - std::atan(mu)), steep = std::tan(thirty_degrees + std::atan(mu));
  for (double& load : pile.load) load = 0.9 + 0.2 * unit(engine);
  const auto fill = [&](double spread) {
    for (int n = 0; n < lattice.layers(); ++n) {
      for (int i = 0; i < lattice.columns(); ++i) {
        double V_UL = pile.load[static_cast<std::size_t>(i)] / 2, V_UR = V_UL, H = 0;
        if (n > 0) {
          const std::size_t a = lattice.index(n - 1, lattice.upper_left(n, i));
          const std::size_t b = lattice.index(n - 1, lattice.upper_right(n, i));
          V_UL = pile.V_R[a], V_UR = pile.V_L[b], H = pile.H_R[a] + pile.H_L[b];
        }
        const double V_R = V_UR + std::sqrt(3.0) * H, V_L = V_UL - std::sqrt(3.0) * H;
        const double low = std::max(flat * V_R, flat * V_L + H), high = std::min(steep * V_R, steep * V_L + H);
        const double along = ((V_R + V_L) / std::sqrt(3.0) + H) / 2;
        const std::size_t at = lattice.index(n, i);
        pile.V_R[at] = V_R, pile.V_L[at] = V_L;
        pile.H_R[at] = along + spread * (unit(engine) - 0.5);
        if (pile.H_R[at] < low || pile.H_R[at] > high) return false;
        pile.H_L[at] = H - pile.H_R[at];
      }
    }
    return true;
  };
  for (double spread = mu; spread > 1e-3; spread *= 0.99) {
    if (fill(spread)) return pile;
  }
  throw std::runtime_error("no central pile found");
}

/// The pile without friction under a uniform load: every contact carries V = 1/2 along its direction.
inline Pile uniform_frictionless_pile(Lattice lattice) {
  Pile pile(lattice);
  std::fill(pile.V_R.begin(), pile.V_R.end(), 0.5);
  std::fill(pile.V_L.begin(), pile.V_L.end(), 0.5);
  std::fill(pile.H_R.begin(), pile.H_R.end(), 0.5 / std::sqrt(3.0));
  std::fill(pile.H_L.begin(), pile.H_L.end(), -0.5 / std::sqrt(3.0));
  return pile;
}

}  // namespace granuscope::test
