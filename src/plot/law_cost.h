#pragma once
#include <filesystem>
#include <vector>

#include "analysis/side_measurements.h"
#include "plot/figure.h"

namespace granuscope {

/// Random numbers drawn per bead against the size of square piles, one curve for each law and friction, on a
/// logarithmic axis on which exponential growth is straight.
/// Writes figures/law-cost*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no pile was completed, EnvironmentError if gnuplot is missing or fails.
Figure draw_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder);

}  // namespace granuscope
