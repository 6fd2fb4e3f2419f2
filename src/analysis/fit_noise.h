#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "analysis/noise_spectrum.h"
#include "storage/block_sums.h"

namespace granuscope {

/// The noise by which the fits of an ensemble divide their modes, from the whole of it and again without each block: it
/// is part of the chain that errors go through.
struct FitNoise {
  NoiseSpectrum whole;
  std::vector<NoiseSpectrum> without_block;  ///< with D of the whole
};

/// Fitted to some of the recorded layers `rows` (indices into sums.layers), spread evenly: neighbours fluctuate
/// together. None where the ensemble does not scatter.
std::optional<FitNoise> fit_noise(const BlockSums& sums, const std::vector<std::size_t>& rows, double overload);

}  // namespace granuscope
