#include "ensemble/force_counts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace granuscope {
namespace {

constexpr auto moments = static_cast<std::size_t>(ForceMoment::count);

/// The bin of `x` among so many of equal width from 0 on.
std::size_t bin_of(double x, std::size_t bins_per_unit, std::size_t bins) {
  const double bin = x * static_cast<double>(bins_per_unit);
  return std::min(static_cast<std::size_t>(std::max(bin, 0.0)), bins - 1);
}

struct Sums {
  std::array<double, moments> all{};

  double& operator[](ForceMoment moment) { return all[static_cast<std::size_t>(moment)]; }
  void add_powers(ForceMoment first, double x) {
    const auto at = static_cast<std::size_t>(first);
    all[at] += x;
    all[at + 1] += x * x;
    all[at + 2] += x * x * x;
  }
};

}  // namespace

std::vector<QuantityShape> ForceCounts::quantities() {
  return {{"force_counts", static_cast<int>(force_bins::width)}, {"force_moments", static_cast<int>(moments)}};
}

ForceCounts::ForceCounts(const EnsembleSpec& spec, BlockSums& sums, int block)
    : mu_(spec.sampler.model.has_contacts() ? spec.sampler.mu : 0),
      layers_(sums.layers),
      counts_(sums, "force_counts", block),
      moments_(sums, "force_moments", block) {}

void ForceCounts::add(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) const {
  using namespace force_bins;
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  const BeadGeometry& to = group.lattice.geometry();
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const double mean = mean_weight(group.bead_weight, layers_[l]);
    const auto count = [&](std::size_t histogram, std::size_t bin) { counts_.add(l, histogram + bin, 1); };
    Sums sums;
    // `outwards`: the horizontal force away from the bead.
    const auto add_contact = [&](double V, double outwards) {
      const double N = (to.twice_sine * outwards + to.twice_cosine * V) / (2 * mean);
      const double T = (to.twice_cosine * outwards - to.twice_sine * V) / (2 * mean);
      const double mobilised = mu_ > 0 && N > 0 ? std::clamp(T / (mu_ * N), -1.0, 1.0) : 0;
      const bool slides = std::abs(mobilised) >= 1 - sliding;
      count(normal, bin_of(N, per_unit, values));
      count(mobilisation, !slides         ? 1 + bin_of(mobilised + 1, mobilisations / 2, mobilisations)
                          : mobilised > 0 ? mobilisations + 1
                                          : 0);
      count(map, bin_of(N, map_per_unit, map_normals) * map_mobilisations +
                     bin_of(mobilised + 1, map_mobilisations / 2, map_mobilisations));
      sums.add_powers(ForceMoment::N, N - tan30);
      sums[ForceMoment::tangential] += std::abs(T);
      sums[ForceMoment::mobilisation] += std::abs(mobilised);
      sums[ForceMoment::sliding] += slides ? 1 : 0;
    };
    for (std::size_t i = 0, row = group.row(layers_[l]); i < columns; ++i, row += group.stride) {
      for (std::size_t k = 0; k < group.piles; ++k) {
        if (failures[k]) continue;
        const double w = group.weight(row + k) / mean;
        count(weight, bin_of(w, per_unit, values));
        sums.add_powers(ForceMoment::w, w - 1);
        if (group.V_R == nullptr) continue;
        add_contact(group.V_R[row + k], group.H_R[row + k]);
        add_contact(group.V_L[row + k], -group.H_L[row + k]);
      }
    }
    for (std::size_t m = 0; m < moments; ++m) moments_.add(l, m, sums.all[m]);
  }
}

}  // namespace granuscope
