#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "model/friction_cone.h"
#include "sampling/uniform_bits.h"

namespace granuscope {

struct GranusolveState;

/// What a climb from the bead at the cursor draws again where nothing is unsolved yet: the `height` + 1 beads at its
/// top, one more in each layer below, and the 2 `height` + 1 beads of the front layer around that bead, of which those
/// on one side are solved and the turn of the others has not come. No row of it meets the seam of the lattice.
struct LowClimb {
  static constexpr int lowest = 2, highest = 3;
  static constexpr int beads(int height, int row) { return height + 1 + row; }

  int height;
  int layer, bead;  ///< it set out from
  bool forward;     ///< that layer's order goes to the right
  /// Of each row, the top one first and the front one last: the index of its first bead into the arrays.
  std::array<std::size_t, highest + 1> at;
  std::size_t at_parents;  ///< of the first of the height + 2 parents of the top row
};

struct LowClimbDrawn {
  enum class Bead : std::uint8_t {
    open,
    no_pair,  ///< and it is known to have no solution as it is, nor by the pair rule
    drawn,
    mended  ///< by the pair rule
  };
  /// How many rows were drawn, from the top on; of the next one nothing, since some bead that is to be solved has no
  /// solution as it is.
  int rows = 0;
  Bead bead = Bead::open;  ///< the one at the cursor
  /// Of the front row, a bit for each bead from the left: its turn has not come, and it has no solution as it is.
  unsigned failing = 0;
};

/// Whether redraw() can be used on this machine: it needs vectors of eight numbers.
bool can_redraw_low_climbs();

/// Draws again what a climb has unsolved, as GranusolveSampler does bead by bead, and the same bytes: those above the
/// front with their next numbers, those of the front layer with their first; then the bead at the cursor, by the pair
/// rule if need be. Those whose turn has not come are drawn as if in bulk. What is counted, and the attempt and the
/// rule of a bead that was mended, are left to the sampler.
LowClimbDrawn redraw(const LowClimb& climb, const GranusolveState& state, const FrictionCone& cone,
                     const PhiloxKeys& keys, std::uint32_t sample);

}  // namespace granuscope
