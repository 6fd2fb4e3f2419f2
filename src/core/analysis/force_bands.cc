#include "analysis/force_bands.h"

#include <algorithm>
#include <cmath>

namespace granuscope {

using namespace force_bins;

std::vector<Estimate> counts_per_bead(const std::vector<ForceSums>& blocks) {
  std::vector<Estimate> counts;
  for (const Replicated& bin : replicated(blocks, [](ForceSums sums) {
         for (double& one : sums) one /= sums[beads_at];
         return sums;
       })) {
    counts.push_back(estimate(bin));
  }
  return counts;
}

std::vector<ForceSums> band_sums(const BlockSums& sums, int columns, std::size_t first, std::size_t end) {
  std::vector<ForceSums> blocks(sums.count.size(), ForceSums(beads_at + 1));
  for (std::size_t row = first; row < end; ++row) {
    const LayerSums counts = sums.layer("force_counts", row), moments = sums.layer("force_moments", row);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      for (std::size_t i = 0; i < moments_at; ++i) blocks[b][i] += counts.block(b)[i];
      for (std::size_t i = moments_at; i < beads_at; ++i) blocks[b][i] += moments.block(b)[i - moments_at];
      blocks[b][beads_at] += static_cast<double>(sums.count[b]) * columns;
    }
  }
  return blocks;
}

std::vector<Replicated> replicated(const std::vector<ForceSums>& blocks,
                                   const std::function<std::vector<double>(const ForceSums&)>& f) {
  ForceSums all(beads_at + 1);
  for (const ForceSums& block : blocks) std::ranges::transform(all, block, all.begin(), std::plus<>());
  std::vector<Replicated> numbers;
  for (const double value : f(all)) numbers.push_back({value, {}});
  for (const ForceSums& block : blocks) {
    ForceSums rest = all;
    std::ranges::transform(all, block, rest.begin(), std::minus<>());
    const std::vector<double> without = f(rest);
    for (std::size_t i = 0; i < without.size(); ++i) numbers[i].without_block.push_back(without[i]);
  }
  return numbers;
}

double force_moment(const ForceSums& sums, ForceMoment which, std::size_t further) {
  return sums[moments_at + static_cast<std::size_t>(which) + further];
}

double mean_of_force(const ForceSums& sums, const CountedForce& force) {
  return force.about + force_moment(sums, force.powers) / (force.per_bead * sums[beads_at]);
}

std::vector<double> moments_of(const ForceSums& sums, const CountedForce& force) {
  const double n = force.per_bead * sums[beads_at], mean = mean_of_force(sums, force), shift = mean - force.about;
  const double second = force_moment(sums, force.powers, 1) / n, third = force_moment(sums, force.powers, 2) / n;
  const double variance = second - shift * shift;
  return {mean, variance / (mean * mean),
          (third - 3 * shift * second + 2 * std::pow(shift, 3)) / std::pow(variance, 1.5)};
}

std::vector<double> mobilisation_of(const ForceSums& sums) {
  const double contacts = 2 * sums[beads_at];
  return {force_moment(sums, ForceMoment::mobilisation) / contacts,
          force_moment(sums, ForceMoment::sliding) / contacts};
}

DensityRows density_of(const std::vector<ForceSums>& blocks, const CountedForce& force) {
  const std::vector<Estimate> counts = counts_per_bead(blocks);
  const double mean =
      replicated(blocks, [&](const ForceSums& sums) { return std::vector{mean_of_force(sums, force)}; })[0].value;
  const double factor = mean * per_unit / force.per_bead;
  DensityRows rows;
  for (std::size_t i = 0; i + 1 < values; ++i) {
    const double count = counts[force.histogram + i].value, error = counts[force.histogram + i].standard_error;
    if (!(error < count / 2)) continue;
    rows.push_back({(static_cast<double>(i) + 0.5) / (per_unit * mean), factor * count, factor * error});
  }
  return rows;
}

DensityRows density_of_mobilisation(const std::vector<ForceSums>& blocks) {
  const std::vector<Estimate> counts = counts_per_bead(blocks);
  DensityRows rows;
  constexpr std::size_t half = mobilisations / 2;
  for (std::size_t i = 0; i < half; ++i) {
    const Estimate &up = counts[mobilisation + 1 + half + i], &down = counts[mobilisation + half - i];
    rows.push_back({(static_cast<double>(i) + 0.5) / half, (up.value + down.value) * half / 2,
                    std::hypot(up.standard_error, down.standard_error) * half / 2});
  }
  return rows;
}

}  // namespace granuscope
