#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "model/friction_cone.h"
#include "sampling/pile_group.h"
#include "sampling/uniform_bits.h"

namespace granuscope {

using LaneWords = std::array<std::uint64_t, group_lanes>;

/// One row of the piles of a group. Rows are aligned to 64 bytes.
struct GroupRow {
  double *V_R, *V_L, *H, *H_R, *H_L;
};

/// The layer that is being solved, the one above it, and what its mends read and count.
struct GroupFront {
  alignas(64) LaneWords sample{};
  // Counted for each pile: beads met, and those of them that were mended.
  alignas(64) LaneWords met{}, pairs{};
  GroupRow above{}, here{};
  const double* first_uniform = nullptr;
  std::uint32_t* attempts = nullptr;  ///< after the first, of this layer
  std::uint8_t* rule = nullptr;       ///< of this layer; set to mended_rule
  std::uint8_t* failing = nullptr;    ///< a byte for each bead, a bit for each pile
  PhiloxKeys keys;
  int layer = 0;
  bool forward = true;  ///< the layer's direction: the neighbour behind a bead is its left one
  std::uint8_t mended_rule = 0;
};

/// One bead that fails in some of the piles, its neighbours of which the one behind it is solved and the one ahead is
/// not, its parents A and B, and the parent of the neighbour behind that is not among them.
struct GroupBead {
  std::size_t A, B, outer, behind, bead, ahead;
};

/// First uniforms of a layer (layer_kernels.h) for eight samples side by side. `uniforms` has room for beads + 1 beads.
void fill_group_uniforms(const PhiloxKeys& keys, const LaneWords& sample, int layer, double* uniforms,
                         std::size_t beads);

/// Solves the bead as it is with its first number, in those of the piles of `lanes` (a bit for each) in which it has a
/// solution; returns the others. This and mend_beads give the bytes of GranusolveSampler, on every instruction set.
unsigned draw_as_is(const FrictionCone& cone, GroupFront& front, const GroupBead& bead, unsigned lanes);

/// Solves a bead without solution in the piles of `lanes` by the pair rule, all at once. Returns the piles in which it
/// needs another rule or lies within rounding of its band; nothing is changed there.
unsigned mend_beads(const FrictionCone& cone, GroupFront& front, const GroupBead& bead, unsigned lanes);

/// The same in two groups at once. A mend is a long chain of operations that wait for each other; two chains that have
/// nothing to do with each other take hardly longer than one.
std::array<unsigned, 2> mend_beads(const FrictionCone& cone, const std::array<GroupFront*, 2>& fronts,
                                   const std::array<GroupBead, 2>& beads, const std::array<unsigned, 2>& lanes);

/// How many beads of each of eight piles were solved by each rule (GranusolveSampler::Rule); those at their first
/// number, rule 0, may be left out.
inline constexpr std::uint8_t last_rule = 4;
using RuleCounts = std::array<std::array<std::uint64_t, last_rule + 1>, group_lanes>;

/// Adds a row of eight piles side by side to `counts`. A bead that has climbed counts for the last rule, climbing.
void count_rules(const std::uint8_t* rule, const std::uint8_t* climbs, std::size_t beads, RuleCounts& counts);

}  // namespace granuscope
