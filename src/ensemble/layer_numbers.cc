#include "ensemble/layer_numbers.h"

#include <array>
#include <numeric>
#include <type_traits>

namespace granuscope {

void LayerNumbers::add(const Pile& pile) const {
  const std::span<const double> load = pile.load;
  const std::optional<SamplingFailure> no_failure;
  add(group_of(pile, load), {&no_failure, 1});
}

void LayerNumbers::add(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) const {
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  std::array<double, group_lanes> total_load{};
  for (std::size_t k = 0; k < group.piles; ++k) {
    total_load[k] = std::accumulate(group.loads[k].begin(), group.loads[k].end(), 0.0);
  }
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = group.row(layers_[l]);
    std::array<double, group_lanes> thrust{}, variance{};
    // The piles of a group lie side by side, so that this inner loop has a fixed length where there are several.
    const auto add_beads = [&](auto stride) {
      for (std::size_t at = row; at < row + columns * stride; at += stride) {
        for (std::size_t k = 0; k < stride; ++k) {
          const double w = group.V_R[at + k] + group.V_L[at + k];
          thrust[k] += group.H_R[at + k] - group.H_L[at + k];
          variance[k] += (w - 1) * (w - 1);
        }
      }
    };
    if (group.stride == 1) {
      add_beads(std::integral_constant<std::size_t, 1>());
    } else {
      add_beads(std::integral_constant<std::size_t, group_lanes>());
    }
    for (std::size_t k = 0; k < group.piles; ++k) {
      if (failures[k]) continue;
      thrust_.add(l, sqrt3 * thrust[k] / total_load[k]);
      variance_.add(l, variance[k] / static_cast<double>(columns));
    }
  }
}

}  // namespace granuscope
