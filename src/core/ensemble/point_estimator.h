#pragma once
#include <vector>

#include "ensemble/estimator.h"
#include "ensemble/force_counts.h"
#include "model/lattice.h"

namespace granuscope {
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

}  // namespace granuscope
