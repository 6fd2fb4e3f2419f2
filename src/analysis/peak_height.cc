#include "analysis/peak_height.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "analysis/double_gaussian.h"

namespace granuscope {

Replicated peak_height(const BlockMeans& response, const Lattice& lattice, int layer, const Replicated& peak,
                       const Replicated& width) {
  std::vector<std::size_t> beads;
  std::vector<double> x;
  for (int i = 0; i < lattice.columns(); ++i) {
    const double at = lattice.x(layer, i);
    if (std::abs(std::abs(at) - peak.value) > width.value + 0.5) continue;
    beads.push_back(static_cast<std::size_t>(i));
    x.push_back(at);
  }
  const auto height = [&](const std::vector<double>& pressure, const DoubleGaussian& shape) {
    const std::vector<double> fitted = evaluate(shape, x, lattice.columns());
    double measured = 0;
    for (const std::size_t bead : beads) measured += pressure[bead];
    return largest_value(shape) * measured / std::accumulate(fitted.begin(), fitted.end(), 0.0);
  };
  Replicated result;
  result.value = height(response.whole, {peak.value, width.value});
  for (std::size_t b = 0; b < response.without_block.size(); ++b) {
    result.without_block.push_back(height(response.without_block[b], {peak.without_block[b], width.without_block[b]}));
  }
  return result;
}

}  // namespace granuscope
