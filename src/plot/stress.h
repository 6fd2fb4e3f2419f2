#pragma once
#include <filesystem>
#include <vector>

#include "analysis/side_measurements.h"
#include "plot/figure.h"

namespace granuscope {

/// The worst residual of ever deeper layers of the deep piles of a stress test, one curve for each friction.
/// Writes figures/stress*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no deep pile was solved, EnvironmentError if gnuplot is missing or fails.
Figure draw_stress(const std::vector<StressTrial>& trials, const std::filesystem::path& run_folder);

}  // namespace granuscope
