#include "analysis/redrawn_beads.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "ensemble/paired_estimator.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// The mean over the usable layers of a share per layer, each layer weighted with `beads_of(layer)`.
template <typename BeadsOf>
Replicated share_of_pile(const BlockSums& sums, const std::string& quantity, int layers, BeadsOf beads_of) {
  Replicated share{0, std::vector<double>(static_cast<std::size_t>(sums.blocks()), 0.0)};
  double beads = 0;
  for (int layer = 0; layer < layers; ++layer) beads += beads_of(layer);
  for (int layer = 0; layer < layers; ++layer) {
    const double weight = beads_of(layer) / beads;
    const BlockMeans means = block_means(sums, quantity, static_cast<std::size_t>(layer));
    share.value += weight * means.whole[0];
    for (std::size_t b = 0; b < share.without_block.size(); ++b) {
      share.without_block[b] += weight * means.without_block[b][0];
    }
  }
  return share;
}

}  // namespace

RedrawnBeads measure_redrawn_beads(const MeasuredEnsemble& ensemble) {
  const auto& [spec, record] = ensemble;
  const Lattice lattice(spec.lattice);
  const BlockSums& sums = record.sums;
  const int usable = lattice.usable_layers();
  if (usable == 0 || !sums.quantities.contains("redrawn") || sums.layers.size() < static_cast<std::size_t>(usable) ||
      sums.layers[static_cast<std::size_t>(usable) - 1] != usable - 1) {
    throw InputError(
        fmt::format("the ensemble does not hold the redrawn beads of all usable layers, so that their share is not "
                    "known; draw it with the estimator paired, more than {} layers, and all of them recorded",
                    bottom_margin));
  }
  RedrawnBeads result;
  result.spec = spec;
  result.failed = record.failed.size();
  for (const std::uint64_t count : sums.count) result.samples += count;
  if (std::find(sums.count.begin(), sums.count.end(), 0) != sums.count.end()) {
    result.whole_pile.reason = result.below_overload.reason =
        "a block of the ensemble holds no completed pair of piles";
    return result;
  }
  result.whole_pile = estimate(share_of_pile(sums, "redrawn", usable, [](int) { return 1.0; }));
  result.below_overload = estimate(share_of_pile(sums, "redrawn_below_overload", usable,
                                                 [&](int layer) { return beads_below_overload(lattice, layer); }));
  return result;
}

}  // namespace granuscope
