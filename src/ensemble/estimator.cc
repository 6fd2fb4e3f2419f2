#include "ensemble/estimator.h"

#include <fmt/format.h>

#include "ensemble/fluctuation_estimator.h"
#include "ensemble/multiplexed_estimator.h"
#include "ensemble/paired_estimator.h"
#include "ensemble/point_estimator.h"
#include "support/error.h"

namespace granuscope {
namespace {

using enum EstimatorName;

}  // namespace

std::string name_of(EstimatorName estimator) {
  switch (estimator) {
    case paired:
      return "paired";
    case multiplexed:
      return "multiplexed";
    case fluctuation:
      return "fluctuation";
    case point:
      break;
  }
  return "point";
}

EstimatorName estimator_named(const std::string& name) {
  for (EstimatorName estimator : {point, paired, multiplexed, fluctuation}) {
    if (name_of(estimator) == name) return estimator;
  }
  throw InputError(fmt::format(
      "there is no estimator \"{}\": known are point, paired, multiplexed and fluctuation; choose one of them", name));
}

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
  return {recorded_layers(spec)};
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

}  // namespace granuscope
