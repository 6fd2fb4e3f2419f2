#pragma once
#include <cstdint>
#include <functional>
#include <span>

#include "model/pile.h"

namespace granuscope {
/// A bead as other programs get it. Lengths in bead diameters, x from the overloaded bead to the right, z down from the
/// surface; forces in loads of one top bead.
struct NetworkBead {
  std::int64_t number = 0;  ///< layer * columns + column, its place in the arrays of the pile file
  int layer = 0, column = 0;
  double x = 0, z = 0;
  double weight = 0;    ///< V_R + V_L
  double residual = 0;  ///< balance_residual
};

inline constexpr double bead_radius = 0.5;

/// A contact of a bead with one below it. Those of the lowest layer push on a floor that is not in the pile.
struct NetworkContact {
  static constexpr std::int64_t floor = -1;

  std::int64_t upper = 0;
  std::int64_t lower = floor;
  double x = 0, z = 0;                ///< centre of the upper bead
  double branch_x = 0, branch_z = 0;  ///< from there to the centre of the lower bead, or of its image across the seam
  bool across_seam = false;           ///< the lower bead itself lies at the other end of the ring
  double N = 0, T = 0;                ///< T > 0 turns the force from the branch towards +x
  double share = 0;                   ///< |T|/(mu N), not a number where mu N is 0
  double H = 0, V = 0;                ///< what the upper bead pushes onto the lower one, to the right and down
};

inline std::int64_t contacts_on_floor(const Lattice& lattice) { return 2 * std::int64_t{lattice.columns()}; }
/// One in each layer but the lowest, whose contacts are all on the floor.
inline std::int64_t contacts_across_seam(const Lattice& lattice) { return std::int64_t{lattice.layers()} - 1; }
inline std::int64_t all_contacts(const Lattice& lattice) { return 2 * static_cast<std::int64_t>(lattice.beads()); }

/// Hands the beads over, some whole layers at a time from the top, and with them the contacts below each: to the lower
/// left, then to the lower right. The range of `pile` is all of it. Throws InputError where it cannot be read further,
/// Interrupted on request.
void for_each_piece(PileLayers& pile,
                    const std::function<void(std::span<const NetworkBead>, std::span<const NetworkContact>)>& visit);

}  // namespace granuscope
