#pragma once
#include "ensemble/estimator.h"
#include "ensemble/layer_observables.h"

namespace granuscope {

/// The paper's procedure: each sample is one pile under the load of the ensemble. Sums "weight", w = V_R + V_L of each
/// bead less the mean of what beads weigh by themselves down to its layer, from which the analysis takes the uniform
/// load away. Under a uniform load there is no response to measure; the numbers per layer alone then give the thrust
/// ratio.
class PointEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  PointEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_samples(std::span<const std::uint64_t> samples,
                       std::span<std::optional<SamplingFailure>> failures) override;

 private:
  void add(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures);

  std::vector<double> load_;
  std::vector<std::span<const double>> loads_;  ///< the same for each pile drawn at once
  Sampler& sampler_;
  const std::vector<int>& layers_;
  LayerObservables observables_;
  bool profiles_;
  BlockSlice weight_;
};

}  // namespace granuscope
