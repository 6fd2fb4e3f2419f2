#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/results.h"
#include "analysis/shape_fit.h"

namespace granuscope {

/// Why a fit of shape_fit.h is not known.
inline constexpr const char* no_extended_fit = "the fit with one parameter more did not converge";

/// The response at one layer with its replicates.
struct MeasuredDepth {
  DepthFit fit;
  bool other_shape = false;  ///< why it is not identifiable
  Replicated peak, width, width_squared, thrust;
  Replicated peak_by_equal, width_squared_by_equal;  ///< from ModeWeights::equal
  /// What is measured of two peaks inside the window; nothing if not identifiable or exact.
  struct Inside {
    Replicated height;
    ShapeDiagnostics diagnostics;
    ResidualNoise noise;
  };
  std::optional<Inside> inside;
};

/// The response at recorded layer number `row`: by a fit of two Gaussians, or where there is no scatter by its moments.
/// The verdict on the shape is chi^2 by the noise of this layer; x_p and W go by weights that do not look at it
/// (shape_fit.h).
MeasuredDepth measure_depth(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row);

/// x_p and W^2 of it alone, without replicates.
MeasuredDepth measure_depth_values(const MeasuredEnsemble& ensemble, const FitSpec& spec, std::size_t row);

/// One quantity at the depths of the fit window, with replicates over the same blocks.
struct DepthSeries {
  std::vector<double> z;
  std::vector<Replicated> y;
};

/// What each depth counts in every fit over depths: 1/z^2, whatever the noise. W^2 does not grow as z exactly, so that
/// its slope depends on the weights, and numbers of two ensembles can only be compared under the same ones. 1/variance,
/// which goes from z^-1.5 to z^-4 in ensembles of one size, would make the errors of c and D less than 5 % smaller.
std::vector<double> depth_weights(const std::vector<double>& z);

struct ReplicatedLine {
  Replicated slope, intercept;
};
/// A depth above which nothing counts; from there over `reach` the weight of a depth grows from 0 to its full value.
struct WindowEdge {
  Replicated z;
  double reach = 0;  ///< 0: there is no edge
};

/// y = intercept + slope z through at least two depths, with the edge that each replicate has. The three deepest depths
/// always count in full.
ReplicatedLine line_through(const DepthSeries& series, const WindowEdge& edge = {});

/// The power p with which y grows, apart from its offset: y = y_0 + A z^p locally, from the parabola
/// y = a + b u + q u^2, u = (z - z_m)/z_m: p = 1 + d ln(dy/dz)/d ln z = 1 + 2 q/b. z_m lies where a cubic term of y
/// would leave q as it is: a third of the coefficient of z^2 in the parabola through z^3. 1 for a straight line,
/// whatever its offset. Needs four depths or more.
Replicated growth_exponent(const DepthSeries& series);

/// chi^2 of the straight line with the joint covariance of the depths (jackknife.h), of which at most B/4 for B blocks,
/// spread evenly, take part.
LineTest test_line(const DepthSeries& series);

/// A run of fitted depths at the step of the window (shape_fit.h), shallowest first.
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

/// Exponents with replicates; empty where unknown.
struct ReplicatedExponents {
  Replicated position, width, amplitude, noise;
};

/// A Transport together with the replicates that later fits need.
struct MeasuredTransport {
  Transport transport;
  Replicated c, D, position_offset;         ///< empty if unknown
  std::vector<VariationSlopes> variations;  ///< as Transport::variations
  ReplicatedExponents exponents;
};

/// The layers that a FitSpec needs recorded, ascending, with `extra` (figures) merged in.
std::vector<int> layers_to_record(const FitSpec& spec, const std::vector<int>& extra);

/// Fits the response at every recorded layer, then x_p = x_0 + c z and W^2 = w_0 + D z over the window of `spec`, with
/// delete-one-block replicates through the whole chain. The window loses its shallow end where the width is not
/// identifiable, the last depth there by degrees (edge_of); the layers used are reported. Fits have weights
/// that do not look at the noise (depth_weights in transport.h, ModeWeights in shape_fit.h).
/// `profile_layers`: layers to report as ResponseProfile. An ensemble without scatter (mu = 0) is measured by its
/// moments instead and marked exact. `threads`: 0 for as many as the machine has; the result does not depend on it.
MeasuredTransport measure_transport(const MeasuredEnsemble& ensemble, const FitSpec& spec,
                                    const std::vector<int>& profile_layers, int threads);

/// c and D of measure_transport alone, without errors and in a fraction of the time, for whoever has many ensembles to
/// take the scatter from. NaN where unknown. Those of the estimator paired as they come out, whatever law its piles
/// follow.
struct Slopes {
  double c = 0, D = 0;
};
Slopes measure_slopes(const MeasuredEnsemble& ensemble, const FitSpec& spec);

}  // namespace granuscope
