#pragma once
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "analysis/results.h"
#include "plot/axes.h"
#include "plot/plot.h"

namespace granuscope {
/// The result nearest in mu among those that `usable` accepts (the lower mu of two equally near), or nullptr.
const Transport* nearest_result(const std::vector<Transport>& results, double mu,
                                const std::function<bool(const Transport&)>& usable);

/// The same analysis for the figures against mu: a c or D too uncertain to be a point becomes unknown, with that as the
/// reason, so that one error bar does not squeeze all other points together. One that was unknown before gets a reason
/// that points to the table of c and D, which tells it at length: each of these figures would tell it again.
Analysis without_imprecise_points(const Analysis& analysis);

/// c and D of the main line as slopes, like one reading among others; unknown ones included.
OtherReading slopes_of(const Analysis& analysis);

/// Whether mu lies in the closed window (with room for the rounding of decimal fractions).
bool in_window(double mu, const std::array<double, 2>& window);

/// One measured point of a power law y = A x^k; errors are standard errors.
struct PowerLawPoint {
  double mu = 0;
  double x = 0, x_error = 0;
  double y = 0, y_error = 0;
};

/// Columns of a table of such points (gnuplot.h): mu, x, y and the ends of the error bars.
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

/// "1.66(4)"; without an error and with chi^2 where the points follow no power law; "unknown".
std::string exponent_text(const ScalingFit& fit);

/// Points read in one way, with the law fitted to those in its window of mu.
struct PowerLawSeries {
  std::string name;  ///< of its data files: "slopes"
  std::vector<PowerLawPoint> points;
  ScalingFit fit;
  Ink ink;  ///< its marker is a filled one; the one before is open
  std::string note;
};

/// A panel with logarithmic axes, and below it, if wanted, a narrow one with each point over its fitted law.
struct PowerLawPanel {
  std::string id;  ///< of its data files: "D-of-mu"
  std::string x_label, y_label;
  std::string x_unit = "dimensionless", y_unit = "dimensionless";  ///< in the CSV
  std::vector<PowerLawSeries> series = {};                         ///< from the highest points to the lowest
  double level = 0;             ///< if above 0, level - y stands on a linear axis, mu beside each point
  std::string level_note = {};  ///< its name
  double paper_exponent = 0;    ///< if above 0, of a dotted triangle
  std::string paper_note = {};
  double guide_exponent = 0;  ///< if above 0, of a dashed line through the middle of the last series' window points
  std::string guide_note = {};
  bool ratios = false;
  double left = 0.105, right = 0.985;  ///< edges, as shares of a plot 6.69 in wide
};

/// What became of a panel.
struct PowerLawShown {
  bool shown = false;     ///< false if no point fits the axes: there is no panel then
  bool law = false;       ///< some series has a fitted law
  std::string off_scale;  ///< "μ = 0.8 and 1.3": points too far from their law for the narrow panel
};

/// Adds the panel, the narrow one below it, and their data to the plot, whose height, width and key are known.
PowerLawShown add_power_law_panel(Plot& plot, const PowerLawPanel& panel);

}  // namespace granuscope
