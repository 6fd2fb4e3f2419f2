#include "plot/propagation_against_diffusion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "propagation-against-diffusion";

bool has_both(const Transport& result) { return result.c.known() && result.D.known(); }

bool fits_log_axes(const Transport& result) {
  return has_both(result) && !result.exact && result.D.value > 0 && result.c.value < tan30;
}

std::string file_name(const std::string& part) { return fmt::format("{}-{}.csv", figure_id, part); }

std::string mu_text(const Transport& result) { return "μ = " + caption_number(result.mu); }

/// The large panel's axes. The inset takes the upper right corner, so that every point right of its left edge has to
/// lie below its lower edge: the c axis is extended upwards until it does.
struct Axes {
  Range D, c;
  double inset_left = 0.38;    ///< share of the panel's width
  double inset_bottom = 0.42;  ///< share of the panel's height
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
  const double D_margin = 0.04 * std::max(axes.D.size(), 0.001);
  axes.D.low -= D_margin;
  axes.D.high += D_margin;
  const double c_margin = 0.07 * std::max(axes.c.size(), 0.001);
  axes.c.low -= c_margin;
  axes.c.high += c_margin;

  double highest_below_inset = axes.c.low;
  for (const Transport& result : results) {
    if (!has_both(result)) continue;
    const double right_end = result.D.value + result.D.standard_error;
    if (right_end - axes.D.low > (axes.inset_left - 0.02) * axes.D.size()) {
      highest_below_inset = std::max(highest_below_inset, result.c.value + result.c.standard_error);
    }
  }
  // The inset's own axis label and ticks hang below its lower edge, hence the label room.
  const double label_room = 0.04;
  axes.c.high =
      std::max(axes.c.high, axes.c.low + (highest_below_inset - axes.c.low) / (axes.inset_bottom - label_room));
  return axes;
}

/// "μ = 0.3" beside each point that is far enough from the last one labelled.
std::string point_labels(const std::vector<Transport>& results, const Axes& axes) {
  std::string labels;
  double last_x = -1, last_y = -1;
  for (const Transport& result : results) {
    if (!has_both(result)) continue;
    const double x = (result.D.value - axes.D.low) / axes.D.size();
    const double y = (result.c.value - axes.c.low) / axes.c.size();
    if (last_x >= 0 && std::abs(x - last_x) < 0.11 && std::abs(y - last_y) < 0.05) continue;
    last_x = x;
    last_y = y;
    const char* side = x > 0.85 ? "right offset -0.7, 0.6" : "left offset 0.7, 0.6";
    labels += fmt::format("set label {} at {}, {} {} noenhanced\n  ", gnuplot_string(mu_text(result)),
                          exact(result.D.value), exact(result.c.value), side);
  }
  return labels;
}

struct LogPoints {
  CsvTable inside{{"D", "c0-c", "D_low", "D_high", "c0-c_low", "c0-c_high"}};
  CsvTable outside{{"D", "c0-c", "D_low", "D_high", "c0-c_low", "c0-c_high"}};
  Range D, drop;   ///< the axes, margins included
  Range window_D;  ///< D of the points in the fit's window
  double log_D_sum = 0, log_drop_sum = 0;
  int window_points = 0;
};

LogPoints make_log_points(const Analysis& analysis) {
  LogPoints points;
  for (const Transport& result : analysis.results) {
    if (!fits_log_axes(result)) continue;
    points.D.add(result.D.value);
    points.D.add(result.D.value + result.D.standard_error);
    points.drop.add(tan30 - result.c.value);
    points.drop.add(tan30 - result.c.value + result.c.standard_error);
  }
  points.D = widened_by_factor(points.D, 1.6);
  points.drop = widened_by_factor(points.drop, 1.6);
  for (const Transport& result : analysis.results) {
    if (!fits_log_axes(result)) continue;
    const double D = result.D.value, D_error = result.D.standard_error;
    const double drop = tan30 - result.c.value, drop_error = result.c.standard_error;
    const bool inside = in_window(result.mu, analysis.scaling.alpha.window);
    // A bar that reaches zero or below ends at the axis.
    (inside ? points.inside : points.outside)
        .add_row({D, drop, std::max(D - D_error, points.D.low), D + D_error,
                  std::max(drop - drop_error, points.drop.low), drop + drop_error});
    if (!inside) continue;
    points.window_D.add(D);
    points.log_D_sum += std::log(D);
    points.log_drop_sum += std::log(drop);
    ++points.window_points;
  }
  return points;
}

std::vector<std::string> reasons_off_log_axes(const std::vector<Transport>& results) {
  std::vector<std::string> reasons;
  for (const Transport& result : results) {
    if (!has_both(result) || fits_log_axes(result)) continue;
    const char* why = result.exact ? "exact" : result.D.value <= 0 ? "D is not positive" : "c is not below c₀";
    reasons.push_back(fmt::format("{} ({})", mu_text(result), why));
  }
  return reasons;
}

std::vector<std::string> unknown_points(const std::vector<Transport>& results) {
  std::vector<std::string> unknown;
  for (const Transport& result : results) {
    if (has_both(result)) continue;
    unknown.push_back(fmt::format("{} ({})", mu_text(result), result.D.known() ? result.c.reason : result.D.reason));
  }
  return unknown;
}

std::vector<std::string> shown_mus(const std::vector<Transport>& results) {
  std::vector<std::string> mus;
  for (const Transport& result : results) {
    if (has_both(result)) mus.push_back(caption_number(result.mu));
  }
  return mus;
}

void add_inset(PlotPlan& plan, Gaps& script, Gaps& words, const Analysis& analysis) {
  const ScalingFit& alpha = analysis.scaling.alpha;
  const LogPoints points = make_log_points(analysis);
  const bool inset = !points.D.empty;
  const bool law = inset && alpha.exponent.known() && alpha.intercept.known() && points.window_points > 1;
  if (!points.inside.empty()) plan.data[file_name("inside")] = points.inside.text();
  if (!points.outside.empty()) plan.data[file_name("outside")] = points.outside.text();
  plan.curves += (points.inside.empty() ? 0 : 1) + (points.outside.empty() ? 0 : 1) + (law ? 3 : 0);

  const auto if_inset = [inset](double number) { return inset ? exact(number) : ""; };
  const auto if_law = [law](double number) { return law ? exact(number) : ""; };
  script["inset"] = words["inset"] = inset ? "yes" : "";
  script["inside"] = points.inside.empty() ? "" : "yes";
  script["outside"] = points.outside.empty() ? "" : "yes";
  script["alpha"] = words["alpha"] = if_law(alpha.exponent.value);
  script["alpha_intercept"] = if_law(alpha.intercept.value);
  script["alpha_low"] = words["alpha_low"] = caption_number(alpha.window[0]);
  script["alpha_high"] = words["alpha_high"] = caption_number(alpha.window[1]);
  words["alpha_reason"] = alpha.exponent.known() ? "fewer than two points lie in its window" : alpha.exponent.reason;
  script["fit_D_low"] = if_law(points.window_D.low);
  script["fit_D_high"] = if_law(points.window_D.high);
  script["guide_D"] = if_law(std::exp(points.log_D_sum / std::max(points.window_points, 1)));
  script["guide_height"] = if_law(std::exp(points.log_drop_sum / std::max(points.window_points, 1)));
  script["D_log_low"] = if_inset(points.D.low);
  script["D_log_high"] = if_inset(points.D.high);
  script["drop_log_low"] = if_inset(points.drop.low);
  script["drop_log_high"] = if_inset(points.drop.high);
  script["D_ticks"] = inset ? log_ticks(points.D) : "";
  script["drop_ticks"] = inset ? log_ticks(points.drop) : "";
}

}  // namespace

Figure draw_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder) {
  CsvTable table({"mu", "D", "D_standard_error", "c", "c_standard_error"});
  for (const Transport& result : analysis.results) {
    if (!has_both(result)) continue;
    table.add_row({result.mu, result.D.value, result.D.standard_error, result.c.value, result.c.standard_error});
  }
  if (table.empty()) {
    throw InputError(
        "the figure of c against D has nothing to show, because no friction coefficient has both; use more samples or "
        "deeper layers, or switch the figure off");
  }
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "propagation_against_diffusion";
  plan.height = 4.8;
  plan.data[file_name("points")] = table.text();
  plan.curves = 2;  // the points and the line at c0

  const Axes axes = make_axes(analysis.results);
  Gaps script = {{"c0", exact(tan30)},
                 {"labels", point_labels(analysis.results, axes)},
                 {"D_low", exact(axes.D.low)},
                 {"D_high", exact(axes.D.high)},
                 {"c_low", exact(axes.c.low)},
                 {"c_high", exact(axes.c.high)},
                 {"D_linear_ticks", linear_ticks(axes.D, 6)},
                 {"c_ticks", linear_ticks(axes.c, 7)},
                 // The panel spans 0.10 to 0.98 of the drawing; the inset's tick labels stand left of its edge.
                 {"inset_left", exact(0.10 + 0.88 * (axes.inset_left + 0.10))},
                 {"inset_bottom", exact(axes.inset_bottom)}};
  Gaps words = {{"mus", "μ = " + enumeration(shown_mus(analysis.results))},
                {"not_logarithmic", enumeration(reasons_off_log_axes(analysis.results))},
                {"unknown", enumeration(unknown_points(analysis.results))}};
  add_inset(plan, script, words, analysis);

  Figure figure = draw_plot(plan, script, run_folder);
  set_words(figure, "plot/propagation_against_diffusion.words", words);
  return figure;
}

}  // namespace granuscope
