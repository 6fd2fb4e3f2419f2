#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure.h"

namespace granuscope {

/// The slope c of the peaks and the speed c_thrust that follows from the thrust ratio against mu, and their difference,
/// in bead diameters per bead diameter and in standard errors.
/// Writes figures/propagation-and-thrust*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_and_thrust(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
