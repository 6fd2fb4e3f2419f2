#pragma once
#include "model/equilibrium.h"
#include "model/pile.h"

namespace granuscope {

/// What enters a bead of a pile from its load or from the two beads above it.
inline Incoming incoming(const Pile& pile, int layer, int bead) {
  if (layer == 0) {
    const double half = pile.load[static_cast<std::size_t>(bead)] / 2;
    return {half, half, 0.0};
  }
  const Lattice& lattice = pile.lattice;
  const std::size_t a = lattice.index(layer - 1, lattice.upper_left(layer, bead));
  const std::size_t b = lattice.index(layer - 1, lattice.upper_right(layer, bead));
  return {pile.V_R[a], pile.V_L[b], pile.H_R[a] + pile.H_L[b]};
}

}  // namespace granuscope
