#include "sampling/polytope.h"

#include <algorithm>

#include "sampling/chain_plan.h"
#include "sampling/granusolve.h"
#include "support/interruption.h"

namespace granuscope {

PolytopeSampler::PolytopeSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      spec_(spec),
      measured_(spec),
      start_(std::make_unique<GranusolveSampler>(start_of_chain(spec), lattice)),
      chain_(FrictionCone(spec.mu), lattice, spec.lambda) {}

std::optional<SamplingFailure> PolytopeSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  const bool same_load = std::equal(load.begin(), load.end(), load_.begin(), load_.end());
  if (!same_load || chain_group_ != sample / group || in_group_ > sample % group) {
    if (!same_load) measured_ = with_measured_chain(spec_, lattice_, load);
    load_.assign(load.begin(), load.end());
    if (auto failure = begin_chain(sample, load)) return failure;
  }
  for (; in_group_ < sample % group; ++in_group_) {
    run(measured_.thinning);
    chain_.store(pile);  // at every sample, asked for or not, so that the chain does not depend on it
  }
  chain_.store(pile);
  pile.law = name_of(Law::polytope);
  pile.sample = sample;
  ++counts_.tries;
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

std::optional<SamplingFailure> PolytopeSampler::begin_chain(std::uint64_t sample, std::span<const double> load) {
  chain_group_.reset();
  const std::uint64_t first = sample - sample % group;
  Pile start(lattice_);
  const std::uint64_t uniforms = start_->counts().uniforms;
  const auto failure = start_->draw(first, load, start);
  counts_.uniforms += start_->counts().uniforms - uniforms;
  if (failure) return failure;
  ++counts_.chains;
  counts_.burn_in += measured_.burn_in;
  counts_.thinning += measured_.thinning;
  chain_.set(start);
  key_ = RandomKey(spec_.seed, first);
  sweeps_ = 0;
  chain_.set_lambda(0);
  run(flat_sweeps);
  chain_.set_lambda(spec_.lambda);
  run(measured_.burn_in);
  Pile unused(lattice_);
  chain_.store(unused);
  chain_group_ = sample / group;
  in_group_ = 0;
  return std::nullopt;
}

void PolytopeSampler::run(std::uint64_t sweeps) {
  const std::uint64_t moves = chain_.moves(), accepted = chain_.accepted_moves();
  for (std::uint64_t k = 0; k < sweeps; ++k) {
    if (sweeps_ % 64 == 0) throw_if_interrupted();
    ++sweeps_;
    chain_.sweep([this](int layer, int bead) { return key_.chain_move(layer, bead, sweeps_); });
  }
  counts_.moves += chain_.moves() - moves;
  counts_.accepted_moves += chain_.accepted_moves() - accepted;
  counts_.uniforms += 2 * (chain_.moves() - moves);
}

}  // namespace granuscope
