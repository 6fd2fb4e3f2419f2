#pragma once
#include <filesystem>
#include <vector>

#include "analysis/side_measurements.h"
#include "plot/figure.h"

namespace granuscope {

/// The thrust ratio by layer under each law, with the mean of each law and what drawing took in the legend.
/// Writes figures/law-comparison*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if nothing was measured, EnvironmentError if gnuplot is missing or fails.
Figure draw_law_comparison(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder);

}  // namespace granuscope
