#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "plot/axes.h"
#include "plot/plot_script.h"

namespace granuscope {

/// One of two panels side by side.
struct ModelPanel {
  std::string x_label, y_label;
  Range x, y;
  bool log_x = false, log_y = false;
  std::vector<std::string> curves;  ///< gnuplot's plot elements
};

/// How a number is shown: points with error bars, or a line alone.
enum class CurveKind { points, joined_points, line };

/// A row of x, y and y's standard error (0 for lines).
using CurveRows = std::vector<std::array<double, 3>>;

/// Adds a curve in the style of series number `colour`, and its data file NAME.csv after the figure's id; `x_column`
/// and `y_column` are names with units of the columns. Nothing is added for no rows.
void add_curve(PlotPlan& plan, ModelPanel& panel, const std::string& name, const CurveRows& rows, CurveKind kind,
               std::size_t colour, const std::string& x_column, const std::string& y_column);

/// An entry of the key for all curves of that style.
std::string key_entry(const std::string& title, std::size_t colour, CurveKind kind);

/// Plots both. Throws InputError where one has no curve.
Figure plot_panels(PlotPlan plan, const ModelPanel& left, const ModelPanel& right,
                   const std::vector<std::string>& titles, const Wording& wording,
                   const std::filesystem::path& run_folder);

}  // namespace granuscope
