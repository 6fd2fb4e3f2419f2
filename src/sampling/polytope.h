#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sampling/polytope_chain.h"
#include "sampling/sampler.h"

namespace granuscope {

/// The law "polytope": a Markov chain on the set of admissible piles, see polytope_chain.h. The choices that shape it:
///
///  1. every group of eight consecutive samples has a chain of its own, independent of all others: it starts from the
///     pile that the law "granusolve" gives the group's first sample;
///  2. flat_sweeps sweeps at lambda = 0 lead away from corners where a length vanishes, then burn_in sweeps follow;
///  3. the group's samples are the piles after burn_in, burn_in + thinning, ... sweeps; they are correlated among each
///     other, which is why statistical blocks consist of whole groups.
///
/// A sample can thus be drawn alone at the cost of at most burn_in + 7 thinning sweeps. Samples asked for in order cost
/// burn_in / 8 + thinning sweeps each: the chain is kept from one to the next, which changes no byte.
class PolytopeSampler final : public Sampler {
 public:
  PolytopeSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;

 private:
  static constexpr std::uint64_t group = 8;

  std::optional<SamplingFailure> begin_chain(std::uint64_t sample, std::span<const double> load);
  void run(std::uint64_t sweeps);

  SamplerSpec spec_;
  SamplerSpec measured_;            ///< spec_ with burn_in and thinning for load_
  std::unique_ptr<Sampler> start_;  ///< draws the piles that chains start from
  PolytopeChain chain_;

  // Where the chain stands.
  std::vector<double> load_;
  std::optional<std::uint64_t> chain_group_;
  std::uint64_t in_group_ = 0;  ///< number of the group's sample it has reached
  RandomKey key_{0, 0};
  std::uint32_t sweeps_ = 0;
};

}  // namespace granuscope
