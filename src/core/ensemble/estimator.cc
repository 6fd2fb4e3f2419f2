#include "ensemble/estimator.h"

#include <cmath>
#include <map>
#include <numeric>

#include "sampling/polytope.h"

namespace granuscope {
namespace {

using enum EstimatorName;

}  // namespace

std::vector<QuantityShape> quantities_of(const EnsembleSpec& spec) {
  switch (spec.response.estimator) {
    case paired:
      return PairedEstimator::quantities(spec);
    case multiplexed:
      return MultiplexedEstimator::quantities(spec);
    case fluctuation:
      return FluctuationEstimator::quantities(spec);
    case point:
      break;
  }
  return PointEstimator::quantities(spec);
}

KeptLayers layers_to_keep(const EnsembleSpec& spec) {
  if (spec.response.estimator == fluctuation) return FluctuationEstimator::layers_to_keep(spec);
  if (spec.response.estimator == multiplexed) return MultiplexedEstimator::layers_to_keep(spec);
  return {recorded_layers(spec), false, spec.record_forces};
}

std::size_t piles_at_once(const EnsembleSpec& spec) {
  const KeptLayers kept = layers_to_keep(spec);
  return piles_at_once(spec.sampler, Lattice(spec.lattice), &kept);
}

bool needs_two_samplers(const EnsembleSpec& spec) {
  return piles_per_sample(spec) == 2 && spec.sampler.law == Law::polytope;
}

int piles_per_sample(const EnsembleSpec& spec) {
  return spec.response.estimator == paired || (spec.response.estimator == multiplexed && spec.response.opposite) ? 2
                                                                                                                 : 1;
}

std::uint64_t beads_of(const EnsembleSpec& spec, std::uint64_t samples) {
  return samples * Lattice(spec.lattice).beads() * static_cast<std::uint64_t>(piles_per_sample(spec));
}

double drawing_memory(const EnsembleSpec& spec) {
  const Lattice lattice(spec.lattice);
  const KeptLayers kept = layers_to_keep(spec);
  double memory = drawing_memory(spec.sampler, lattice, &kept);
  // Drawn one by one, the piles of a group are kept until all are there.
  if (moves_loads(spec) && piles_at_once(spec) == 1) memory *= static_cast<double>(group_size);
  if (spec.response.estimator == fluctuation) memory += FluctuationEstimator::memory(spec);
  if (piles_per_sample(spec) == 1) return memory;
  // A sampler that draws two groups at once holds one of each load; any other holds twice what it is handed otherwise.
  const bool halves = spec.response.estimator == multiplexed && piles_at_once(spec) > group_lanes;
  return halves ? memory : 2 * memory;
}

std::unique_ptr<Estimator> make_estimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block) {
  switch (spec.response.estimator) {
    case paired:
      return std::make_unique<PairedEstimator>(spec, samplers, sums, block);
    case multiplexed:
      return std::make_unique<MultiplexedEstimator>(spec, samplers, sums, block);
    case fluctuation:
      return std::make_unique<FluctuationEstimator>(spec, samplers, sums, block);
    case point:
      break;
  }
  return std::make_unique<PointEstimator>(spec, samplers, sums, block);
}

namespace {

std::span<const char* const> extras_of(const SamplerSpec& sampler) {
  return is_flat(sampler) ? std::span<const char* const>(flat_tests) : extra_names(sampler.model);
}

}  // namespace

std::vector<QuantityShape> LayerObservables::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = {{"thrust", 1}, {"weight_variance", 1}};
  for (const char* extra : extras_of(spec.sampler)) all.push_back({extra, 1});
  return all;
}

LayerObservables::LayerObservables(const EnsembleSpec& spec, BlockSums& sums, int block)
    : layers_(sums.layers), flat_(is_flat(spec.sampler)) {
  for (const QuantityShape& one : quantities(spec)) all_.emplace_back(sums, one.name, block);
}

LayerObservables::Observed LayerObservables::of_layer(const PileGroup& group, int layer) const {
  Observed observed{group.moments_of(layer), {}};
  LayerMoments& moments = observed.moments;
  const double columns = group.lattice.columns(), mean = mean_weight(group.bead_weight, layer);
  for (std::size_t k = 0; k < group.piles; ++k) {
    const double total =
        std::accumulate(group.loads[k].begin(), group.loads[k].end(), 0.0) + columns * group.weight_of_beads(layer);
    moments.thrust[k] = group.lattice.geometry().cotangent * moments.thrust[k] / total;
    moments.variance[k] /= columns * (mean * mean);
    for (std::size_t e = 0; !flat_ && e + 2 < all_.size(); ++e) observed.extras[k][e] = group.extra(layer, e, k);
  }
  if (flat_) observed.extras[0] = measure_flatness(group, layer);
  return observed;
}

void LayerObservables::add(std::size_t l, const Observed& one, const Observed& other, std::size_t k) const {
  all_[0].add(l, (one.moments.thrust[k] + other.moments.thrust[k]) / 2);
  all_[1].add(l, (one.moments.variance[k] + other.moments.variance[k]) / 2);
  for (std::size_t e = 0; e + 2 < all_.size(); ++e) all_[e + 2].add(l, (one.extras[k][e] + other.extras[k][e]) / 2);
}

void LayerObservables::add(const Pile& pile) const {
  const std::span<const double> load = pile.load;
  const std::optional<SamplingFailure> no_failure;
  add(group_of(pile, load), {&no_failure, 1});
}

void LayerObservables::add(const PileGroup& group, Failures failures) const {
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Observed observed = of_layer(group, layers_[l]);
    for (std::size_t k = 0; k < group.piles; ++k) {
      if (!failures[k]) add(l, observed, observed, k);
    }
  }
}

void LayerObservables::add_mean(const PileGroup& one, const PileGroup& other, Failures failures) const {
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Observed a = of_layer(one, layers_[l]), b = of_layer(other, layers_[l]);
    for (std::size_t k = 0; k < one.piles; ++k) {
      if (!failures[k]) add(l, a, b, k);
    }
  }
}

void LayerObservables::add_means(const PileGroup& group, Failures failures, const std::vector<int>& bases,
                                 int offset) const {
  std::map<int, Observed> observed;
  const auto count = static_cast<double>(bases.size());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    Observed mean{};
    for (const int base : bases) {
      const int layer = base + offset + layers_[l];
      const auto [found, is_new] = observed.try_emplace(layer);
      if (is_new) found->second = of_layer(group, layer);
      for (std::size_t k = 0; k < group.piles; ++k) {
        mean.moments.thrust[k] += found->second.moments.thrust[k];
        mean.moments.variance[k] += found->second.moments.variance[k];
        for (std::size_t e = 0; e + 2 < all_.size(); ++e) mean.extras[k][e] += found->second.extras[k][e];
      }
    }
    for (std::size_t k = 0; k < group.piles; ++k) {
      mean.moments.thrust[k] /= count;
      mean.moments.variance[k] /= count;
      for (double& extra : mean.extras[k]) extra /= count;
      if (!failures[k]) add(l, mean, mean, k);
    }
  }
}

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
