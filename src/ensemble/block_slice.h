#pragma once
#include <cstddef>
#include <string>

#include "storage/block_sums.h"

namespace granuscope {

/// Where the sums of one quantity in one block stand: entries [layers, width].
class BlockSlice {
 public:
  BlockSlice() = default;
  BlockSlice(BlockSums& sums, const std::string& quantity, int block) {
    QuantitySums& q = sums.quantities.at(quantity);
    width_ = static_cast<std::size_t>(q.width);
    const std::size_t offset = static_cast<std::size_t>(block) * sums.layers.size() * width_;
    sum_ = q.sum.data() + offset;
    sum_of_squares_ = q.sum_of_squares.data() + offset;
  }

  /// Adds one sample's value at recorded layer number `row`.
  void add(std::size_t row, double value) const { add(row, 0, value); }
  void add(std::size_t row, std::size_t column, double value) const {
    const std::size_t at = row * width_ + column;
    sum_[at] += value;
    sum_of_squares_[at] += value * value;
  }

 private:
  double* sum_ = nullptr;
  double* sum_of_squares_ = nullptr;
  std::size_t width_ = 0;
};

}  // namespace granuscope
