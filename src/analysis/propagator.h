#pragma once
#include <cstddef>
#include <vector>

#include "analysis/layer_spectrum.h"
#include "storage/block_sums.h"

namespace granuscope {

/// Whether the sums are those of the estimator fluctuation: correlations of layers instead of a response.
bool holds_propagation(const BlockSums& sums);

/// The sums of "propagation" of recorded lag number `row`.
LayerSums propagation_at(const BlockSums& sums, std::size_t row);

/// Their totals over all blocks but one, or over all if `left_out` is blocks(): correlation_parts
/// (ensemble/group_fourier.h) for each of the modes 1, 2, ... that carry weight there.
std::vector<double> propagation_without(const LayerSums& propagation, std::size_t left_out);

/// The Fourier modes of the mean response over recorded lag number `row`, the (w, w) element of C_{r+l} C_r^-1
/// (ensemble/fluctuation_estimator.h), from sums over blocks, never from ratios of one block. As many modes as carry
/// weight there; none where nothing fluctuates.
BlockMeans propagated_modes(const BlockSums& sums, std::size_t row);

/// The mean response in x that these modes make, modes without weight being 0; entry i belongs to bead i, the loaded
/// bead being Lattice::middle().
BlockMeans propagated_response(const BlockSums& sums, std::size_t row);

}  // namespace granuscope
