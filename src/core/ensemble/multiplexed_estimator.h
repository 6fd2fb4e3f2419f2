#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "ensemble/ensemble_spec.h"
#include "ensemble/estimator.h"

namespace granuscope {
/// The signs xi_i = +-1 by which the top loads of one sample are varied (estimator multiplexed), a pure function of
/// (seed, sample, run, number of columns).
///
/// run = 1: one fair sign for each bead. run > 1: one for each run of `run` or, by a fair coin, `run` + 1 beads (the
/// last run ends with the ring). Runs move what the loads say from short waves, which no layer below remembers where
/// peaks are wide, to long ones: the power of a wavelength of many runs is `run` times larger. Two lengths, since
/// runs of one length alone would leave the waves that fit into them without any load.
void draw_signs(std::uint64_t seed, std::uint64_t sample, int run, std::span<double> signs);

/// Those of a sample of the ensemble; the eight samples of a chain share theirs, since a chain belongs to one load.
void draw_signs(const EnsembleSpec& spec, std::uint64_t sample, std::span<double> signs);

/// The discrete Fourier transform of real rings of one size, sum_j f_j exp(-2 pi i m j / n), by GSL's mixed-radix FFT.
/// Spectra have n entries: Re of m = 0, then Re and Im of m = 1, 2, ..., and for even n Re of m = n/2.
class RealSpectrum {
 public:
  explicit RealSpectrum(std::size_t size);
  ~RealSpectrum();
  RealSpectrum(RealSpectrum&&) noexcept;

  /// Both in place; inverse(transform(f)) is f. `ring` has the size given.
  void transform(std::span<double> ring) const;
  void inverse(std::span<double> spectrum) const;

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

/// Every top bead at once: the loads are 1 + epsilon xi_i with independent signs xi_i = +-1, and the linear response is
/// the circular cross-correlation of the weights with xi,
///   G(d) = <xi_j (w_{j+d} - 1)>/epsilon,
/// so that each pile measures the response of every one of its columns. What varies by chance, and not with xi, is
/// noise that the division by epsilon magnifies: the error falls as 1/epsilon, the piles needed as 1/epsilon^2. With
/// `opposite` each sample is a pair of piles of the same random numbers under 1 + epsilon xi and 1 - epsilon xi, and
/// w - 1 is half their difference: noise that both share drops out, and with it the part of the response that is even
/// in epsilon. The signs may be drawn in runs (multiplexed_estimator.h); under the law polytope the eight samples of a
/// chain share theirs, since a chain belongs to one load. Sums, in Fourier space (layout: RealSpectrum),
///   "correlation"   conj(xi^_m) w^_m / (columns epsilon)   of each layer;
///   "correlation_H"   conj(xi^_m) H^_m / (columns epsilon)   likewise, where it is asked for (EnsembleSpec::record_H);
/// on layer 0 the first is the realised spectrum |xi^_m|^2 / columns itself, since there w - 1 = epsilon xi. The
/// analysis divides by it (analysis/mean_response.h): the response of layer 0 is then exactly a delta, its sum
/// exactly 1. What moves towards +x brings H > 0, what moves towards -x brings H < 0: the response of H tells the two
/// apart.
class MultiplexedEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  static KeptLayers layers_to_keep(const EnsembleSpec& spec);
  MultiplexedEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_samples(std::span<const std::uint64_t> samples,
                       std::span<std::optional<SamplingFailure>> failures) override;

 private:
  void choose_loads(std::uint64_t sample, std::size_t k);
  void draw(std::span<const std::uint64_t> samples, std::span<std::optional<SamplingFailure>> failures);
  void add(std::size_t g, std::size_t first, std::span<const std::optional<SamplingFailure>> failures);
  /// Of pile k of group g, whose signs sign_spectrum_ is of.
  void add_correlations(std::size_t g, std::size_t k);
  /// What `value` (group, entry) of a bead is in a layer of a pile, beside its `mean`, or half the difference from the
  /// opposite pile, into spectrum_.
  template <typename Value>
  void find_variation(std::size_t g, std::size_t k, int layer, double mean, Value value);
  /// Of spectrum_, at recorded layer number `row`.
  void add_correlation(BlockSlice& correlation, std::size_t row);

  EnsembleSpec spec_;
  std::size_t columns_;
  std::vector<std::vector<double>> signs_;  ///< of each sample drawn at once
  std::vector<std::vector<double>> loads_;  ///< of each pile drawn at once: the samples, then their opposites
  std::vector<double> sign_spectrum_, spectrum_;
  RealSpectrum fourier_;
  Samplers samplers_;
  std::vector<std::span<const double>> drawn_loads_;  ///< of the piles drawn last
  std::vector<PileGroup> side_, opposite_;            ///< the piles drawn last; opposite_: empty unless asked for
  const std::vector<int>& layers_;
  LayerObservables observables_;
  bool profiles_;
  bool has_H_;
  BlockSlice correlation_, correlation_H_;
};

}  // namespace granuscope
