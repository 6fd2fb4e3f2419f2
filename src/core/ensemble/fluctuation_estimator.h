#pragma once
#include <array>
#include <vector>

#include "ensemble/ensemble_spec.h"
#include "ensemble/estimator.h"
#include "ensemble/group_fourier.h"

namespace granuscope {
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
