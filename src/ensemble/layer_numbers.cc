#include "ensemble/layer_numbers.h"

#include <numeric>
#include <type_traits>

namespace granuscope {

LayerNumbers::Numbers LayerNumbers::numbers_of(const PileGroup& group, int layer) {
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  const std::size_t row = group.row(layer);
  Numbers numbers;
  // The piles of a group lie side by side, so that the inner loop has a fixed length where there are several.
  const auto add_beads = [&](auto stride) {
    for (std::size_t at = row; at < row + columns * stride; at += stride) {
      for (std::size_t k = 0; k < stride; ++k) {
        const double w = group.V_R[at + k] + group.V_L[at + k];
        numbers.thrust[k] += group.H_R[at + k] - group.H_L[at + k];
        numbers.variance[k] += (w - 1) * (w - 1);
      }
    }
  };
  if (group.stride == 1) {
    add_beads(std::integral_constant<std::size_t, 1>());
  } else {
    add_beads(std::integral_constant<std::size_t, group_lanes>());
  }
  for (std::size_t k = 0; k < group.piles; ++k) {
    const double total_load = std::accumulate(group.loads[k].begin(), group.loads[k].end(), 0.0);
    numbers.thrust[k] = sqrt3 * numbers.thrust[k] / total_load;
    numbers.variance[k] /= static_cast<double>(columns);
  }
  return numbers;
}

void LayerNumbers::add(std::size_t l, double thrust, double variance) const {
  thrust_.add(l, thrust);
  variance_.add(l, variance);
}

void LayerNumbers::add(const Pile& pile) const {
  const std::span<const double> load = pile.load;
  const std::optional<SamplingFailure> no_failure;
  add(group_of(pile, load), {&no_failure, 1});
}

void LayerNumbers::add(const PileGroup& group, Failures failures) const {
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Numbers numbers = numbers_of(group, layers_[l]);
    for (std::size_t k = 0; k < group.piles; ++k) {
      if (!failures[k]) add(l, numbers.thrust[k], numbers.variance[k]);
    }
  }
}

void LayerNumbers::add_mean(const PileGroup& one, const PileGroup& other, Failures failures) const {
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Numbers a = numbers_of(one, layers_[l]), b = numbers_of(other, layers_[l]);
    for (std::size_t k = 0; k < one.piles; ++k) {
      if (!failures[k]) add(l, (a.thrust[k] + b.thrust[k]) / 2, (a.variance[k] + b.variance[k]) / 2);
    }
  }
}

}  // namespace granuscope
