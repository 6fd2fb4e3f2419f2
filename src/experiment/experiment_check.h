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

}  // namespace granuscope
