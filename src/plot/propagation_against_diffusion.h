#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure.h"

namespace granuscope {

/// The paper's Fig. 4: c against D, one point for each friction coefficient; beside it c0 - c against D on
/// logarithmic axes with the fitted power law, the paper's exponent, and each point over the law.
/// Writes figures/propagation-against-diffusion*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result has both c and D, EnvironmentError if gnuplot is missing or fails.
Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
