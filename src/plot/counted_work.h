#pragma once
#include <filesystem>
#include <vector>

#include "analysis/side_measurements.h"
#include "plot/figure.h"

namespace granuscope {

/// Random numbers drawn per bead against the number of beads of a pile, one curve for each friction coefficient: flat
/// if the time to draw a pile is linear in its size.
/// Writes figures/counted-work*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if nothing was counted, EnvironmentError if gnuplot is missing or fails.
Figure draw_counted_work(const std::vector<CountedWork>& work, const std::filesystem::path& run_folder);

}  // namespace granuscope
