#include "ensemble/layer_numbers.h"

#include <numeric>

namespace granuscope {

void LayerNumbers::add(const Pile& pile) const {
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  const double total_load = std::accumulate(pile.load.begin(), pile.load.end(), 0.0);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = pile.lattice.index(layers_[l], 0);
    double thrust = 0, variance = 0;
    for (std::size_t i = 0; i < columns; ++i) {
      const double w = pile.V_R[row + i] + pile.V_L[row + i];
      thrust += pile.H_R[row + i] - pile.H_L[row + i];
      variance += (w - 1) * (w - 1);
    }
    thrust_.add(l, sqrt3 * thrust / total_load);
    variance_.add(l, variance / static_cast<double>(columns));
  }
}

}  // namespace granuscope
