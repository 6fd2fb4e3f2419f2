#pragma once
#include <optional>
#include <span>
#include <vector>

#include "ensemble/block_slice.h"
#include "ensemble/estimator.h"
#include "model/pile.h"
#include "sampling/pile_group.h"

namespace granuscope {

/// What every estimator sums of its piles, layer by layer: "thrust", sqrt(3) sum(H_R - H_L) / sum(w) over the contacts
/// leaving the layer, and "weight_variance", the mean over columns of (w/<w> - 1)^2, <w> known exactly,
/// and what the model counts besides (extra_names).
class LayerObservables {
 public:
  using Failures = std::span<const std::optional<SamplingFailure>>;

  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  LayerObservables(const EnsembleSpec& spec, BlockSums& sums, int block);
  void add(const Pile& pile) const;
  /// Those of the piles that did not fail; `failures` has an entry per pile.
  void add(const PileGroup& group, Failures failures) const;
  /// Of two groups whose piles make one sample each: the means of their observables.
  void add_mean(const PileGroup& one, const PileGroup& other, Failures failures) const;
  /// At recorded layer number l: their means over the layers that lie `offset` plus that layer below the bases.
  void add_means(const PileGroup& group, Failures failures, const std::vector<int>& bases, int offset) const;

 private:
  /// The moments of a layer, divided by what makes them the observables.
  static LayerMoments of_layer(const PileGroup& group, int layer);
  void add(std::size_t l, double thrust, double variance) const;
  /// Of both groups, the means; they may be the same one.
  void add_extras(std::size_t l, const PileGroup& one, const PileGroup& other, Failures failures) const;

  const std::vector<int>& layers_;
  BlockSlice thrust_, variance_;
  std::vector<BlockSlice> extras_;
};

}  // namespace granuscope
