#pragma once
#include <optional>
#include <string>

#include "experiment/experiment.h"

namespace granuscope {

/// What makes an experiment unusable, and the key whose value should change.
struct ExperimentProblem {
  std::string key;      ///< "lattice.columns"
  std::string message;  ///< what is wrong, why that is a problem, what to do
};

/// The one place where the parameters of an experiment are checked against their ranges and against each other.
/// Returns the first problem in the order of the keys, or nothing if the experiment can be run.
std::optional<ExperimentProblem> find_problem(const Experiment& experiment);

/// Throws InputError with the first problem, if there is one.
void check_experiment(const Experiment& experiment);

/// Memory of the largest data of a run, in bytes: the piles under work and the block sums. Saturates, never overflows.
double estimate_memory(const Experiment& experiment);

/// Expected width W of a response peak in bead diameters at depth z, for making sure that the two peaks stay apart:
/// W^2 = 1 + D z with D = 2.2 mu^2.5, which lies above every D measured on 500 x 200 beads up to mu = 0.5.
double expected_width(double mu, double z);

/// Columns of a ring on which the two peaks of the response are still apart down to `layer`.
double columns_needed(double mu, int layer);

}  // namespace granuscope
