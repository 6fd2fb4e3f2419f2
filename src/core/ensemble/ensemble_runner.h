#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "ensemble/ensemble_spec.h"
#include "model/pile.h"
#include "sampling/sampler.h"
#include "storage/ensemble_file.h"
#include "support/progress.h"

namespace granuscope {
/// Draws all samples on `threads` threads (0: as many as the machine has) and returns their block sums: the same bytes
/// for every number of threads. Every pile's exact identities are asserted. A pile that cannot be completed is listed
/// in `failed` and enters no sum. Throws Interrupted if the program is asked to stop. `progress` may be null; it is
/// advanced by one per sample.
EnsembleRecord run_ensemble(const EnsembleSpec& spec, int threads, Progress* progress);

/// The same piece by piece. First the ensemble without any sample;
EnsembleRecord begin_ensemble(const EnsembleSpec& spec);
/// or only some of its blocks, which come out as those of the whole;
EnsembleRecord begin_blocks(const EnsembleSpec& spec, int first, int blocks);

/// Holds what a file says of its sums against what the spec makes of them: blocks, layers, quantities, numbers of
/// samples. Throws InputError naming the file if it is something else.
void require_shape(const std::filesystem::path& file, const EnsembleRecord& record, const EnsembleSpec& spec, int first,
                   int blocks);
/// then those of the groups from .. to-1 (ensemble_spec.h) that its blocks hold are added to it. Each group once and in
/// order, in pieces of whatever size, up to groups_of(spec): the bytes of run_ensemble. What an exception leaves is of
/// no use.
void add_groups(const EnsembleSpec& spec, std::uint64_t from, std::uint64_t to, EnsembleRecord& record, int threads,
                Progress* progress);
/// with what the sampler has to measure first (below), so that many pieces do it once.
void add_groups(const EnsembleSpec& spec, const SamplerSpec& measured, std::uint64_t from, std::uint64_t to,
                EnsembleRecord& record, int threads, Progress* progress);

/// The sampler of the ensemble, its burn-in and thinning measured if the law has any and they are not stated: may take
/// minutes.
SamplerSpec measured_sampler(const EnsembleSpec& spec);

/// Calls body(0) .. body(count - 1), each once, on `threads` threads (0: as many as the machine has). Which thread
/// takes which index is left open: bodies must not depend on it. The first exception of a body is passed on after the
/// others have stopped. Within a body one thread does it all.
void for_each_index(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Adds the sums, counts and failures of `more` to `to`, block by block: afterwards each block holds the samples of
/// both. Throws InputError unless both have the same layers, blocks and quantities.
void merge_into(EnsembleRecord& to, const EnsembleRecord& more);

/// Draws what the ensemble's estimator draws for one sample, in the same order and from the same numbers, and leaves
/// the last pile of it: the loaded one (point), the one solved again with the overload (paired), the one under the
/// sample's signs or, of an opposite pair, under the reversed ones (multiplexed). Or where it got stuck.
std::optional<SamplingFailure> replay(const EnsembleSpec& spec, std::uint64_t sample, Pile& pile);

/// Processor time for drawing an ensemble, and adding it up, on one core of this machine.
struct TimeEstimate {
  double once = 0;        ///< seconds before the first pile, which more threads do not shorten: the pilot of a chain
  double per_sample = 0;  ///< seconds
  bool at_least = false;  ///< the trial ended before it could tell how much more it is

  double on_threads(std::uint64_t samples, int threads) const {
    return once + per_sample * static_cast<double>(samples) / threads;
  }
};

/// Draws the first piles of the ensemble and keeps nothing, or runs the beginning of the pilot of its chains: what a
/// pile costs depends on the law, the friction, the size, the estimator and the machine, beyond any rule of thumb.
/// Takes at most about so many seconds of processor time, beside the first few piles. Of large piles of the law
/// granusolve fewer layers and columns are drawn, since its work is linear in both. Piles of laws that draw again
/// and again are given up after fewer tries than in the ensemble, and the mean is that of tries which forget the ones
/// before.
TimeEstimate estimate_time(const EnsembleSpec& spec, double seconds);

}  // namespace granuscope
