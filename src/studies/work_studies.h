#pragma once
#include <filesystem>

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

/// Statistical error of c and D against the beads drawn, a curve for each estimator, on logarithmic axes.
/// Behind its measured points each curve goes on with the total error, sqrt(scatter^2 + shift^2) about the linear
/// response, where its shift is known to differ from zero by three standard errors. Beads drawn stand for the time, for
/// a figure is to be the same bytes again; what a bead takes is among the timings. Writes
/// figures/error-against-time*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if no curve has a point,
/// EnvironmentError if gnuplot is missing or fails.
Figure plot_error_against_time(const std::vector<ErrorCurve>& curves, const std::filesystem::path& run_folder);

/// The error of each estimator against the beads that it draws, on ensembles of their own.
std::unique_ptr<Study> error_against_time_study();

}  // namespace granuscope
