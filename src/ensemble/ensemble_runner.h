#pragma once
#include "ensemble/ensemble_spec.h"
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

}  // namespace granuscope
