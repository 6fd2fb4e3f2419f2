#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "analysis/results.h"
#include "analysis/transport.h"
#include "studies/study.h"

namespace granuscope {

/// What it took to draw piles of one size at one friction coefficient: counted, never timed.
struct CountedWork {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< piles that were completed
  std::uint64_t failed = 0;   ///< piles that were not
  double draws_per_bead = 0;  ///< uniform numbers per bead, abandoned tries included
  double repaired_per_bead = 0;
  double backtracked_per_bead = 0;
};

/// What it took to draw an ensemble, from its counts.
CountedWork counted_work(const MeasuredEnsemble& ensemble);

/// The claim that the work is linear in the number of beads. Decided by counted work, never by a clock: the power p
/// with which the number of draws grows with the number of beads must lie within three tolerances of 1 at every mu
/// counted, and every pile of 10^6 beads or more at a mu of at least ClaimSpec::highest_mu must have been completed.
/// Not reproduced if a power lies outside or such a pile failed; else not tested if no power or no such pile is
/// there.
Claim judge_linear_time(const std::vector<CountedWork>& measured, const ClaimSpec& spec);

/// The work of drawing piles of several sizes.
std::unique_ptr<Study> counted_work_study();

}  // namespace granuscope
