#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure_captions.h"

namespace granuscope {
/// D and c0 - c against mu on logarithmic axes, read as slopes and, where the analysis has them, as the ratios W^2/z
/// and x_p/z at one depth, each with its power law, and the paper's exponents as guides; below, every point over its
/// law. Writes figures/scaling-with-friction*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if no point
/// fits logarithmic axes, EnvironmentError if gnuplot is missing or fails.
Figure plot_scaling_with_friction(const Analysis& analysis, const std::filesystem::path& run_folder);

/// The paper's Fig. 4: c against D, one point for each friction coefficient; beside it c0 - c against D on
/// logarithmic axes with the fitted power law, the paper's exponent, and each point over the law.
/// Writes figures/propagation-against-diffusion*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both c and D, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder);

/// The slope c of the peaks and the speed c_thrust that follows from the thrust ratio against mu, and their difference,
/// in bead diameters per bead diameter and in standard errors.
/// Writes figures/propagation-and-thrust*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_and_thrust(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
