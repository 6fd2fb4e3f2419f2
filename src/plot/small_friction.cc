#include "plot/small_friction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/lattice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/power_law_panel.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "small-friction";

struct Saturation {
  std::vector<std::string> curves, titles;
  Range depth, variance;
};

/// Mean of the weight variance over the deep part; not a number if it is unknown there.
double deep_variance(const SmallFriction& one) {
  double sum = 0, layers = 0;
  for (const ThrustAtDepth& depth : one.depths) {
    if (depth.layer < one.first_layer || depth.layer > one.last_layer || !depth.weight_variance.known()) continue;
    sum += depth.weight_variance.value;
    ++layers;
  }
  return sum / layers;
}

/// The variance of the weights over its deep value, against the layer in units of 0.6/mu^2, at layers a tenth apart.
void add_saturation(PlotPlan& plan, Saturation& all, const SmallFriction& one) {
  const double deep = deep_variance(one);
  const double saturation = one.spec.lattice.layers / one.depth_over_saturation;
  if (!(deep > 0) || !(saturation > 0)) return;
  CsvTable table({"layers_over_saturation", "variance_over_deep", "standard_error", "layer", "weight_variance"});
  double last = 0;
  for (const ThrustAtDepth& depth : one.depths) {
    if (!depth.weight_variance.known() || depth.layer < 1.1 * last || depth.layer == 0) continue;
    last = depth.layer;
    const double x = depth.layer / saturation, y = depth.weight_variance.value / deep;
    const double error = depth.weight_variance.standard_error / deep;
    table.add_row({x, y, error, last, depth.weight_variance.value});
    all.depth.add(x);
    all.variance.add(y - error);
    all.variance.add(y + error);
  }
  if (table.empty()) return;
  const std::string file = fmt::format("{}-mu-{}.csv", figure_id, exact(one.spec.sampler.mu));
  plan.data[file] = table.text();
  const std::string style = series_style(all.curves.size());
  all.curves.push_back(
      fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.8 pointsize 0.35 {} notitle", file, style));
  all.titles.push_back(fmt::format("keyentry with points pointsize 0.55 {} title {}", style,
                                   gnuplot_string("μ = " + caption_number(one.spec.sampler.mu))));
  ++plan.curves;
}

PowerLawPoint point_of(double mu, const Estimate& slowing) {
  return {mu, mu, 0, slowing.value, slowing.standard_error};
}

std::string in_words(const Estimate& exponent) {
  return exponent.known() ? value_with_error(exponent.value, exponent.standard_error) : "unknown";
}

}  // namespace

Figure draw_small_friction(const Analysis& analysis, const std::filesystem::path& run_folder) {
  const SideMeasurements& side = analysis.side;
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "small_friction";
  plan.height = 3.1;
  Saturation saturation;
  PowerLawPanel panel;
  panel.id = "slowing";
  panel.x_label = "friction coefficient μ";
  panel.y_label = "c₀ − c  (thrust)";
  panel.against_mu = true;
  panel.left = 0.60;
  panel.right = 0.985;
  panel.paper_exponent = "1";
  PowerLawSeries narrow{"narrow-piles", {}, side.small_friction_scaling}, wide{"main-piles", {}, {}};
  wide.fit.window = analysis.scaling.gamma.window;
  int columns = 0;
  double shallowest = std::numeric_limits<double>::infinity();
  for (const SmallFriction& one : side.small_friction) {
    if (!one.c0_minus_c.known()) continue;
    add_saturation(plan, saturation, one);
    narrow.points.push_back(point_of(one.spec.sampler.mu, one.c0_minus_c));
    columns = one.spec.lattice.columns;
    shallowest = std::min(shallowest, one.depth_over_saturation);
  }
  for (const Transport& result : analysis.results) {
    if (result.exact || !result.c_thrust.known()) continue;
    wide.points.push_back(point_of(result.mu(), {tan30 - result.c_thrust.value, result.c_thrust.standard_error, ""}));
  }
  panel.series = {narrow, wide};
  const Estimate& exponent = side.small_friction_scaling.exponent;
  panel.notes = {"narrow deep piles: " + in_words(exponent), "", "the paper, for c: 1"};
  const PowerLawPanelScript law = add_power_law_panel(plan, panel);
  if (saturation.curves.empty() || !law.drawn) {
    throw InputError(
        "the figure of small friction has nothing to show, because no thrust ratio was measured for it; list friction "
        "coefficients in figures.small_friction.mu");
  }
  ++plan.curves;  // the line at 1
  saturation.variance.add(0);
  saturation.variance.add(1.15);
  const Range depth = widened_by_factor(saturation.depth, saturation.depth.high > 1.5 * saturation.depth.low ? 1.3 : 2);
  Figure figure = draw_plot(plan,
                            {{"curves", fmt::format("{}", fmt::join(saturation.curves, ", \\\n    "))},
                             {"titles", fmt::format("{}", fmt::join(saturation.titles, ", \\\n    "))},
                             {"depth_low", exact(depth.low)},
                             {"depth_high", exact(depth.high)},
                             {"depth_ticks", log_ticks(depth)},
                             {"variance_low", exact(saturation.variance.low)},
                             {"variance_high", exact(1.05 * saturation.variance.high)},
                             {"variance_ticks", linear_ticks(saturation.variance, 6)},
                             {"law_panel", law.text},
                             {"main_piles", law.second ? "yes" : ""}},
                            run_folder);
  const ScalingFit& fit = side.small_friction_scaling;
  set_words(figure, "plot/small_friction.words",
            {{"columns", std::to_string(columns)},
             {"shallowest", caption_number(shallowest, 2)},
             {"exponent", exponent.known() ? in_words(exponent) : ""},
             {"reason", exponent.known() ? "" : exponent.reason},
             {"low", caption_number(fit.window[0])},
             {"high", caption_number(fit.window[1])},
             {"main_piles", law.second ? "yes" : ""},
             {"off_scale", off_scale_in_words(law, "")}});
  return figure;
}

}  // namespace granuscope
