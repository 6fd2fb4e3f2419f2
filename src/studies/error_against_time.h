#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "analysis/precision.h"
#include "plot/figure_captions.h"
#include "studies/study.h"

namespace granuscope {

/// Statistical error of c and D against the beads drawn, a curve for each estimator, on logarithmic axes.
/// Behind its measured points each curve goes on with the total error, sqrt(scatter^2 + shift^2) about the linear
/// response, where its shift is known to differ from zero by three standard errors. Beads drawn stand for the time, for
/// a figure is to be the same bytes again; what a bead takes is among the timings. Writes
/// figures/error-against-time*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if no curve has a point,
/// EnvironmentError if gnuplot is missing or fails.
Figure plot_error_against_time(const std::vector<ErrorCurve>& curves, const std::filesystem::path& run_folder);

/// The error of each estimator against the beads that it draws, on ensembles of their own.
std::unique_ptr<Study> error_against_time_study();

}  // namespace granuscope
