#include "ensemble/layer_numbers.h"

#include <numeric>

namespace granuscope {
namespace {

struct Numbers {
  double thrust = 0, variance = 0;
};

Numbers numbers_of(const Pile& pile, double total_load, int layer) {
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  const std::size_t row = pile.lattice.index(layer, 0);
  Numbers numbers;
  for (std::size_t i = 0; i < columns; ++i) {
    const double w = pile.V_R[row + i] + pile.V_L[row + i];
    numbers.thrust += pile.H_R[row + i] - pile.H_L[row + i];
    numbers.variance += (w - 1) * (w - 1);
  }
  return {sqrt3 * numbers.thrust / total_load, numbers.variance / static_cast<double>(columns)};
}

double total_load_of(const Pile& pile) { return std::accumulate(pile.load.begin(), pile.load.end(), 0.0); }

}  // namespace

void LayerNumbers::add(const Pile& pile) const {
  const double load = total_load_of(pile);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Numbers numbers = numbers_of(pile, load, layers_[l]);
    thrust_.add(l, numbers.thrust);
    variance_.add(l, numbers.variance);
  }
}

void LayerNumbers::add_mean(const Pile& one, const Pile& other) const {
  const double load = total_load_of(one), other_load = total_load_of(other);
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Numbers a = numbers_of(one, load, layers_[l]), b = numbers_of(other, other_load, layers_[l]);
    thrust_.add(l, (a.thrust + b.thrust) / 2);
    variance_.add(l, (a.variance + b.variance) / 2);
  }
}

}  // namespace granuscope
