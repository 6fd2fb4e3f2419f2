#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ensemble/ensemble_spec.h"
#include "ensemble/force_counts.h"
#include "ensemble/group_fourier.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"
#include "storage/block_sums.h"

namespace granuscope {
/// A quantity that an estimator sums, and its width: the number of columns for a profile, 1 for a number per layer.
struct QuantityShape {
  std::string name;
  int width;
};

/// Measures samples one after another and adds them to the sums of one block: loads in, sums out. Not thread-safe: one
/// for each block. What it adds depends on the ensemble and the sample only.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// Draws what the sample needs and adds it. Where a pile could not be completed, returns where it got stuck and adds
  /// nothing. Every pile's exact identities are asserted.
  virtual std::optional<SamplingFailure> measure(std::uint64_t sample) = 0;

  /// What measure() adds and returns for one sample after the other; `failures` has an entry per sample.
  virtual void measure_samples(std::span<const std::uint64_t> samples,
                               std::span<std::optional<SamplingFailure>> failures) {
    for (std::size_t k = 0; k < samples.size(); ++k) failures[k] = measure(samples[k]);
  }
};

/// What the estimator of the ensemble sums.
std::vector<QuantityShape> quantities_of(const EnsembleSpec& spec);

/// What it reads of its piles.
KeptLayers layers_to_keep(const EnsembleSpec& spec);

/// How many piles an estimator hands a sampler at once.
std::size_t piles_at_once(const EnsembleSpec& spec);

/// What an estimator draws its piles with. Where each sample is two piles under two loads and the law keeps a chain for
/// a load, the two are different samplers.
struct Samplers {
  Sampler &first, &second;
};
bool needs_two_samplers(const EnsembleSpec& spec);

/// Piles that a sample consists of: two where each is drawn under two loads, the pair of `paired` or of opposite signs.
int piles_per_sample(const EnsembleSpec& spec);

/// Beads that so many samples consist of, in all their piles.
std::uint64_t beads_of(const EnsembleSpec& spec, std::uint64_t samples);

/// Memory that one thread needs for drawing the samples of the ensemble, in bytes.
double drawing_memory(const EnsembleSpec& spec);

/// `sums` holds zeros of these shapes; it and the samplers, which are of the ensemble, outlive the estimator.
std::unique_ptr<Estimator> make_estimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);

/// Draws samples that all have one load, as many at once as there are `loads` (all the same), and hands each group to
/// `add` with the failures of its piles.
template <typename Add>
void draw_alike(Sampler& sampler, const std::vector<std::span<const double>>& loads,
                std::span<const std::uint64_t> samples, std::span<std::optional<SamplingFailure>> failures, Add add) {
  for (std::size_t done = 0; done < failures.size(); done += loads.size()) {
    const std::size_t count = std::min(loads.size(), failures.size() - done);
    std::size_t next = done;
    for (const PileGroup& group :
         sampler.draw_groups(samples.subspan(done, count), {loads.data(), count}, failures.subspan(done, count))) {
      add(group, failures.subspan(next, group.piles));
      next += group.piles;
    }
  }
}

/// Where the sums of one quantity in one block of the ensemble stand: entries [layers, width].
class BlockSlice {
 public:
  BlockSlice() = default;
  BlockSlice(BlockSums& sums, const std::string& quantity, int block) {
    QuantitySums& q = sums.quantities.at(quantity);
    width_ = static_cast<std::size_t>(q.width);
    const std::size_t offset = static_cast<std::size_t>(block - sums.first_block) * sums.layers.size() * width_;
    sum_ = q.sum.data() + offset;
    if (q.has_squares()) sum_of_squares_ = q.sum_of_squares.data() + offset;
  }

  /// Adds one sample's value at recorded layer number `row`: of a number per layer,
  void add(std::size_t row, double value) const {
    sum_[row] += value;
    sum_of_squares_[row] += value * value;
  }
  /// or of a profile.
  void add(std::size_t row, std::size_t column, double value) const { sum_[row * width_ + column] += value; }

 private:
  double* sum_ = nullptr;
  double* sum_of_squares_ = nullptr;
  std::size_t width_ = 0;
};

/// What every estimator sums of its piles, layer by layer: "thrust", sqrt(3) sum(H_R - H_L) / sum(w) over the contacts
/// leaving the layer, and "weight_variance", the mean over columns of (w/<w> - 1)^2, <w> known exactly,
/// and what the model counts besides (extra_names), or what tests the flat law (flat_tests).
class LayerObservables {
 public:
  using Failures = std::span<const std::optional<SamplingFailure>>;

  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  LayerObservables(const EnsembleSpec& spec, BlockSums& sums, int block);
  void add(const Pile& pile) const;
  /// Those of the piles that did not fail; `failures` has an entry per pile.
  void add(const PileGroup& group, Failures failures) const;
  /// Of two groups whose piles make one sample each: the means of their observables.
  void add_mean(const PileGroup& one, const PileGroup& other, Failures failures) const;
  /// At recorded layer number l: their means over the layers that lie `offset` plus that layer below the bases.
  void add_means(const PileGroup& group, Failures failures, const std::vector<int>& bases, int offset) const;

 private:
  /// Of each pile of a group in one layer; extras: [pile, extra].
  struct Observed {
    LayerMoments moments;
    std::array<std::array<double, 5>, group_lanes> extras;
  };
  Observed of_layer(const PileGroup& group, int layer) const;
  void add(std::size_t l, const Observed& one, const Observed& other, std::size_t pile) const;

  const std::vector<int>& layers_;
  bool flat_;
  std::vector<BlockSlice> all_;  ///< thrust, variance, extras
};

/// Adds the forces of piles to the sums of one block. Of a model without contacts only its weights.
class ForceCounts {
 public:
  static std::vector<QuantityShape> quantities();
  ForceCounts(const EnsembleSpec& spec, BlockSums& sums, int block);
  /// `failures` has an entry per pile.
  void add(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures) const;

 private:
  double mu_;
  const std::vector<int>& layers_;
  BlockSlice counts_, moments_;
};

/// The paper's procedure: each sample is one pile under the load of the ensemble. Sums "weight", w = V_R + V_L of each
/// bead less the mean of what beads weigh by themselves down to its layer, from which the analysis takes the uniform
/// load away. Under a uniform load there is no response to measure; the numbers per layer alone then give the thrust
/// ratio.
///
/// A pile of n overloads, columns/n apart, is a measurement of n responses, which are laid on each other. With
/// `coupled` the piles of a group are drawn from the same random numbers and loaded on beads s_k that are drawn for
/// each: what they have in common is noise, and its mean over the group is taken off. Instead of "weight" the sums are
/// then
///   "moved_weight"   sum over the n overloads of (w_k(s_k + x) - mean of w over the group, or of all beads),
/// entry i of [columns/n] belonging to x = i - middle. Its expectation is the response convolved with that of layer 0,
/// where w is the load: in a mode m of the ring it is P_m times the sum over piles of |load_k - mean of the loads|^2.
/// The analysis divides by layer 0, and finds the P of a single overload without bias (analysis/mean_response.h).
/// Against piles of their own numbers the variance of c was 0.26, 0.29, 0.40, 0.55, 0.87 at mu = 0.1, 0.15, 0.2, 0.3,
/// 0.4; the numbers per layer see one pile for eight.
class PointEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  PointEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_samples(std::span<const std::uint64_t> samples,
                       std::span<std::optional<SamplingFailure>> failures) override;

 private:
  using Failures = std::span<const std::optional<SamplingFailure>>;

  void choose_loads(std::span<const std::uint64_t> samples);
  void add_weights(const PileGroup& group, Failures failures);
  void add_moved(std::span<const PileGroup> groups, Failures failures);

  EnsembleSpec spec_;
  bool moves_;
  std::vector<std::vector<double>> loads_;  ///< of each pile drawn at once
  std::vector<int> beads_;                  ///< the first overloaded one of each
  std::vector<std::uint64_t> numbers_;      ///< which they are drawn from
  std::vector<double> shared_;              ///< [columns], of one layer
  Sampler& sampler_;
  const std::vector<int>& layers_;
  LayerObservables observables_;
  bool profiles_;
  BlockSlice weight_;
  std::optional<ForceCounts> forces_;  ///< where they are recorded
};

/// The standard procedure: each sample is solved under the uniform load and again with the overload, every bead keeping
/// its random number where it can, and the two piles are subtracted. Sums:
///   "response"                 (w with the overload - w without)/overload, of each bead;
///   "redrawn"                  share of the layer's beads that had to draw another number;
///   "redrawn_below_overload"   the same among the beads with |x| <= z;
///   "least_force"              the smaller of the two forces V that a bead hands down without the overload, over the
///                              layer's beads;
///   "redrawn_force"            the same, summed over the redrawn beads, by the layer's beads;
///   "redrawn_together"         likewise, of how many beads that touch each other the rearrangement of a bead consists;
///   "failing_again"            share of the pile's beads that found no solution when it was solved again; of every
///   layer
///                              the same;
///   "response_thrust"          sqrt(3) sum(H_R - H_L) with the overload, minus the same without, over the overload:
///                              the thrust ratio of the response itself. Its second moment grows with it, and in piles
///                              of one law it is the thrust ratio of the piles (see analysis/scaling.h);
/// the numbers per layer are those of the uniformly loaded pile.
class PairedEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  PairedEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;

 private:
  std::optional<SamplingFailure> draw(std::uint64_t sample);
  void add_redrawn();
  void add_response_thrust();
  void add_response();

  double overload_;
  std::vector<double> uniform_load_, overloaded_;
  Samplers samplers_;
  Pile before_, after_;
  std::uint64_t failed_again_ = 0;  ///< beads of the last pair
  std::vector<unsigned char> beads_redrawn_;
  std::vector<int> rearranged_;
  const std::vector<int>& layers_;
  LayerObservables observables_;
  BlockSlice redrawn_, redrawn_below_, least_force_, redrawn_force_, redrawn_together_, failing_again_,
      response_thrust_;
  bool profiles_;
  BlockSlice response_;
};

/// Beads of a layer with |x| <= z.
int beads_below_overload(const Lattice& lattice, int layer);

/// Of how many beads the rearrangement of each bead consists: redrawn beads that touch belong to one. 0 for a bead that
/// was not redrawn. Both of shape [layers, columns].
void measure_rearrangements(const Lattice& lattice, const std::vector<unsigned char>& redrawn, std::vector<int>& beads);

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
/// in epsilon. The signs may be drawn in runs (MultiplexedEstimator); under the law polytope the eight samples of a
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

/// Which layers of a pile the estimator fluctuation compares, over how many layers, and how many Fourier modes of them.
/// The layer m + reference of a base m is compared with m (the lag 0 of what is recorded), and with it those that lie l
/// layers deeper, for each recorded lag l.
struct FluctuationPlan {
  int reference = 0;        ///< at least the reference lag asked for
  std::vector<int> bases;   ///< ascending, evenly spaced
  std::vector<int> lags;    ///< recorded, ascending, the first is 0
  std::vector<int> modes;   ///< of each lag: modes 1 .. modes[i] are compared
  std::vector<int> layers;  ///< all that are needed, ascending
  int layers_needed = 0;    ///< of a lattice on which one base fits
};

FluctuationPlan fluctuation_plan(const EnsembleSpec& spec);

/// No load at all: the fluctuations of uniformly loaded piles travel down as a load does. With the Fourier modes
///   X_n(k) = sum_x exp(-i k x) (w - 1, H)
/// of a layer n, x the true positions of its beads, a lag l takes a base m to
///   C_l(k) = <X_{m+l} X_m^+>/columns,
/// averaged over bases and mirror images, and the mean response over l layers follows from C_{r+l} C_r^-1
/// (analysis/dispersion.h). The reference lag r lets die out what single contacts do to single beads;
/// the recorded lag 0 is C_r itself. Onsager's regression, with a reference. In a scalar model w is alone.
///
/// Sums:
///   "propagation"   [lag, 2 columns]: the four parts (correlation_parts) of C_{r+l} of the modes 1, 2, ..., each the
///                   mean over the bases; 0 from the first mode on that carries no weight at the lag, and
///                   all but w w' in a scalar model;
/// and the LayerObservables of the layers m + r + l, as means over the bases.
class FluctuationEstimator final : public Estimator {
 public:
  static std::vector<QuantityShape> quantities(const EnsembleSpec& spec);
  static KeptLayers layers_to_keep(const EnsembleSpec& spec);
  static double memory(const EnsembleSpec& spec);  ///< of one, in bytes
  FluctuationEstimator(const EnsembleSpec& spec, Samplers samplers, BlockSums& sums, int block);
  std::optional<SamplingFailure> measure(std::uint64_t sample) override;
  void measure_samples(std::span<const std::uint64_t> samples,
                       std::span<std::optional<SamplingFailure>> failures) override;

 private:
  using Failures = std::span<const std::optional<SamplingFailure>>;

  void add(const PileGroup& group, Failures failures);
  void transform_layer(const PileGroup& group, Failures failures, int layer, std::size_t place);
  void compare_layers(std::size_t first_base, std::size_t end_base);
  void add_sums(std::size_t piles, Failures failures);

  FluctuationPlan plan_;
  std::size_t columns_, modes_, room_;  ///< room for that many layers at once
  std::size_t parts_;                   ///< of correlation_parts; what rounding makes of the absent H is not added
  RowGeometry rows_;
  std::vector<double> load_;
  std::vector<std::span<const double>> loads_;  ///< of each pile drawn at once
  Sampler& sampler_;
  GroupFourier fourier_;
  AlignedArray<double> re_, im_;                    ///< [columns, 8] a layer before and after its transform
  AlignedArray<double> fields_;                     ///< [modes, room, 4, 8]
  AlignedArray<double> correlations_;               ///< [modes, lags, 4, 8]
  std::array<std::vector<PhaseFactor>, 2> phases_;  ///< of each mode: 1, and exp(-i k/2) where beads lie half a bead on
  std::vector<int> place_;                          ///< [layers of the lattice] of those in fields_; -1: none
  std::vector<std::vector<int>> pairs_;             ///< of each lag, for add_correlations
  LayerObservables observables_;
  bool profiles_;
  BlockSlice propagation_;
};

}  // namespace granuscope
