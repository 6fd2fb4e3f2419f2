#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure.h"

namespace granuscope {

/// What the figure of c and D against depth shows in its two large panels.
struct TransportWithDepthSpec {
  double mu = 0.3;  ///< the nearest one with fitted depths is plotted, and the caption says which
};

/// The paper's Fig. 3: x_p/z and W^2/z against depth with the slopes c and D; c(mu) and D(mu) as insets.
/// Writes figures/transport-with-depth*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no depth at all was fitted, EnvironmentError if gnuplot is missing or fails.
Figure plot_transport_with_depth(const Analysis& analysis, const TransportWithDepthSpec& spec,
                                 const std::filesystem::path& run_folder);

}  // namespace granuscope
