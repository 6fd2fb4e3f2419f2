#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "storage/block_sums.h"

namespace granuscope {

/// A pile that could not be completed within the stated effort.
struct FailedSample {
  std::uint64_t sample = 0;
  int layer = 0;       ///< the layer where the effort ran out
  std::string replay;  ///< the command that meets the same failure again
};

/// What the sampler did over an ensemble, counted, never timed. Plain counts: merging is adding.
struct SamplerCounts {
  std::uint64_t beads = 0;           ///< beads x samples that entered
  std::uint64_t uniforms = 0;        ///< uniform numbers drawn, abandoned tries included
  std::uint64_t tries = 0;           ///< piles begun (differs from samples for the rejection law)
  std::uint64_t mended_by_pair = 0;  ///< beads whose final value came from the pair rule
  std::uint64_t mended_by_arc = 0;   ///< ... from an arc of 4 or more parents
  std::uint64_t mended_by_ring = 0;  ///< ... from the whole ring
  std::uint64_t climbed = 0;         ///< beads that had to climb at least once
  std::uint64_t pairs = 0, arcs = 0, rings = 0, climbs = 0;  ///< how often each rule was entered and applied
  std::uint64_t rounded = 0;                                 ///< beads put onto a band's end by the 64-ulp rule
  std::uint64_t redrawn_layers = 0;  ///< eloy-clement: layers drawn, apart from the first time each
  std::uint64_t moves = 0;           ///< polytope: moves proposed, burn-in included
  std::uint64_t accepted_moves = 0;  ///< polytope: moves made
  std::uint64_t chains = 0;          ///< polytope: chains begun
  std::uint64_t burn_in = 0;         ///< polytope: sweeps before a chain's first pile, summed over the chains
  std::uint64_t thinning = 0;        ///< polytope: sweeps from one of its piles to the next, summed over the chains

  SamplerCounts& operator+=(const SamplerCounts& other);
};

/// An ensemble as stored: its sums, what the sampler did, which piles failed, and what it is an ensemble of.
struct EnsembleRecord {
  std::string configuration;      ///< resolved, canonical text; two ensembles may be merged only if it is equal
  std::string configuration_key;  ///< cache_key(configuration)
  std::string sampling_version;   ///< changes whenever the samples change
  BlockSums sums;
  SamplerCounts counts;
  std::vector<FailedSample> failed;
};

/// Writes /<quantity>/sum and /sum_of_squares [blocks, layers, width], /count [blocks], /layers; attributes as above.
/// The same record gives the same bytes. Throws EnvironmentError.
void write_ensemble(const std::filesystem::path& file, const EnsembleRecord& record);

/// Throws InputError for a missing, damaged or foreign file, wrong shapes, or numbers that are not finite or not those
/// that were written (attribute sums_key).
EnsembleRecord read_ensemble(const std::filesystem::path& file);

/// The configuration alone, without reading the sums. Throws InputError as read_ensemble does for what it touches.
std::string read_ensemble_configuration(const std::filesystem::path& file);

}  // namespace granuscope
