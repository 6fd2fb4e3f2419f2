#include "ensemble/point_estimator.h"

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
      pile_(Lattice(spec.lattice)),
      layers_(sums.layers),
      numbers_(sums, block),
      profiles_(spec.record_profiles),
      weight_(profiles_ ? BlockSlice(sums, "weight", block) : BlockSlice()) {}

std::optional<SamplingFailure> PointEstimator::measure(std::uint64_t sample) {
  if (const auto failure = sampler_->draw(sample, load_, pile_)) return failure;
  assert_identities(pile_);
  numbers_.add(pile_);
  if (!profiles_) return std::nullopt;
  const auto columns = static_cast<std::size_t>(pile_.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = pile_.lattice.index(layers_[l], 0);
    for (std::size_t i = 0; i < columns; ++i) weight_.add(l, i, pile_.V_R[row + i] + pile_.V_L[row + i]);
  }
  return std::nullopt;
}

}  // namespace granuscope
