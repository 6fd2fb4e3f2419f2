#pragma once
#include <span>

namespace granuscope {

/// y = intercept + slope x.
struct Line {
  double intercept = 0, slope = 0;
};

/// Least squares line through at least two points with weights (1/variance; any common factor), by a QR decomposition.
Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights);

/// y = intercept + slope x + curvature x^2.
struct Parabola {
  double intercept = 0, slope = 0, curvature = 0;
};

/// The same through at least three points.
Parabola fit_parabola(std::span<const double> x, std::span<const double> y, std::span<const double> weights);

}  // namespace granuscope
