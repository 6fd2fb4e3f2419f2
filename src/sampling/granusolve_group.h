#pragma once
#include <hwy/aligned_allocator.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "sampling/granusolve.h"
#include "sampling/group_kernels.h"

namespace granuscope {

/// Eight piles of the law granusolve side by side, one to a vector lane, in memory that interleaves them. They share
/// the order in which the beads of a layer are solved (RandomKey::layer_order), so that a layer is drawn in bulk and
/// its failing beads are mended by the pair rule in all piles at once (group_kernels.h). What that cannot settle (arcs,
/// rings, climbs, rounding) is done for one pile by a GranusolveSampler that works on the same memory. The piles are
/// those of GranusolveSampler::draw, bit for bit.
class GranusolveGroup {
 public:
  GranusolveGroup(const SamplerSpec& spec, const Lattice& lattice);

  /// Whether groups of this size should be drawn side by side; the largest piles need too much memory for it.
  static bool fits(const Lattice& lattice);

  /// At most eight piles that share the order of their layers: what draw() of this group, or of two at once, is to
  /// draw.
  void prepare(std::uint64_t first_sample, std::span<const std::span<const double>> loads,
               std::span<std::optional<SamplingFailure>> failures);

  /// Draws the piles last prepared.
  void draw();
  /// Draws those of two groups, whose mends are done two at a time.
  static void draw(GranusolveGroup& a, GranusolveGroup& b);

  PileGroup piles() const;
  /// What was done since the last call.
  SamplerCounts take_counts();

 private:
  template <typename T>
  using Array = hwy::AlignedFreeUniquePtr<T[]>;

  GroupRow row(int layer) const;
  void draw_layer_in_bulk(int layer);
  void begin_layer(int layer);
  void end_layer();
  bool find_unsolved();
  GroupBead surroundings() const;
  void mend_here();
  void settle(unsigned lanes);
  void give_up(std::size_t lane);
  void hand_over_counts(std::size_t lane);
  void count_piles();

  SamplerSpec spec_;
  Lattice lattice_;
  FrictionCone cone_;
  std::array<std::unique_ptr<GranusolveSampler>, group_lanes> solvers_;
  std::span<const std::span<const double>> loads_;  ///< of the piles being drawn
  std::span<std::optional<SamplingFailure>> failures_;
  unsigned running_ = 0;                     ///< piles that have not failed, a bit for each
  int position_ = 0, bead_ = 0;              ///< where the layer's order has come to
  unsigned open_ = 0;                        ///< piles that have no solution there
  Array<double> V_R_, V_L_, H_, H_R_, H_L_;  ///< [layers, columns, 8]
  Array<std::uint32_t> attempts_;            ///< the same
  Array<std::uint8_t> unsolved_, rule_;      ///< the same
  Array<double> first_uniform_, slack_;      ///< [columns, 8]
  Array<double> half_load_, no_force_;       ///< [columns, 8]
  Array<std::uint64_t> failing_;             ///< [columns] bytes
  GroupFront front_;
};

}  // namespace granuscope
