#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "model/lattice.h"

namespace granuscope {

/// Sums of one measured quantity over the samples of each block, shape [blocks, layers, width], row-major; width is
/// the number of columns for a profile and 1 for a number per layer. Only the latter have squares: they tell how far
/// the samples depend on each other, and of profiles nobody asks that.
struct QuantitySums {
  int width = 1;
  std::vector<double> sum;
  std::vector<double> sum_of_squares;  ///< empty for a profile

  bool has_squares() const { return width == 1; }
};

/// Sums of an ensemble, by block. Merging two ensembles is adding. Quantities: "weight" (w = V_R + V_L of each bead),
/// "response" (w with the overload minus w without, per unit of it), "correlation" (of the loads with the weights, as a
/// spectrum), "propagation" (correlations of layers, see ensemble/fluctuation_estimator.h), "thrust" (sqrt(3) sum(H_R -
/// H_L) / sum(w) of a layer), "weight_variance" (mean over columns of (w - 1)^2), "redrawn" and
/// "redrawn_below_overload" (shares of a layer's beads), "response_thrust" (see ensemble/paired_estimator.h). Which
/// ones an ensemble holds depends on its estimator.
struct BlockSums {
  std::vector<int> layers;           ///< which layers are recorded, ascending
  std::vector<std::uint64_t> count;  ///< samples that entered each block
  std::map<std::string, QuantitySums> quantities;
  RowGeometry rows;     ///< where the layers lie
  int first_block = 0;  ///< number of the first of these blocks in the ensemble, of which they may be a part

  int blocks() const { return static_cast<int>(count.size()); }
};

/// Zeros for so many blocks of the quantities of `like`, and its layers.
BlockSums zero_sums(const BlockSums& like, int first_block, std::size_t blocks);

/// Blocks at places first .. first + blocks - 1 of `all`, as they are.
BlockSums take_blocks(const BlockSums& all, std::size_t first, std::size_t blocks);

/// A key of all numbers of the block at place `at`, of its number, its layers and the names of its quantities: equal
/// keys, equal blocks.
std::string key_of_block(const BlockSums& sums, std::size_t at);

}  // namespace granuscope
