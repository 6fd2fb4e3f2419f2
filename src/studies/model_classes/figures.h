#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "studies/model_classes/measure.h"
#include "studies/spreading.h"

namespace granuscope {
/// Those that are scanned together, with the power law of c0 - c against D.
struct ModelSeries {
  std::string name;
  bool aside = false;  ///< no class of models by itself: it has a figure of its own
  std::vector<ModelResponse> responses;
  ScalingFit alpha;
};

/// The response of one model over depths that double, from its fluctuations.
struct DeepModel {
  std::string series, parameter;
  DeepResponse response;
};

/// What the study has measured.
struct MeasuredModels {
  std::vector<ModelSeries> series;
  std::vector<TractionDepth> tractions;
  std::vector<DeepModel> deep;
};

/// c0 - c against D of all series with two peaks, and the response of the last of each series at the
/// deepest layer. Throws InputError where nothing was measured.
Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder);

/// What correlated noise takes from c^2 and adds to D against Delta^2, beside the theory to second order.
Figure plot_noise(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

/// The three-leg model: c against the mean share of the middle leg, beside c0 sqrt(1 - p), and where legs begin to
/// pull.
Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder);

/// What the beads of one pile of the last model of a series carry, under a uniform load.
Figure render_pile_of(const ModelSeries& series, const std::filesystem::path& run_folder);

/// Heavy beads: the thrust ratio over depth, and the response at the deepest layer.
Figure plot_gravity(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder);

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
