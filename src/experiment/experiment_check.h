#pragma once
#include "experiment/experiment.h"

namespace granuscope {

/// The one place where the parameters of an experiment are checked against their ranges and against each other.
/// Throws InputError: what is wrong, why that is a problem, what to do.
void check_experiment(const Experiment& experiment);

}  // namespace granuscope
