#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "ensemble/response_spec.h"
#include "model/lattice.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// One ensemble: piles of one law at one friction coefficient, how they are loaded, and what is measured on them.
struct EnsembleSpec {
  SamplerSpec sampler;
  LatticeSpec lattice;
  ResponseSpec response;
  Load load = Load::point;      ///< of the estimator point; under a uniform load it has no response to measure
  std::vector<int> layers;      ///< recorded layers, ascending; empty: all
  bool record_profiles = true;  ///< record the response [layers, columns] beside the numbers per layer
  /// Of the estimator multiplexed: record the response of H beside that of w. Layers whose depths differ by factors
  /// tell twice as much with it; those of a window hand their noise on to each other with the response, and tell c and
  /// D as well without.
  bool record_H = false;
};

/// Why the estimator cannot measure beads that have a weight of their own, if it cannot.
Problem find_gravity_problem(const SamplerSpec& sampler, const ResponseSpec& response);

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
  std::uint64_t size() const { return end - first; }
};

/// The samples of the group number `group`, of which the last one may be incomplete. Group g belongs to block g mod
/// blocks: blocks differ by at most one group, and an ensemble of fewer whole groups is the beginning of one of more,
/// with the same samples in the same blocks.
SampleRange samples_of(const EnsembleSpec& spec, std::uint64_t group);

/// Groups of the ensemble, an incomplete one included.
std::uint64_t groups_of(const EnsembleSpec& spec);

/// The first group of a block from the group `from` on.
std::uint64_t group_of_block(const EnsembleSpec& spec, int block, std::uint64_t from);

/// Samples of a block that are in the first `groups` groups of the ensemble.
std::uint64_t samples_in_block(const EnsembleSpec& spec, int block, std::uint64_t groups);

/// The load on every top bead of the estimator point, shape [columns].
std::vector<double> top_load(const EnsembleSpec& spec);

/// The command that draws one pile of the ensemble again.
std::string replay_command(const EnsembleSpec& spec, std::uint64_t sample);

}  // namespace granuscope
