#include "analysis/peak_height.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "analysis/double_gaussian.h"

namespace granuscope {
namespace {

/// Share of the bead at x that lies within W + 1/2 of +-x_p. Beads that count whole or not at all would make height
/// jump where an edge passes the middle of one, which no jackknife follows.
double share_within(double x, const DoubleGaussian& shape) {
  return std::clamp(shape.width + 1 - std::abs(std::abs(x) - shape.peak), 0.0, 1.0);
}

}  // namespace

Replicated peak_height(const BlockMeans& response, const Lattice& lattice, int layer, const Replicated& peak,
                       const Replicated& width) {
  const auto height = [&](const std::vector<double>& pressure, const DoubleGaussian& shape) {
    std::vector<double> x, shares;
    double measured = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const double at = lattice.x(layer, i), share = share_within(at, shape);
      if (share == 0) continue;
      x.push_back(at);
      shares.push_back(share);
      measured += share * pressure[static_cast<std::size_t>(i)];
    }
    const std::vector<double> fitted = evaluate(shape, x, lattice.columns());
    return largest_value(shape) * measured / std::inner_product(shares.begin(), shares.end(), fitted.begin(), 0.0);
  };
  Replicated result;
  result.value = height(response.whole, {peak.value, width.value});
  for (std::size_t b = 0; b < response.without_block.size(); ++b) {
    result.without_block.push_back(height(response.without_block[b], {peak.without_block[b], width.without_block[b]}));
  }
  return result;
}

}  // namespace granuscope
