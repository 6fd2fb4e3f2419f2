#include "model/lattice.h"

namespace granuscope {

Problem find_problem(const LatticeSpec& spec) {
  if (spec.columns < fewest_columns) {
    return problem(
        "columns",
        "a lattice of {} columns is too narrow: around a ring of fewer than {} beads a bead is its own neighbour; "
        "use {} columns or more",
        spec.columns, fewest_columns, fewest_columns);
  }
  if (spec.layers < fewest_layers) {
    return problem("layers", "a lattice of {} layers holds no bead; use {} layer or more", spec.layers, fewest_layers);
  }
  return {};
}

Lattice::Lattice(LatticeSpec spec) : spec_(spec) { refuse(find_problem(spec)); }

double Lattice::x(int layer, int bead) const {
  const double x = bead - middle() + 0.5 * (layer % 2);
  // For an odd number of columns the last bead of an odd layer lies half a bead past the seam.
  return x >= 0.5 * columns() ? x - columns() : x;
}

}  // namespace granuscope
