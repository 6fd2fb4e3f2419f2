#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure.h"

namespace granuscope {

/// D and c0 - c against mu on logarithmic axes, read as slopes and, where the analysis has them, as the ratios W^2/z
/// and x_p/z at one depth, each with its power law, and the paper's exponents as guides; below, every point over its
/// law. Writes figures/scaling-with-friction*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if no point
/// fits logarithmic axes, EnvironmentError if gnuplot is missing or fails.
Figure plot_scaling_with_friction(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
