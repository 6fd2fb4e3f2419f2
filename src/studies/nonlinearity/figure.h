#pragma once
#include <filesystem>
#include <string>

#include "measure.h"
#include "plot/figure.h"

namespace granuscope {

/// How far D and c measured with loads of several kinds and sizes lie from those of the linear response, against the
/// size of the load, one pair of curves (point, multiplexed) for each friction coefficient.
/// Writes figures/<study>*.csv, .gp, .svg and .pdf below `run_folder`, from the templates of the study.
/// Throws InputError if nothing could be compared, EnvironmentError if gnuplot is missing or fails.
Figure plot_load_comparison(const LoadComparison& measured, const std::string& study,
                            const std::filesystem::path& run_folder);

}  // namespace granuscope
