#include "analysis/chain_share.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/layer_spectrum.h"
#include "model/lattice.h"

namespace granuscope {
namespace {

/// Part of the unit interval around x that lies in [low, high].
double overlap(double x, double low, double high) {
  return std::max(0.0, std::min(x + 0.5, high) - std::max(x - 0.5, low));
}

/// Share of the response `weight` - 1 of one layer that lies within chain_half_width of x = +-ray.
double share_near(const Lattice& lattice, int layer, const std::vector<double>& weight, double ray) {
  double inside = 0, all = 0;
  for (int i = 0; i < lattice.columns(); ++i) {
    const double x = lattice.x(layer, i), response = weight[static_cast<std::size_t>(i)] - 1;
    inside += response * (overlap(x, ray - chain_half_width, ray + chain_half_width) +
                          overlap(x, -ray - chain_half_width, -ray + chain_half_width));
    all += response;
  }
  return inside / all;
}

}  // namespace

std::vector<int> chain_layers(int shown_layers) {
  std::vector<int> layers(static_cast<std::size_t>(shown_layers));
  std::iota(layers.begin(), layers.end(), 0);
  return layers;
}

ChainShare measure_chain_share(const MeasuredEnsemble& ensemble) {
  const BlockSums& sums = ensemble.record.sums;
  const Lattice lattice(ensemble.spec.lattice);
  ChainShare result;
  result.spec = ensemble.spec;
  result.layers = static_cast<int>(sums.layers.size());
  result.samples = std::accumulate(sums.count.begin(), sums.count.end(), std::uint64_t{0});
  result.half_width = chain_half_width;

  std::vector<Replicated> thrust;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) thrust.push_back(block_mean(sums, "thrust", row));
  const Replicated c = transform([](double a) { return tan30 * std::sqrt(a); }, mean_of(thrust));
  result.c = estimate(c, "the mean thrust ratio is negative");
  result.share.reason = "no layer lies deep enough for the two bands to be apart";
  if (!result.c.known()) {
    result.share.reason = result.c.reason;
    return result;
  }

  std::vector<Replicated> shares;
  double even = 0;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const double z = Lattice::depth(layer), ray = c.value * z;
    if (ray < 2 * chain_half_width) continue;
    const BlockMeans weight = block_means(sums, "weight", row);
    Replicated share;
    share.value = share_near(lattice, layer, weight.whole, ray);
    for (std::size_t b = 0; b < weight.without_block.size(); ++b) {
      share.without_block.push_back(share_near(lattice, layer, weight.without_block[b], c.without_block[b] * z));
    }
    const double even_share = 2 * chain_half_width / (ray + chain_half_width);
    result.depths.push_back({layer, z, estimate(share), even_share});
    shares.push_back(std::move(share));
    even += even_share;
  }
  if (shares.empty()) return result;
  result.share = estimate(mean_of(shares));
  result.even_share = even / static_cast<double>(shares.size());
  return result;
}

}  // namespace granuscope
