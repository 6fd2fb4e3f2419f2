#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure_captions.h"

namespace granuscope {
/// D against mu on logarithmic axes, read as slopes and, where the analysis has it, as the ratio W^2/z at one depth,
/// each with its power law, and the slope of the paper's exponent; below, every point over its law. How c0 - c grows
/// with mu and with D is shown by plot_main_finding alone. Writes figures/scaling-with-friction*.csv, .gp, .svg and
/// .pdf below `run_folder`. Throws InputError if no point fits logarithmic axes, EnvironmentError if gnuplot is missing
/// or fails.
Figure plot_scaling_with_friction(const Analysis& analysis, const std::filesystem::path& run_folder);

/// Results without a point on logarithmic axes of D, and of c0 - c where `of_slowing`, each with the reason.
std::vector<LeftOut> points_left_out(const std::vector<Transport>& results, bool of_slowing);

/// The paper's Fig. 4: c against D, one point for each friction coefficient, with the law fitted to c0 - c; below, c0 -
/// c of every point over it. Writes figures/propagation-against-diffusion*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both c and D, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder);

/// The slope c of the peaks and the speed c_thrust that follows from the thrust ratio against mu, and their difference,
/// in bead diameters per bead diameter and in standard errors.
/// Writes figures/propagation-and-thrust*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_and_thrust(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
