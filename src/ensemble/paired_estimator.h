#pragma once
#include "ensemble/estimator.h"
#include "ensemble/layer_observables.h"

namespace granuscope {

/// The standard procedure: each sample is solved under the uniform load and again with the overload, every bead keeping
/// its random number where it can, and the two piles are subtracted. Sums:
///   "response"                 (w with the overload - w without)/overload, of each bead;
///   "redrawn"                  share of the layer's beads that had to draw another number;
///   "redrawn_below_overload"   the same among the beads with |x| <= z;
///   "least_force"              the smaller of the two forces V that a bead hands down without the overload, over the
///                              layer's beads;
///   "redrawn_force"            the same, summed over the redrawn beads, by the layer's beads;
///   "redrawn_together"         likewise, of how many beads that touch each other the rearrangement of a bead consists;
///   "response_thrust"          sqrt(3) sum(H_R - H_L) with the overload, minus the same without, over the overload:
///                              the thrust ratio of the response itself. Its second moment grows with it, and in piles
///                              of one law it is the thrust ratio of the piles (see analysis/coupling_bias.h);
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
  std::vector<unsigned char> beads_redrawn_;
  std::vector<int> rearranged_;
  const std::vector<int>& layers_;
  LayerObservables observables_;
  BlockSlice redrawn_, redrawn_below_, least_force_, redrawn_force_, redrawn_together_, response_thrust_;
  bool profiles_;
  BlockSlice response_;
};

/// Beads of a layer with |x| <= z.
int beads_below_overload(const Lattice& lattice, int layer);

}  // namespace granuscope
