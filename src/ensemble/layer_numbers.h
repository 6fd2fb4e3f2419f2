#pragma once
#include <vector>

#include "ensemble/block_slice.h"
#include "ensemble/estimator.h"
#include "model/pile.h"

namespace granuscope {

/// What every estimator sums of its piles, layer by layer: "thrust", sqrt(3) sum(H_R - H_L) / sum(w) over the contacts
/// leaving the layer, and "weight_variance", the mean over columns of (w - 1)^2.
class LayerNumbers {
 public:
  static std::vector<QuantityShape> quantities() { return {{"thrust", 1}, {"weight_variance", 1}}; }
  LayerNumbers(BlockSums& sums, int block)
      : layers_(sums.layers), thrust_(sums, "thrust", block), variance_(sums, "weight_variance", block) {}
  void add(const Pile& pile) const;
  /// Of two piles that make one sample: the means of their numbers.
  void add_mean(const Pile& one, const Pile& other) const;

 private:
  const std::vector<int>& layers_;
  BlockSlice thrust_, variance_;
};

}  // namespace granuscope
