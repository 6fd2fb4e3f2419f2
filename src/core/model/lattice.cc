#include "model/lattice.h"

#include <fmt/format.h>

#include "support/error.h"

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

std::vector<Key> keys_of(LatticeSpec& spec) {
  return {
      make_key("lattice", "columns", "beads", "beads per layer, periodic in x; even or odd", spec.columns,
               KeyRange{}.within(fewest_columns, most_columns)),
      make_key("lattice", "layers", "layers",
               "layers computed; the lowest 20 of beads (5 of diluted ones) follow another law, since no failure below "
               "reaches up into them, and are not used",
               spec.layers, KeyRange{}.within(4, most_layers)),
  };
}

Lattice::Lattice(LatticeSpec spec) : spec_(spec) { refuse(find_problem(spec)); }

double Lattice::x(int layer, int bead) const {
  const double x = bead - middle() + 0.5 * (layer % 2);
  // For an odd number of columns the last bead of an odd layer lies half a bead past the seam.
  return x >= 0.5 * columns() ? x - columns() : x;
}

FrictionCone::FrictionCone(double mu) : mu_(mu) {
  if (!(mu >= 0 && mu < sqrt3)) {
    throw InputError(fmt::format(
        "friction coefficient {} is out of range: the law is defined for 0 <= mu < sqrt(3) = 1.7320508, where the cone "
        "of admissible forces stays below the horizontal",
        mu));
  }
  t_minus_ = (tan30 - mu) / (1 + mu * tan30);
  t_plus_ = (tan30 + mu) / (1 - mu * tan30);
  k_ = sqrt3 * (t_minus_ + t_plus_) - 1;
  t_minus_over_k_ = t_minus_ / k_;
  t_plus_over_k_ = t_plus_ / k_;
}

}  // namespace granuscope
