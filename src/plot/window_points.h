#pragma once
#include <array>
#include <string>
#include <vector>

#include "analysis/scaling_fit.h"
#include "plot/axes.h"

namespace granuscope {

/// One measured point of a power law y = A x^k; errors are standard errors.
struct PowerLawPoint {
  double mu = 0;
  double x = 0, x_error = 0;
  double y = 0, y_error = 0;
};

/// Columns of a table of such points (csv_table.h): mu, x, y and the ends of the error bars.
std::vector<std::string> power_law_columns(const std::string& x_unit, const std::string& y_unit);

/// Only what is positive has a place on logarithmic axes.
bool fits_log_axes(const PowerLawPoint& point);

/// The middle of the points of a window on logarithmic axes, and how far they reach in x (empty if there are none). A
/// guide of given exponent passes through it. The window itself has no such middle: it may begin at mu = 0 and end far
/// beyond the points.
struct WindowMiddle {
  double x = 0, y = 0;
  Range extent;
};

WindowMiddle middle_of_window(const std::vector<PowerLawPoint>& points, const std::array<double, 2>& window);

/// The part of a window of mu that lies on an axis of mu. A curve is sampled at a fixed number of places: over a window
/// that ends far beyond the axis, none of them might be on it.
Range window_on_axis(const std::array<double, 2>& window, const Range& axis);

/// "1.66(4)"; without an error and with chi^2 where the points follow no power law; "unknown".
std::string exponent_text(const ScalingFit& fit);

}  // namespace granuscope
