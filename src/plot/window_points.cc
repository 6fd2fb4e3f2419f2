#include "plot/window_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "plot/point_selection.h"
#include "support/number_format.h"

namespace granuscope {

std::vector<std::string> power_law_columns(const std::string& x_unit, const std::string& y_unit) {
  return {"mu: dimensionless", "x: " + x_unit,     "y: " + y_unit,     "x_low: " + x_unit,
          "x_high: " + x_unit, "y_low: " + y_unit, "y_high: " + y_unit};
}

bool fits_log_axes(const PowerLawPoint& point) { return point.x > 0 && point.y > 0; }

WindowMiddle middle_of_window(const std::vector<PowerLawPoint>& points, const std::array<double, 2>& window) {
  WindowMiddle middle;
  double log_x = 0, log_y = 0, count = 0;
  for (const PowerLawPoint& point : points) {
    if (!fits_log_axes(point) || !in_window(point.mu, window)) continue;
    log_x += std::log(point.x);
    log_y += std::log(point.y);
    middle.extent.add(point.x);
    ++count;
  }
  if (count == 0) return middle;
  middle.x = std::exp(log_x / count);
  middle.y = std::exp(log_y / count);
  return middle;
}

Range window_on_axis(const std::array<double, 2>& window, const Range& axis) {
  Range part;
  part.add(std::clamp(window[0], axis.low, axis.high));
  part.add(std::clamp(window[1], axis.low, axis.high));
  return part;
}

std::string exponent_text(const ScalingFit& fit) {
  if (!fit.exponent.known()) return "unknown";
  if (!fit.misses_the_points()) return value_with_error(fit.exponent.value, fit.exponent.standard_error);
  return fmt::format("{} (χ² = {} on {})", significant(fit.exponent.value, 3), significant(fit.scatter.chi2, 2),
                     fit.scatter.degrees_of_freedom);
}

}  // namespace granuscope
