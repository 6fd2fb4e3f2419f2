#pragma once
#include <string>
#include <utility>
#include <vector>

#include "analysis/results.h"
#include "plot/plot_script.h"
#include "plot/window_points.h"

namespace granuscope {

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
struct PowerLawPanelScript {
  std::string text;      ///< to be put into the figure's script
  bool shown = false;    ///< false if no point fits logarithmic axes: text is then empty
  bool law = false;      ///< the first series has a fitted law
  bool second = false;   ///< the second series has points
  bool outside = false;  ///< some point lies outside the window
  std::vector<std::pair<std::string, double>> off_scale;  ///< points too far from their law for the narrow panel: the
                                                          ///< name of their series and mu
};

/// "μ = 0.8 and 1.3", or with a name for what the panel shows "D (slopes) at μ = 0.8 and D (ratios) at μ = 1.3"; empty
/// if the narrow panel shows every point.
std::string off_scale_in_words(const PowerLawPanelScript& panel, const std::string& what);

/// The script of a panel; its data files and curves are added to the plan.
PowerLawPanelScript add_power_law_panel(PlotPlan& plan, const PowerLawPanel& panel);

}  // namespace granuscope
