#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure.h"

namespace granuscope {

/// The thrust ratio at small friction, from narrow piles deep enough for the fluctuations of the forces to saturate:
/// how the variance of the weights saturates with depth, and tan30 - c_thrust against mu beside that of the main
/// ensembles. Writes figures/small-friction*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if nothing
/// was measured, EnvironmentError if gnuplot is missing or fails.
Figure draw_small_friction(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
