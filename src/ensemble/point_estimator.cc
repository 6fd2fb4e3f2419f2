#include "ensemble/point_estimator.h"

#include "ensemble/draw_alike.h"

namespace granuscope {

std::vector<QuantityShape> PointEstimator::quantities(const EnsembleSpec& spec) {
  std::vector<QuantityShape> all = LayerObservables::quantities(spec);
  if (spec.record_profiles) all.push_back({"weight", spec.lattice.columns});
  return all;
}

PointEstimator::PointEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block)
    : load_(top_load(spec)),
      loads_(piles_at_once(spec), load_),
      sampler_(samplers.first),
      layers_(sums.layers),
      observables_(spec, sums, block),
      profiles_(spec.record_profiles),
      weight_(profiles_ ? BlockSlice(sums, "weight", block) : BlockSlice()) {}

std::optional<SamplingFailure> PointEstimator::measure(std::uint64_t sample) {
  std::optional<SamplingFailure> failure;
  measure_samples({&sample, 1}, {&failure, 1});
  return failure;
}

void PointEstimator::measure_samples(std::span<const std::uint64_t> samples,
                                     std::span<std::optional<SamplingFailure>> failures) {
  draw_alike(sampler_, loads_, samples, failures, [&](const PileGroup& group, auto of_group) { add(group, of_group); });
}

void PointEstimator::add(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) {
  assert_identities(group, failures);
  observables_.add(group, failures);
  if (!profiles_) return;
  const auto columns = static_cast<std::size_t>(group.lattice.columns());
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const std::size_t row = group.row(layers_[l]);
    const double of_beads = group.weight_of_beads(layers_[l]);
    for (std::size_t i = 0; i < columns; ++i) {
      for (std::size_t k = 0; k < group.piles; ++k) {
        if (!failures[k]) weight_.add(l, i, group.weight(row + i * group.stride + k) - of_beads);
      }
    }
  }
}

}  // namespace granuscope
