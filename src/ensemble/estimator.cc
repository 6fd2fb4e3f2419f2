#include "ensemble/estimator.h"

#include <fmt/format.h>

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
    case point:
      break;
  }
  return "point";
}

EstimatorName estimator_named(const std::string& name) {
  for (EstimatorName estimator : {point, paired, multiplexed}) {
    if (name_of(estimator) == name) return estimator;
  }
  throw InputError(
      fmt::format("there is no estimator \"{}\": known are point, paired and multiplexed; choose one of them", name));
}

std::vector<QuantityShape> quantities_of(const EnsembleSpec& spec) {
  switch (spec.estimator) {
    case paired:
      return PairedEstimator::quantities(spec);
    case multiplexed:
      return MultiplexedEstimator::quantities(spec);
    case point:
      break;
  }
  return PointEstimator::quantities(spec);
}

bool needs_two_samplers(const EnsembleSpec& spec) {
  const bool two_loads = spec.estimator == paired || (spec.estimator == multiplexed && spec.opposite);
  return two_loads && spec.sampler.law == Law::polytope;
}

std::unique_ptr<Estimator> make_estimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block) {
  switch (spec.estimator) {
    case paired:
      return std::make_unique<PairedEstimator>(spec, samplers, sums, block);
    case multiplexed:
      return std::make_unique<MultiplexedEstimator>(spec, samplers, sums, block);
    case point:
      break;
  }
  return std::make_unique<PointEstimator>(spec, samplers, sums, block);
}

}  // namespace granuscope
