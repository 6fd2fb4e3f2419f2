#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "analysis/error_curve.h"
#include "plot/figure.h"
#include "studies/study.h"

namespace granuscope {

/// Statistical error of c and D against what reaching it takes, a curve for each estimator, on logarithmic axes.
/// `seconds`: time that drawing each curve's whole ensemble took; if one of them is not finite, beads drawn stand on
/// the axis instead. Behind its measured points each curve goes on with the total error, sqrt(scatter^2 + shift^2)
/// about the linear response, where its shift is known to differ from zero by three standard errors. Writes
/// figures/error-against-time*.csv, .gp, .svg and .pdf below `run_folder`. Throws InputError if no curve has a point,
/// EnvironmentError if gnuplot is missing or fails.
Figure plot_error_against_time(const std::vector<ErrorCurve>& curves, const std::vector<double>& seconds,
                               const std::filesystem::path& run_folder);

/// The error of each estimator against its run time, on ensembles of their own.
std::unique_ptr<Study> error_against_time_study();

}  // namespace granuscope
