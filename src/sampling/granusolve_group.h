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

  /// As Sampler::draw_group for at most eight piles that share the order of their layers; what was done is added to
  /// `counts`.
  void draw(std::uint64_t first_sample, std::span<const std::span<const double>> loads, std::span<Pile> piles,
            std::span<std::optional<SamplingFailure>> failures, SamplerCounts& counts);

 private:
  template <typename T>
  using Array = hwy::AlignedFreeUniquePtr<T[]>;

  GroupRow row(int layer) const;
  void begin(std::uint64_t first_sample, std::span<const std::span<const double>> loads, std::span<Pile> piles);
  void draw_layer_in_bulk(int layer);
  void solve_layer(int layer, std::span<std::optional<SamplingFailure>> failures);
  void hand_over_counts(std::size_t lane);
  void count_piles();
  void unpack(std::span<Pile> piles) const;

  SamplerSpec spec_;
  Lattice lattice_;
  FrictionCone cone_;
  std::array<std::unique_ptr<GranusolveSampler>, group_lanes> solvers_;
  unsigned running_ = 0;                     ///< piles that have not failed, a bit for each
  Array<double> V_R_, V_L_, H_, H_R_, H_L_;  ///< [layers, columns, 8]
  Array<std::uint32_t> attempts_;            ///< the same
  Array<std::uint8_t> unsolved_, rule_;      ///< the same
  Array<double> first_uniform_, slack_;      ///< [columns, 8]
  Array<double> half_load_, no_force_;       ///< [columns, 8]
  Array<std::uint64_t> failing_;             ///< [columns] bytes
  GroupFront front_;
};

}  // namespace granuscope
