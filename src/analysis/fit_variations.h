#pragma once
#include <cstddef>
#include <vector>

#include "analysis/depth_series.h"
#include "analysis/results.h"

namespace granuscope {

/// A run of fitted depths at the step of the window (identifiable_depths.h), shallowest first.
struct FittedRun {
  std::vector<int> layers;
  DepthSeries peaks, widths;                    ///< x_p and W^2
  DepthSeries peaks_by_equal, widths_by_equal;  ///< the same from ModeWeights::equal
  std::size_t window_start = 0;                 ///< the depths from here on are the window; those before lie above it
  WindowEdge edge;  ///< where the peaks become wide enough; it matters if the window begins there
};

/// Where the line W^2 = w_0 + D z through the window of `run` reaches `min_width`, with the distance `reach` of two
/// depths. Peaks of that width begin at a depth that noise may move by one: a line that took up this depth as a whole
/// or not at all would jump. With W^2 bent as it is there, D of 1024 opposite pairs at mu = 0.1 did by half a standard
/// error, and its interval covered 60 % of the truth instead of 68 %.
WindowEdge edge_of(const FittedRun& run, double min_width, double reach);

/// The depths [first, last) of a run.
FittedRun part_of(const FittedRun& run, std::size_t first, std::size_t last);

/// The lines x_p = x_0 + c z and W^2 = w_0 + D z through all depths of a run.
struct TransportLines {
  ReplicatedLine position, width;
};
TransportLines transport_lines(const FittedRun& run);

/// c and D of one variation with replicates; empty if unknown.
struct VariationSlopes {
  FitVariation shown;
  Replicated c, D;
};

/// The choices beside those of the fit: its window without the shallowest quarter, without the deepest quarter, and
/// with as much more above it as has been fitted, up to a quarter; and the other weights of the modes. Always these
/// four; unknown, with the reason, where too few depths are there. `c`, `D`: of the fit itself.
std::vector<VariationSlopes> measure_variations(const FittedRun& run, const Replicated& c, const Replicated& D);

/// How far a number depends on such choices: the rms of its shifts under the variations, freed of what their standard
/// errors account for: sqrt(max(0, <shift^2 - s^2>)). NaN if no shift is known.
double systematic_spread(const std::vector<Estimate>& shifts);

}  // namespace granuscope
