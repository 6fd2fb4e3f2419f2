#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace granuscope {

/// Sums of one measured quantity over the samples of each block, shape [blocks, layers, width], row-major; width is
/// the number of columns for a profile and 1 for a number per layer.
struct QuantitySums {
  int width = 1;
  std::vector<double> sum;
  std::vector<double> sum_of_squares;
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

  int blocks() const { return static_cast<int>(count.size()); }
};

}  // namespace granuscope
