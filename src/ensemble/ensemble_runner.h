#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ensemble/response_spec.h"
#include "model/lattice.h"
#include "sampling/sampler_spec.h"
#include "storage/ensemble_file.h"
#include "support/progress.h"

namespace granuscope {

/// One ensemble: piles of one law at one friction coefficient under one load, and what is measured on them.
struct EnsembleSpec {
  SamplerSpec sampler;
  LatticeSpec lattice;
  Load load = Load::point;
  double overload = 1.0;         ///< extra force on the middle top bead (point load only)
  std::uint64_t samples = 3456;  ///< numbers 0 .. samples-1 of the seed
  int blocks = 32;               ///< each of whole groups of eight samples (the last group may be incomplete)
  std::vector<int> layers;       ///< recorded layers, ascending; empty: all
  bool record_profiles = true;   ///< record "weight" [layers, columns] beside "thrust" and "weight_variance" [layers]
};

/// Fewest blocks from which a standard error is taken.
inline constexpr int min_blocks = 8;
/// Consecutive samples that share the order in which their layers are solved, and therefore the block.
inline constexpr std::uint64_t group_size = 8;

/// Throws InputError if the spec is out of range (fewer than one group per block, a layer outside the lattice, ...).
void validate(const EnsembleSpec& spec);

/// Canonical text of everything the ensemble's numbers depend on. Equal text, equal numbers.
std::string configuration_text(const EnsembleSpec& spec);

/// The load on every top bead, shape [columns].
std::vector<double> top_load(const EnsembleSpec& spec);

/// The command that draws one pile of the ensemble again.
std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample);

/// Draws all samples on `threads` threads (0: as many as the machine has) and returns their block sums: the same bytes
/// for every number of threads. Every pile's exact identities are asserted. A pile that cannot be completed is listed
/// in `failed` and enters no sum. Throws Interrupted if the program is asked to stop. `progress` may be null; it is
/// advanced by one per sample.
EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress);

}  // namespace granuscope
