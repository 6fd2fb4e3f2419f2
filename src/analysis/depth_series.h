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

/// chi^2 of the straight line with the joint covariance of the depths (line_test.h), of which at most B/4 for B blocks,
/// spread evenly, take part.
LineTest test_line(const DepthSeries& series);

}  // namespace granuscope
