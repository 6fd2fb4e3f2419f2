#pragma once
#include <utility>
#include <vector>

#include "analysis/transport.h"

namespace granuscope::made_up {

inline constexpr int blocks = 32;

/// Adds a quantity whose sums over each block's `samples` piles are samples * value(block, row, i).
template <typename Value>
void add_quantity(BlockSums& sums, const char* name, int width, Value value) {
  QuantitySums& q = sums.quantities[name];
  q.width = width;
  for (int b = 0; b < sums.blocks(); ++b) {
    for (int row = 0; row < static_cast<int>(sums.layers.size()); ++row) {
      for (int i = 0; i < width; ++i) {
        const double mean = value(b, row, i), count = static_cast<double>(sums.count[static_cast<std::size_t>(b)]);
        q.sum.push_back(count * mean);
        if (q.has_squares()) q.sum_of_squares.push_back(count * mean * mean);
      }
    }
  }
}

inline MeasuredEnsemble ensemble_of(double mu, LatticeSpec lattice, std::vector<int> layers) {
  MeasuredEnsemble ensemble;
  ensemble.spec.sampler.mu = mu;
  ensemble.spec.lattice = lattice;
  ensemble.record.sums.layers = std::move(layers);
  ensemble.record.sums.count.assign(blocks, 8);
  return ensemble;
}

}  // namespace granuscope::made_up
