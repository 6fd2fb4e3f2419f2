#pragma once
#include "experiment/experiment.h"
#include "support/key.h"

namespace granuscope {

/// The one place where the parameters of an experiment are checked against their ranges and against each other.
/// Returns the first problem in the order of the keys, or nothing if the experiment can be run.
Problem find_problem(const Experiment& experiment);

/// Throws InputError with the first problem, if there is one.
void check_experiment(const Experiment& experiment);

/// Memory of the largest data of a run, in bytes: the piles under work and the block sums. Saturates, never overflows.
double estimate_memory(const Experiment& experiment);

/// Expected width W of a response peak in bead diameters at depth z, for making sure that the two peaks stay apart:
/// W^2 = 1 + D z with D = 2.2 mu^2.5, which lies above every D measured on 500 x 200 beads up to mu = 0.5.
double expected_width(double mu, double z);

/// Expected speed x_p/z of a peak, for the same purpose: tan 30 degrees, which no peak exceeds up to mu = 1, and
/// 0.8 (mu - 1)^2 more beyond. Lies above what 800 x 200 beads show: 0.61 at mu = 1.3, 0.68 at 1.5, 0.89 at 1.7.
double expected_speed(double mu);

/// Columns of a ring on which the two peaks of the response are still apart down to `layer`.
double columns_needed(double mu, int layer);

/// The tables [figures.*] that bring ensembles of their own.
Problem find_side_problem(const Experiment& e);

}  // namespace granuscope
