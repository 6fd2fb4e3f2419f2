#include "model/lattice.h"

#include <fmt/format.h>

#include "support/error.h"

namespace granuscope {

Lattice::Lattice(LatticeSpec spec) : spec_(spec) {
  if (spec.columns < 4) {
    throw InputError(fmt::format(
        "a lattice of {} columns is too narrow: around a ring of fewer than 4 beads a bead is its own neighbour; "
        "use 4 columns or more",
        spec.columns));
  }
  if (spec.layers < 1) {
    throw InputError(fmt::format("a lattice of {} layers holds no bead; use 1 layer or more", spec.layers));
  }
}

double Lattice::x(int layer, int bead) const {
  const double x = bead - middle() + 0.5 * (layer % 2);
  // For an odd number of columns the last bead of an odd layer lies half a bead past the seam.
  return x >= 0.5 * columns() ? x - columns() : x;
}

}  // namespace granuscope
