#include "analysis/mean_response.h"

#include "analysis/propagator.h"

#include "ensemble/real_spectrum.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// The response of each distance d from the loaded bead, shifted so that the loaded bead is the middle one.
std::vector<double> response_of(const std::vector<double>& correlation, const std::vector<double>& loads,
                                const RealSpectrum& fourier) {
  const std::size_t columns = correlation.size();
  std::vector<double> by_distance(columns), response(columns);
  for (std::size_t at = 0; at < columns; ++at) {
    // Entries 2m - 1 and 2m are the real and imaginary parts of the mode m, whose load spectrum is real.
    by_distance[at] = correlation[at] / loads[at == 0 ? 0 : (at - 1) / 2 * 2 + 1];
  }
  fourier.inverse(by_distance);
  for (std::size_t d = 0; d < columns; ++d) response[(d + columns / 2) % columns] = by_distance[d];
  return response;
}

BlockMeans mean_correlation(const BlockSums& sums, std::size_t row) {
  const LayerSums correlations = sums.layer("correlation", row), load_spectra = load_spectrum_sums(sums);
  const std::size_t columns = correlations.width(), blocks = correlations.blocks();
  const RealSpectrum fourier(columns);
  const auto total = [&](std::size_t left_out) {
    std::vector<double> correlation(columns), loads(columns);
    for (std::size_t b = 0; b < blocks; ++b) {
      if (b == left_out) continue;
      const double* const c = correlations.block(b);
      const double* const l = load_spectra.block(b);
      for (std::size_t i = 0; i < columns; ++i) correlation[i] += c[i], loads[i] += l[i];
    }
    return response_of(correlation, loads, fourier);
  };
  BlockMeans means;
  means.whole = total(blocks);
  for (std::size_t b = 0; b < blocks; ++b) means.without_block.push_back(total(b));
  return means;
}

}  // namespace

ResponseQuantity response_quantity(const BlockSums& sums, double overload) {
  if (sums.quantities.contains("response")) return {"response", 0, 1};
  if (sums.quantities.contains("weight")) return {"weight", 1, overload};
  throw InputError(
      "the ensemble holds numbers per layer only, so that there is no response to fit; draw it with its profiles "
      "recorded");
}

bool holds_correlations(const BlockSums& sums) { return sums.quantities.contains("correlation"); }

std::size_t first_response(const BlockSums& sums) {
  return holds_correlations(sums) || holds_propagation(sums) ? 1 : 0;
}

LayerSums load_spectrum_sums(const BlockSums& sums) {
  if (sums.layers.empty() || sums.layers.front() != 0) {
    throw InputError(
        "the ensemble does not hold layer 0, and with it the spectrum of its loads, so that its response is not known; "
        "draw it again");
  }
  return sums.layer("correlation", 0);
}

BlockMeans mean_response(const BlockSums& sums, std::size_t row, double overload) {
  if (holds_propagation(sums)) return propagated_response(sums, row);
  if (holds_correlations(sums)) return mean_correlation(sums, row);
  const ResponseQuantity response = response_quantity(sums, overload);
  BlockMeans means = block_means(sums, response.name, row);
  const auto take_response = [&](std::vector<double>& profile) {
    for (double& value : profile) value = (value - response.background) / response.scale;
  };
  take_response(means.whole);
  for (auto& without : means.without_block) take_response(without);
  return means;
}

}  // namespace granuscope
