#include "analysis/fit_noise.h"

#include <algorithm>

#include "analysis/layer_spectrum.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

constexpr std::size_t most_depths = 12;

}  // namespace

std::optional<FitNoise> fit_noise(const BlockSums& sums, const std::vector<std::size_t>& rows, double overload) {
  if (rows.empty()) return std::nullopt;
  const LayerSpectrum deepest = layer_spectrum(sums, rows.back(), overload);
  if (deepest.exact) return std::nullopt;
  const std::size_t depths = std::min(most_depths, rows.size());
  std::vector<LayerVariances> whole;
  std::vector<std::vector<LayerVariances>> without_block(deepest.without_block.size());
  for (std::size_t i = 0; i < depths; ++i) {
    const std::size_t row = rows[depths == 1 ? 0 : i * (rows.size() - 1) / (depths - 1)];
    const double z = Lattice::depth(sums.layers[row]);
    BlockMeans variances = mode_variances(sums, row, overload);
    whole.push_back({z, std::move(variances.whole)});
    for (std::size_t b = 0; b < without_block.size(); ++b) {
      without_block[b].push_back({z, std::move(variances.without_block[b])});
    }
  }
  FitNoise noise{NoiseSpectrum(deepest.columns, whole), {}};
  for (const auto& layers : without_block) noise.without_block.push_back(noise.whole.refitted(layers));
  return noise;
}

}  // namespace granuscope
