#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/plot.h"
#include "support/templates.h"

namespace granuscope {
/// A row of x, y and y's standard error (0 for lines).
using CurveRows = std::vector<std::array<double, 3>>;

/// A panel whose axes reach as far as its curves.
struct GrowingPanel {
  std::string x_label, y_label;
  bool log_y = false;
  Range x = {}, y = {};
  Panel panel = {};

  /// Adds a curve, and its data file NAME.csv after the figure's id. Nothing is added for no rows. A column is a name
  /// and a unit: "z: bead diameters".
  void add(Plot& plot, const std::string& name, const CurveRows& rows, const Style& style, const std::string& x_column,
           const std::string& y_column);
  /// The panel at the place of this empty one. Throws InputError where it has no curve.
  Panel whole(Panel filled) const;
};

/// A plot of two panels side by side, with a key of three lines.
Plot two_panels(const char* id);

/// Plots it: the captions are those of its id, with _ for -, in templates/studies.
Figure plot_panels(Plot& plot, const GrowingPanel& left, const GrowingPanel& right, TemplateVariables variables,
                   const std::filesystem::path& run_folder);

}  // namespace granuscope
