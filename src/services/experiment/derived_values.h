#pragma once
#include <set>
#include <string>

#include "experiment/experiment.h"

namespace granuscope {
/// Gives each value that `written` (paths of keys) does not hold what follows from those that it holds: windows, depths
/// and widths from the lattice and the friction, the lattice from windows, estimator and law, samples from blocks, what
/// figures and pictures show from the friction. The defaults of the specs come out where nothing is written. What is
/// written makes sense by itself, in its ranges; whether it makes sense together is find_problems' to tell.
void derive_values(Experiment& experiment, const std::set<std::string>& written);

}  // namespace granuscope
