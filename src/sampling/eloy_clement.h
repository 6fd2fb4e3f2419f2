#pragma once
#include <vector>

#include "model/friction_cone.h"
#include "sampling/sampler.h"

namespace granuscope {

/// The law "eloy-clement" (Eloy and Clément, J. Phys. I 7, 1541, 1997, as the paper describes it): layers are drawn
/// from top to bottom, every bead uniformly on its interval; where a layer has a bead without solution, the n layers
/// above it are drawn again completely, n growing in proportion to the number of failures met in this layer since it
/// was last completed. The choices that shape the law:
///
///  1. a failure is an attempt at a layer that does not complete, however many of its beads have no solution;
///  2. n is the number of failures divided by failures_per_layer, rounded up;
///  3. layers on the way down again count their own failures, from zero.
///
/// The number of attempts at one layer grows exponentially with the number of columns.
class EloyClementSampler final : public Sampler {
 public:
  /// Failures of a layer for each further layer above it that is drawn again.
  static constexpr int failures_per_layer = 8;

  EloyClementSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;

 private:
  FrictionCone cone_;
  SamplerSpec spec_;
  std::uint64_t max_solutions_;
  std::vector<int> failures_;            ///< per layer, since it was last completed
  std::vector<std::uint32_t> attempts_;  ///< per layer
};

}  // namespace granuscope
