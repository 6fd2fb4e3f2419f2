#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/lattice.h"

namespace granuscope {

/// The line along which all loads of a pile act.
struct LoadLine {
  double slope = 0;   ///< horizontal force over vertical force, to the right > 0
  double offset = 0;  ///< where it passes the bead's centre, to the right > 0, bead radii: the load's torque
  bool operator==(const LoadLine&) const = default;
};

/// One complete contact-force network. Forces are those a bead pushes onto the bead below it, V down > 0, H right > 0,
/// in units of the load on one ordinary top bead. All four arrays have shape [layers, columns], row-major, and hold the
/// contacts leaving bead (n, i): _R towards its lower-right, _L towards its lower-left neighbour.
struct Pile {
  explicit Pile(Lattice lattice_)
      : lattice(lattice_),
        V_R(lattice_.beads()),
        V_L(lattice_.beads()),
        H_R(lattice_.beads()),
        H_L(lattice_.beads()),
        load(static_cast<std::size_t>(lattice_.columns()), 1.0) {}

  Lattice lattice;
  std::vector<double> V_R, V_L, H_R, H_L;
  std::vector<double> load;  ///< vertical force on each top bead, shape [columns]
  LoadLine load_line;
  double bead_weight = 0;  ///< of each bead by itself, a vertical force through its centre; no part of `load`

  double mu = 0;           ///< friction coefficient
  std::string law;         ///< name of the law that drew it ("granusolve", "rejection", ...)
  std::uint64_t seed = 0;  ///< with `sample` the key of every random number in it
  std::uint64_t sample = 0;
};

}  // namespace granuscope
