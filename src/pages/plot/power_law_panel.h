#pragma once
#include <array>
#include <functional>
#include <string>
#include <utility>
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

/// The part of a window of mu that lies on an axis of mu. A curve is sampled at a fixed number of places: over a window
/// that ends far beyond the axis, none of them might be on it.
Range window_on_axis(const std::array<double, 2>& window, const Range& axis);

/// "1.66(4)"; without an error and with chi^2 where the points follow no power law; "unknown".
std::string exponent_text(const ScalingFit& fit);

/// Points read in one way, with the law fitted to those in its window of mu.
struct PowerLawSeries {
  std::string name;  ///< of its data files: "slopes"
  std::vector<PowerLawPoint> points;
  ScalingFit fit;
};

/// A panel with logarithmic axes, and below it a narrow one with each point over its fitted law.
struct PowerLawPanel {
  std::string id;  ///< of its data files: "D-of-mu"
  std::string x_label, y_label;
  std::string x_unit = "dimensionless", y_unit = "dimensionless";  ///< in the CSV
  bool against_mu = false;                                         ///< x is mu itself: a law's window is a range of x
  bool labels = false;                                             ///< mu stands beside each point of the first series
  std::vector<PowerLawSeries> series;  ///< at most two: the first filled circles, the second diamonds
  std::string paper_exponent;          ///< plotted as a guide through the middle of the first series' window points
  std::vector<std::string> notes;      ///< lines of text in the upper left corner: one a series, then the paper's
  double left = 0.1, right = 0.98;     ///< edges, as shares of the plot's width
  double height = 2.2;                 ///< inches of the upper panel, by which the names find their places
};

/// What became of a panel.
struct PowerLawShown {
  bool shown = false;    ///< false if no point fits logarithmic axes: there is no panel then
  bool law = false;      ///< the first series has a fitted law
  bool second = false;   ///< the second series has points
  bool outside = false;  ///< some point lies outside the window
  std::vector<std::pair<std::string, double>> off_scale;  ///< points too far from their law for the narrow panel: the
                                                          ///< name of their series and mu
};

/// "μ = 0.8 and 1.3", or with a name for what the panel shows "D (slopes) at μ = 0.8 and D (ratios) at μ = 1.3"; empty
/// if the narrow panel shows every point.
std::string off_scale_in_words(const PowerLawShown& panel, const std::string& what);

/// Adds the panel, the narrow one below it, and their data to the plot, whose height and key are known.
PowerLawShown add_power_law_panel(Plot& plot, const PowerLawPanel& panel);

/// Names beside points, each with a thin line to its point where it stands far from it.
void add_names(Panel& shown, const std::vector<NamedPoint>& points, const LabelledPanel& panel);

}  // namespace granuscope
