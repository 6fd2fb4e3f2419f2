#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "model/friction_cone.h"
#include "sampling/uniform_bits.h"

namespace granuscope {

/// Piles that are solved side by side, one to a vector lane: bead i of pile k is entry 8 i + k of a row.
inline constexpr std::size_t group_lanes = 8;
using LaneWords = std::array<std::uint64_t, group_lanes>;

/// One row of the piles of a group. Rows are aligned to 64 bytes.
struct GroupRow {
  double *V_R, *V_L, *H, *H_R, *H_L;
};

/// The layer that is being solved, the one above it, and what its mends read and count.
struct GroupFront {
  alignas(64) LaneWords sample{};
  // Counted for each pile: beads met, those mended, and the solved neighbours that drew again with them.
  alignas(64) LaneWords met{}, pairs{}, renewed{};
  GroupRow above{}, here{};
  const double* first_uniform = nullptr;
  std::uint32_t* attempts = nullptr;  ///< after the first, of this layer
  std::uint8_t* rule = nullptr;       ///< of this layer; set to mended_rule
  std::uint8_t* failing = nullptr;    ///< a byte for each bead, a bit for each pile
  PhiloxKeys keys;
  int layer = 0;
  std::uint8_t mended_rule = 0;
};

/// One bead that fails in some of the piles, and its surroundings: parents A and B, their outer neighbours P and Q.
struct GroupBead {
  std::size_t P, A, B, Q, left, bead, right;
  bool left_solved, right_solved;
};

/// First uniforms of a layer (layer_kernels.h) for eight samples side by side. `uniforms` has room for beads + 1 beads.
void fill_group_uniforms(const PhiloxKeys& keys, const LaneWords& sample, int layer, double* uniforms,
                         std::size_t beads);

/// Solves the bead in the piles of `lanes` (a bit for each) by the rules of granusolve.cc, all at once: as it is, else
/// by the pair rule. Returns the piles in which it needs another rule or lies within rounding of its band; nothing is
/// changed there. The same bytes as GranusolveSampler's, on every instruction set.
unsigned mend_beads(const FrictionCone& cone, GroupFront& front, const GroupBead& bead, unsigned lanes);

}  // namespace granuscope
