#pragma once
#include <filesystem>
#include <vector>

#include "analysis/results.h"
#include "plot/figure_captions.h"

namespace granuscope {
inline constexpr const char* transport_with_depth_id = "transport-with-depth";

/// What the figure of c and D against depth shows in its two large panels.
struct TransportWithDepthSpec {
  double mu = 0.3;  ///< the nearest one with fitted depths is plotted, and the caption says which
};

/// The paper's Fig. 3: x_p/z and W^2/z against depth with the slopes c and D; c(mu) and D(mu) as insets.
/// Writes figures/transport-with-depth*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no depth at all was fitted, EnvironmentError if gnuplot is missing or fails.
Figure plot_transport_with_depth(const Analysis& analysis, const TransportWithDepthSpec& spec,
                                 const std::filesystem::path& run_folder);

/// What the figure of mean response profiles shows.
struct ResponseProfilesSpec {
  double mu = 0.3;                    ///< the nearest measured one is plotted, and the caption says which
  std::vector<int> layers{110, 170};  ///< one panel each; where one has no profile, the nearest that has
  int layers_computed = 200;          ///< of the lattice: the caption counts the layers from the bottom too
};

/// The paper's Fig. 2: the measured response P(x) with its standard error and the fitted double Gaussian.
/// Writes figures/response-profiles*.csv, .gp, .svg and .pdf below `run_folder`.
/// Throws InputError if no result holds a profile, EnvironmentError if gnuplot is missing or fails.
Figure plot_response_profiles(const std::vector<Transport>& results, const ResponseProfilesSpec& spec,
                              const std::filesystem::path& run_folder);

}  // namespace granuscope
