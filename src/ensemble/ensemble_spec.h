#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ensemble/response_spec.h"
#include "model/lattice.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// Which samples make up a block.
enum class BlockLayout {
  runs,        ///< each block a run of consecutive groups; it depends on the number of samples
  interleaved  ///< group g belongs to block g mod blocks, so that more samples extend each block: an ensemble of fewer
               ///< samples is the beginning of one of more, and both have the same samples in the same blocks
};

/// One ensemble: piles of one law at one friction coefficient, how they are loaded, and what is measured on them.
struct EnsembleSpec {
  SamplerSpec sampler;
  LatticeSpec lattice;
  ResponseSpec response;
  Load load = Load::point;  ///< of the estimator point; under a uniform load it has no response to measure
  std::vector<int> layers;  ///< recorded layers, ascending; empty: all
  BlockLayout layout = BlockLayout::runs;
  bool record_profiles = true;  ///< record the response [layers, columns] beside the numbers per layer
};

/// What is wrong with the sampler, the lattice or the response, or with what they are together (a layer outside the
/// lattice, ...).
Problem find_problem(const EnsembleSpec& spec);
/// Throws InputError with it.
void validate(const EnsembleSpec& spec);

/// Canonical text of everything the ensemble's numbers depend on. Equal text, equal numbers.
std::string configuration_text(const EnsembleSpec& spec);

/// The layers whose sums are kept, ascending: those asked for, or all; multiplexed always keeps layer 0, which holds
/// the spectrum of its loads. Of the estimator fluctuation they are lags, of which it always keeps 0.
std::vector<int> recorded_layers(const EnsembleSpec& spec);

/// Samples first .. end-1 of one group.
struct SampleRange {
  std::uint64_t first = 0, end = 0;
  bool empty() const { return first >= end; }
};

/// The samples of the group number `group` of a block, counted from 0 within the block; empty beyond its last one.
/// Blocks hold whole groups and differ by at most one group.
SampleRange samples_of(const EnsembleSpec& spec, int block, std::uint64_t group);

/// Groups of the largest block.
std::uint64_t groups_per_block(const EnsembleSpec& spec);

/// The load on every top bead of the estimator point, shape [columns].
std::vector<double> top_load(const EnsembleSpec& spec);

/// The command that draws one pile of the ensemble again.
std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample);

}  // namespace granuscope
