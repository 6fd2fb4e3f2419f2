#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/measured_ensemble.h"
#include "analysis/results.h"
#include "studies/study.h"

namespace granuscope {

/// The standard procedure (estimator "paired") at one friction coefficient: which beads had to draw another number when
/// the overload was added.
struct RedrawnBeads {
  EnsembleSpec spec;
  std::uint64_t samples = 0;  ///< pairs of piles that entered
  std::uint64_t failed = 0;   ///< pairs that could not be completed
  Estimate whole_pile;        ///< share of all beads of the usable layers
  Estimate below_overload;    ///< share of those with |x| <= z
  Estimate force;             ///< before the overload acts: mean of the smaller force that these beads hand down
  Estimate relative_force;    ///< that over the mean of all beads at the same depths
  Estimate together;          ///< beads of the rearrangement that a redrawn bead belongs to, its mean over these beads
};

/// The shares of beads that had to draw another number, over the usable layers (0 .. layers - 21) of an ensemble of the
/// estimator "paired", with standard errors by the jackknife over its blocks. All usable layers must be recorded;
/// throws InputError otherwise. Unknown, with the reason, where a block holds no completed pair.
RedrawnBeads measure_redrawn_beads(const MeasuredEnsemble& ensemble);

/// The claim about the share of beads that draw again, "of the order of" two numbers: the share of all beads of the
/// usable layers must lie within a factor of 2 of each, by three standard errors; not reproduced if one lies outside by
/// as much, not tested if one was not measured. The number shown is the one farther off.
Claim judge_redraw_share(const std::vector<RedrawnBeads>& measured);

/// The claim that rearrangements are local and preferably concern small forces, at every friction coefficient measured:
/// the relative force lies below 1 by three standard errors, and a redrawn bead belongs to a rearrangement of at most
/// `most_together` beads on average, by as much.
Claim judge_rearrangements(const std::vector<RedrawnBeads>& measured, double most_together);

/// The standard procedure beside the paper's own: how many beads draw again. On the experiment's lattice, with its
/// overload.
std::unique_ptr<Study> redrawn_beads_study();

}  // namespace granuscope
