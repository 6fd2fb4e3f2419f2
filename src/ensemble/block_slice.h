#pragma once
#include <cstddef>
#include <string>

#include "storage/block_sums.h"

namespace granuscope {

/// Where the sums of one quantity in one block of the ensemble stand: entries [layers, width].
class BlockSlice {
 public:
  BlockSlice() = default;
  BlockSlice(BlockSums& sums, const std::string& quantity, int block) {
    QuantitySums& q = sums.quantities.at(quantity);
    width_ = static_cast<std::size_t>(q.width);
    const std::size_t offset = static_cast<std::size_t>(block - sums.first_block) * sums.layers.size() * width_;
    sum_ = q.sum.data() + offset;
    if (q.has_squares()) sum_of_squares_ = q.sum_of_squares.data() + offset;
  }

  /// Adds one sample's value at recorded layer number `row`: of a number per layer,
  void add(std::size_t row, double value) const {
    sum_[row] += value;
    sum_of_squares_[row] += value * value;
  }
  /// or of a profile.
  void add(std::size_t row, std::size_t column, double value) const { sum_[row * width_ + column] += value; }

 private:
  double* sum_ = nullptr;
  double* sum_of_squares_ = nullptr;
  std::size_t width_ = 0;
};

}  // namespace granuscope
