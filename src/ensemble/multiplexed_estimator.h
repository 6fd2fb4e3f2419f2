#pragma once
#include "ensemble/estimator.h"
#include "ensemble/layer_numbers.h"
#include "ensemble/real_spectrum.h"

namespace granuscope {

/// Every top bead at once: the loads are 1 + epsilon xi_i with independent signs xi_i = +-1, and the linear response is
/// the circular cross-correlation of the weights with xi,
///   G(d) = <xi_j (w_{j+d} - 1)>/epsilon,
/// so that each pile measures the response of every one of its columns. Sums, in Fourier space (layout: RealSpectrum),
///   "correlation"   conj(xi^_m) w^_m / (columns epsilon)   of each layer;
/// on layer 0 that is the realised spectrum |xi^_m|^2 / columns itself, since there w - 1 = epsilon xi. The analysis
/// divides by it (analysis/layer_spectrum.h): the response of layer 0 is then exactly a delta, its sum exactly 1.
class MultiplexedEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  MultiplexedEstimator(const EnsembleSpec& spec, Sampler& sampler, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_samples(std::span<const std::uint64_t> samples,
                       std::span<std::optional<SamplingFailure>> failures) override;

 private:
  void choose_signs(std::uint64_t sample, std::size_t k);
  void add_correlation(const PileGroup& group, std::size_t k);

  std::uint64_t seed_;
  double epsilon_;
  std::size_t columns_;
  std::vector<std::vector<double>> signs_, loads_;  ///< of each pile
  std::vector<double> sign_spectrum_, spectrum_;
  RealSpectrum fourier_;
  Sampler& sampler_;
  const std::vector<int>& layers_;
  LayerNumbers numbers_;
  bool profiles_;
  BlockSlice correlation_;
};

}  // namespace granuscope
