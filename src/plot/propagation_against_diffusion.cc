#include "plot/propagation_against_diffusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/label_places.h"
#include "plot/plot_colours.h"
#include "plot/plot_language.h"
#include "plot/point_selection.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "propagation-against-diffusion";

bool has_both(const Transport& result) { return result.c.known() && result.D.known(); }

bool fits_log_axes(const Transport& result) {
  return has_both(result) && !result.exact && result.D.value > 0 && result.c.value < tan30;
}

std::string mu_text(const Transport& result) { return "μ = " + caption_number(result.scanned()); }

struct Axes {
  Range D, c;
};

Axes make_axes(const std::vector<Transport>& results) {
  Axes axes;
  axes.c.add(tan30);
  axes.D.add(0);
  for (const Transport& result : results) {
    if (!has_both(result)) continue;
    for (const int sign : {-1, 1}) {
      axes.D.add(result.D.value + sign * result.D.standard_error);
      axes.c.add(result.c.value + sign * result.c.standard_error);
    }
  }
  const double D_size = std::max(axes.D.size(), 0.001), c_size = std::max(axes.c.size(), 0.001);
  axes.D.low -= 0.05 * D_size;
  axes.D.high += 0.05 * D_size;
  axes.c.low -= 0.07 * c_size;
  axes.c.high += 0.12 * c_size;  // room for the name of the point on the line of c0
  return axes;
}

Range share_of(double value, double error, const Range& axis) {
  Range share;
  share.add((value - error - axis.low) / axis.size());
  share.add((value + error - axis.low) / axis.size());
  return share;
}

/// The height of both panels together, in inches, as the script lays them out.
constexpr double figure_height = 3.3, panel_height = 2.24, upper_panel_height = 1.61;

/// "0.3" beside every point of the left panel, which is narrower by `c_room` than it could be.
std::string point_labels(const std::vector<Transport>& results, const Axes& axes, const ScalingFit& alpha,
                         const Range& window_D, double c_room) {
  LabelledPanel panel{(0.385 - c_room) * plot_width_inches, panel_height, {}, {}};
  std::vector<NamedPoint> points;
  const auto place = [&axes](double D, double c) {
    return PanelPlace{(D - axes.D.low) / axes.D.size(), (c - axes.c.low) / axes.c.size()};
  };
  panel.lines.push_back({place(axes.D.low, tan30), place(axes.D.high, tan30)});
  if (alpha.exponent.known() && alpha.intercept.known() && window_D.size() > 0) {
    const auto law = [&](double D) {
      return place(D, tan30 - std::exp(alpha.intercept.value) * std::pow(D, alpha.exponent.value));
    };
    constexpr int pieces = 16;
    for (int k = 0; k < pieces; ++k) {
      const double step = window_D.size() / pieces;
      panel.lines.push_back({law(window_D.low + k * step), law(window_D.low + (k + 1) * step)});
    }
  }
  for (const Transport& result : results) {
    if (!has_both(result)) continue;
    points.push_back({place(result.D.value, result.c.value), share_of(result.D.value, result.D.standard_error, axes.D),
                      share_of(result.c.value, result.c.standard_error, axes.c), caption_number(result.scanned())});
  }
  return label_commands(points, panel);
}

std::vector<LeftOut> reasons_off_log_axes(const std::vector<Transport>& results) {
  std::vector<LeftOut> reasons;
  for (const Transport& result : results) {
    if (!has_both(result) || fits_log_axes(result)) continue;
    const char* why = result.exact ? "exact" : result.D.value <= 0 ? "D is not positive" : "c is not below c₀";
    reasons.push_back({mu_text(result), why});
  }
  return reasons;
}

std::vector<LeftOut> unknown_points(const std::vector<Transport>& results) {
  std::vector<LeftOut> unknown;
  for (const Transport& result : results) {
    if (has_both(result)) continue;
    unknown.push_back({mu_text(result), result.D.known() ? result.c.reason : result.D.reason});
  }
  return unknown;
}

PowerLawPanel law_panel(const Analysis& analysis) {
  const ScalingFit& alpha = analysis.scaling.alpha;
  PowerLawPanel panel;
  panel.id = "slowing";
  panel.x_label = "diffusion coefficient D  (bead diameters)";
  panel.y_label = "c₀ − c";
  panel.x_unit = "bead diameters";
  panel.labels = true;
  panel.height = upper_panel_height;
  panel.left = 0.60;
  panel.right = 0.985;
  panel.paper_exponent = "0.4";
  PowerLawSeries slopes{"slopes", {}, alpha};
  for (const Transport& result : analysis.results) {
    if (!fits_log_axes(result)) continue;
    slopes.points.push_back(
        {result.scanned(), result.D.value, result.D.standard_error, tan30 - result.c.value, result.c.standard_error});
  }
  panel.series.push_back(slopes);
  panel.notes = {"this run: α = " + exponent_text(alpha), "", "the paper: α = 0.4"};
  return panel;
}

}  // namespace

Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder) {
  CsvTable table({"mu: dimensionless", "D: bead diameters", "D_standard_error: bead diameters", "c: dimensionless",
                  "c_standard_error: dimensionless"});
  for (const Transport& result : analysis.results) {
    if (!has_both(result)) continue;
    table.add_row({result.scanned(), result.D.value, result.D.standard_error, result.c.value, result.c.standard_error});
  }
  if (table.empty()) {
    throw InputError(
        "the figure of c against D has nothing to show, because no friction coefficient has both; use more samples or "
        "deeper layers, or switch the figure off");
  }
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/propagation_against_diffusion";
  plan.height = figure_height;
  plan.data[fmt::format("{}-points.csv", figure_id)] = table.text();
  plan.curves = 2;  // the points and the line at c0

  const ScalingFit& alpha = analysis.scaling.alpha;
  const PowerLawPanelScript law = add_power_law_panel(plan, law_panel(analysis));
  Range window_D;
  for (const Transport& result : analysis.results) {
    if (fits_log_axes(result) && in_window(result.scanned(), alpha.window)) window_D.add(result.D.value);
  }
  const bool with_law = law.law && window_D.size() > 0;
  if (with_law) ++plan.curves;
  const Axes axes = make_axes(analysis.results);
  const std::string c_ticks = linear_ticks(axes.c, 7);
  const double c_room = room_for_labels({c_ticks});
  const auto if_law = [with_law](double number) { return with_law ? exact(number) : ""; };
  const TemplateVariables script = {{"c0", exact(tan30)},
                                    {"labels", point_labels(analysis.results, axes, alpha, window_D, c_room)},
                                    {"D_low", exact(axes.D.low)},
                                    {"D_high", exact(axes.D.high)},
                                    {"c_low", exact(axes.c.low)},
                                    {"c_high", exact(axes.c.high)},
                                    {"D_ticks", linear_ticks(axes.D, 6)},
                                    {"c_ticks", c_ticks},
                                    {"c_room", exact(c_room)},
                                    {"alpha", if_law(alpha.exponent.value)},
                                    {"alpha_intercept", if_law(alpha.intercept.value)},
                                    {"alpha_low", caption_number(alpha.window[0])},
                                    {"alpha_high", caption_number(alpha.window[1])},
                                    {"fit_D_low", if_law(window_D.low)},
                                    {"fit_D_high", if_law(window_D.high)},
                                    {"law_panel", law.text},
                                    {"outside", law.outside ? "yes" : ""}};
  return plot_figure(
      plan, script,
      {"plot/propagation_against_diffusion.captions",
       {{"not_logarithmic", with_reasons(reasons_off_log_axes(analysis.results))},
        {"unknown", with_reasons(unknown_points(analysis.results))},
        {"law_panel", law.shown ? "yes" : ""},
        {"alpha", with_law ? exponent_text(alpha) : ""},
        {"alpha_low", caption_number(alpha.window[0])},
        {"alpha_high", caption_number(alpha.window[1])},
        {"alpha_reason", alpha.exponent.known() ? "fewer than two points lie in its window" : alpha.exponent.reason},
        {"off_scale", off_scale_in_words(law, "")}},
       terms_of(*analysis.scan)},
      run_folder);
}

}  // namespace granuscope
