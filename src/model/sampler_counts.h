#pragma once
#include <array>
#include <cstdint>
#include <utility>

namespace granuscope {

/// What the sampler did over an ensemble, counted, never timed. Plain counts: merging is adding, which is +=.
struct SamplerCounts {
  std::uint64_t beads = 0;             ///< beads x samples that entered
  std::uint64_t uniforms = 0;          ///< uniform numbers drawn, abandoned tries included
  std::uint64_t tries = 0;             ///< piles begun (differs from samples for the rejection law)
  std::uint64_t repaired_by_pair = 0;  ///< beads whose final value came from the pair rule
  std::uint64_t repaired_by_arc = 0;   ///< ... from an arc of 4 or more parents
  std::uint64_t repaired_by_ring = 0;  ///< ... from the whole ring
  std::uint64_t backtracked = 0;       ///< beads that had to backtrack at least once
  std::uint64_t pairs = 0, arcs = 0, rings = 0, backtracks = 0;  ///< how often each rule was entered and applied
  std::uint64_t rounded = 0;                                     ///< beads put onto a band's end by the 64-ulp rule
  std::uint64_t redrawn_layers = 0;  ///< eloy-clement: layers drawn, apart from the first time each
  std::uint64_t moves = 0;           ///< polytope: moves proposed, burn-in included
  std::uint64_t accepted_moves = 0;  ///< polytope: moves made
  std::uint64_t chains = 0;          ///< polytope: chains begun
  std::uint64_t burn_in = 0;         ///< polytope: sweeps before a chain's first pile, summed over the chains
  std::uint64_t thinning = 0;        ///< polytope: sweeps from one of its piles to the next, summed over the chains

  SamplerCounts& operator+=(const SamplerCounts& other);
};

/// Every counter by its name, in the order in which they are stored.
using SamplerCounter = std::pair<const char*, std::uint64_t SamplerCounts::*>;
inline constexpr std::array<SamplerCounter, 18> sampler_counters = {
    SamplerCounter{"beads", &SamplerCounts::beads},
    {"uniforms", &SamplerCounts::uniforms},
    {"tries", &SamplerCounts::tries},
    {"repaired_by_pair", &SamplerCounts::repaired_by_pair},
    {"repaired_by_arc", &SamplerCounts::repaired_by_arc},
    {"repaired_by_ring", &SamplerCounts::repaired_by_ring},
    {"backtracked", &SamplerCounts::backtracked},
    {"pairs", &SamplerCounts::pairs},
    {"arcs", &SamplerCounts::arcs},
    {"rings", &SamplerCounts::rings},
    {"backtracks", &SamplerCounts::backtracks},
    {"rounded", &SamplerCounts::rounded},
    {"redrawn_layers", &SamplerCounts::redrawn_layers},
    {"moves", &SamplerCounts::moves},
    {"accepted_moves", &SamplerCounts::accepted_moves},
    {"chains", &SamplerCounts::chains},
    {"burn_in", &SamplerCounts::burn_in},
    {"thinning", &SamplerCounts::thinning}};
static_assert(sizeof(SamplerCounts) == sampler_counters.size() * sizeof(std::uint64_t),
              "a counter is missing from the list");

inline SamplerCounts& SamplerCounts::operator+=(const SamplerCounts& other) {
  for (const auto& [name, count] : sampler_counters) this->*count += other.*count;
  return *this;
}

}  // namespace granuscope
