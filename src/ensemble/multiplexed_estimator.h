#pragma once
#include "ensemble/estimator.h"
#include "ensemble/layer_numbers.h"
#include "ensemble/real_spectrum.h"

namespace granuscope {

/// Every top bead at once: the loads are 1 + epsilon xi_i with independent signs xi_i = +-1, and the linear response is
/// the circular cross-correlation of the weights with xi,
///   G(d) = <xi_j (w_{j+d} - 1)>/epsilon,
/// so that each pile measures the response of every one of its columns. What varies by chance, and not with xi, is
/// noise that the division by epsilon magnifies: the error falls as 1/epsilon, the piles needed as 1/epsilon^2. With
/// `opposite` each sample is a pair of piles of the same random numbers under 1 + epsilon xi and 1 - epsilon xi, and
/// w - 1 is half their difference: noise that both share drops out, and with it the part of the response that is even
/// in epsilon. The signs may be drawn in runs (load_signs.h); under the law polytope the eight samples of a chain share
/// theirs, since a chain belongs to one load. Sums, in Fourier space (layout: RealSpectrum),
///   "correlation"   conj(xi^_m) w^_m / (columns epsilon)   of each layer;
/// on layer 0 that is the realised spectrum |xi^_m|^2 / columns itself, since there w - 1 = epsilon xi. The analysis
/// divides by it (analysis/layer_spectrum.h): the response of layer 0 is then exactly a delta, its sum exactly 1.
class MultiplexedEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  MultiplexedEstimator(const EnsembleSpec& spec, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_group(std::uint64_t first, std::span<std::optional<SamplingFailure>> failures) override;
  const SamplerCounts& counts() const override { return counts_; }

 private:
  /// Piles under one sign of the variations, with what draws them; as many as are drawn at once.
  struct Side {
    Sampler* sampler = nullptr;
    std::vector<std::vector<double>> loads;
    std::vector<Pile> piles;
  };

  void choose_loads(std::uint64_t sample, std::size_t k);
  static void draw(Side& side, std::uint64_t first, std::span<std::optional<SamplingFailure>> failures);
  void add(std::size_t k);
  void add_correlation(std::size_t k);
  /// w - 1 of a layer, or half the difference from the opposite pile, into spectrum_.
  void find_variation(std::size_t k, std::size_t row);

  EnsembleSpec spec_;
  std::size_t columns_;
  std::vector<std::vector<double>> signs_;  ///< of each pile drawn at once
  std::vector<double> sign_spectrum_, spectrum_;
  RealSpectrum fourier_;
  std::unique_ptr<Sampler> sampler_, chain_;  ///< chain_: of the opposite loads, where a law keeps a chain for a load
  Side side_, opposite_;                      ///< opposite_: empty unless asked for
  const std::vector<int>& layers_;
  LayerNumbers numbers_;
  bool profiles_;
  BlockSlice correlation_;
  SamplerCounts counts_;
};

}  // namespace granuscope
