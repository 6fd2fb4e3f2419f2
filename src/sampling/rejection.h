#pragma once
#include "model/friction_cone.h"
#include "sampling/sampler.h"

namespace granuscope {

/// The law "rejection": every bead draws uniformly on its interval; on any failure the whole pile is thrown away. Its
/// density is the product of 1/length over the beads' intervals. The acceptance falls exponentially with the number of
/// beads: tiny piles only, the yardstick for the other laws.
class RejectionSampler final : public Sampler {
 public:
  RejectionSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override;

 private:
  void begin_pile(std::uint64_t sample, std::span<const double> load, Pile& pile) const;

  FrictionCone cone_;
  SamplerSpec spec_;
};

}  // namespace granuscope
