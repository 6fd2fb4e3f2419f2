#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "model/lattice.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"

namespace granuscope {

using LaneWords = std::array<std::uint64_t, group_lanes>;

/// One row of the piles of a group. Rows are aligned to 64 bytes.
struct GroupRow {
  double *V_R, *V_L, *H, *H_R;  ///< H_L is H - H_R
};

/// Bytes around a row of bits that are read with it.
inline constexpr std::size_t row_padding = 8;

/// The layer that is being solved, the one above it, and what its repairs read and count.
struct GroupFront {
  alignas(64) LaneWords sample{};
  alignas(64) LaneWords pairs{};  ///< beads repaired, counted for each pile
  GroupRow above{}, here{};
  std::uint32_t* attempts = nullptr;  ///< after the first, of this layer
  std::uint8_t* rule = nullptr;       ///< of this layer; set to repair_rule
  double* first_uniform = nullptr;    ///< of this layer
  // A byte for each bead, a bit for each pile; row_padding bytes stand before and after them.
  std::uint8_t* failing = nullptr;  ///< what the bead was drawn with at first does not hold
  std::uint8_t* changed = nullptr;  ///< because its parents have changed since
  PhiloxKeys keys;
  PhaseTimes* times = nullptr;  ///< who asks how long each phase takes, if anybody
  int layer = 0, columns = 0;
  int position = 0, bead = 0;    ///< where the layer's order has come to; at position `columns` the layer is done
  unsigned running = 0;          ///< piles that have not failed, a bit for each
  unsigned to_repair = 0;        ///< those that have no solution at this bead as it is
  unsigned to_solve_singly = 0;  ///< those that the pair rule cannot help there
  unsigned no_pair = 0;          ///< those of them that are known to have no solution as they are, nor by it
  double half_weight = 0;        ///< of each bead by itself
  bool forward = true;           ///< the layer's direction: the neighbour behind a bead is its left one
  std::uint8_t repair_rule = 0;

  /// The top layer and the ends of the order are left to the solvers of single piles.
  bool at_an_end() const { return layer == 0 || position == 0 || position == columns - 1; }
  /// At most to the first bead beyond the row's end.
  void step(int beads = 1) {
    position += beads;
    bead += forward ? beads : -beads;
    if (bead == columns) bead = 0;
    if (bead < 0) bead = columns - 1;
  }
};

/// One bead that fails in some of the piles, its neighbours of which the one behind it is solved and the one ahead is
/// not, its parents A and B, and the parent of the neighbour behind that is not among them.
struct GroupBead {
  std::size_t A, B, outer, behind, bead, ahead;
};

/// What enters the top layer: half the load of each bead, [columns, 8], and the line of all.
struct TopLoad {
  const double* half;
  LoadLine line;
};

/// Draws the front layer in all piles, each bead with its first number (layer_kernels.h) whether it has a solution or
/// not, and notes which have none. first_uniform has room for one bead more.
void draw_layer(const FrictionCone& cone, const TopLoad& top, GroupFront& front);

/// Goes on along the layer and solves each bead that fails in some piles: as it is with its first number where it has a
/// solution, else by the pair rule, in all piles at once. Returns at the end of the layer, or at a bead that some piles
/// must solve by another rule (to_solve_singly), in which nothing is changed. Gives the bytes of GranusolveSampler, on
/// every instruction set.
void repair_along(const FrictionCone& cone, GroupFront& front);

/// The same in two groups at once, until one of them has a bead to solve singly or is at the end of its layer; what
/// the other has found keeps for the next call. A repair is a long chain of operations that wait for each other; two
/// chains that have nothing to do with each other take hardly longer than one.
void repair_along(const FrictionCone& cone, GroupFront& a, GroupFront& b);

/// How many beads of each of eight piles were solved by each rule (GranusolveRule); those at their first
/// number, rule 0, may be left out.
inline constexpr std::uint8_t last_rule = 4;
using RuleCounts = std::array<std::array<std::uint64_t, last_rule + 1>, group_lanes>;

/// Adds a row of eight piles side by side to `counts`. A bead that has backtracked counts for the last rule,
/// backtracking.
void count_rules(const std::uint8_t* rule, const std::uint8_t* backtracks, std::size_t beads, RuleCounts& counts);

}  // namespace granuscope
