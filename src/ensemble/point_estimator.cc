#include "ensemble/point_estimator.h"

#include <algorithm>

#include "model/identities.h"

namespace granuscope {

std::vector<QuantityShape> PointEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerNumbers::quantities();
  if (spec.record_profiles) all.push_back({"weight", spec.lattice.columns});
  return all;
}

PointEstimator::PointEstimator(const EnsembleSpec& spec, BlockSums& sums, int block)
    : load_(top_load(spec)),
      sampler_(make_sampler(spec.sampler, Lattice(spec.lattice))),
      piles_(piles_at_once(spec.sampler, Lattice(spec.lattice)), Pile(Lattice(spec.lattice))),
      layers_(sums.layers),
      numbers_(sums, block),
      profiles_(spec.record_profiles),
      weight_(profiles_ ? BlockSlice(sums, "weight", block) : BlockSlice()) {}

std::optional<SamplingFailure> PointEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_group(sample, {&failure, 1});
  return failure;
}

void PointEstimator::measure_group(std::uint64_t first, std::span<std::optional<SamplingFailure>> failures) {
  const std::vector<std::span<const double>> loads(piles_.size(), load_);
  for (std::size_t done = 0; done < failures.size(); done += piles_.size()) {
    const std::size_t count = std::min(piles_.size(), failures.size() - done);
    const std::span<Pile> piles(piles_.data(), count);
    sampler_->draw_group(first + done, {loads.data(), count}, piles, failures.subspan(done, count));
    for (std::size_t k = 0; k < count; ++k) {
      if (!failures[done + k]) add(piles[k]);
    }
  }
}

void PointEstimator::add(const Pile& pile) {
  assert_identities(pile);
  numbers_.add(pile);
  if (!profiles_) return;
  const auto columns = static_cast<std::size_t>(pile.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = pile.lattice.index(layers_[l], 0);
    for (std::size_t i = 0; i < columns; ++i) weight_.add(l, i, pile.V_R[row + i] + pile.V_L[row + i]);
  }
}

}  // namespace granuscope
