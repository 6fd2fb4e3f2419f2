#pragma once
#include <string>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/line_test.h"

namespace granuscope {

/// One quantity at the depths of the fit window, with replicates over the same blocks.
struct DepthSeries {
  std::vector<double> z;
  std::vector<Replicated> y;
};

/// Weights 1/variance(z) for a fit to the series, the variance taken from a power of z through the jackknife variances
/// of the depths. All equal where there is no scatter.
std::vector<double> smooth_weights(const DepthSeries& series);

struct ReplicatedLine {
  Replicated slope, intercept;
};
/// y = intercept + slope z through at least two depths.
ReplicatedLine line_through(const DepthSeries& series, const std::vector<double>& weights);

/// A depth above which nothing counts; from there over `reach` the weight of a depth grows from 0 to its full value.
struct WindowEdge {
  Replicated z;
  double reach = 0;  ///< 0: there is no edge
};

/// The same with an edge, as each replicate has it. The three deepest depths always count in full.
ReplicatedLine line_through(const DepthSeries& series, const std::vector<double>& weights, const WindowEdge& edge);

/// The power p with which y grows, apart from its offset: y = y_0 + A z^p locally, from the parabola
/// y = a + b u + q u^2, u = (z - z_m)/z_m about the middle z_m of the depths: p = 1 + d ln(dy/dz)/d ln z = 1 + 2 q/b.
/// 1 for a straight line, whatever its offset. Needs four depths or more.
Replicated growth_exponent(const DepthSeries& series, const std::vector<double>& weights);

/// The power p of y = A z^p: the slope of ln y on ln z.
Replicated power_of_depth(const DepthSeries& series);

/// chi^2 of the straight line with the joint covariance of the depths (line_test.h), of which at most B/4 for B blocks,
/// spread evenly, take part.
LineTest test_line(const DepthSeries& series);

}  // namespace granuscope
