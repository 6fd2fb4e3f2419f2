#include "figure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

struct Panels {
  std::vector<std::string> slowing, profiles, titles, exponents;
  std::string theory;  ///< its entry in the key
  Range D, c, height;
  double reach = 0, shallowest = 0, deepest = 0;  ///< of the profiles
};

void add_slowing(PlotPlan& plan, Panels& panels, const ModelSeries& series, const std::string& file_stem,
                 const std::string& style) {
  CsvTable table({"D: bead diameters", "standard_error: bead diameters", "c0_minus_c: dimensionless",
                  "standard_error: dimensionless"});
  for (const ModelResponse& one : series.responses) {
    if (!one.slowing.known() || !(one.slowing.value > one.slowing.standard_error) ||
        !(one.D.value > one.D.standard_error))
      continue;
    table.add_row({one.D.value, one.D.standard_error, one.slowing.value, one.slowing.standard_error});
    panels.D.add(one.D.value);
    panels.c.add(one.slowing.value);
  }
  if (table.empty()) return;
  const std::string file = file_stem + ".csv";
  plan.data[file] = table.text();
  panels.slowing.push_back(
      fmt::format("'{}' using 1:3:2:4 with xyerrorlines linewidth 1 pointsize 0.55 {} notitle", file, style));
  ++plan.curves;
  if (series.alpha.exponent.known()) {
    panels.exponents.push_back(fmt::format(
        "{} ({})", value_with_error(series.alpha.exponent.value, series.alpha.exponent.standard_error), series.name));
  }
}

/// c0 - c against D by the theory of the noise of a series, as far as the series goes.
void add_theory(PlotPlan& plan, Panels& panels, const ModelSeries& series, const std::string& file_stem,
                std::size_t colour) {
  CsvTable table({"D: bead diameters", "c0_minus_c: dimensionless"});
  for (const ModelResponse& one : series.responses) {
    if (!one.theory || one.theory->D0 > 0 || !one.slowing.known()) continue;
    table.add_row({one.D_expected, one.speed_without_disorder - one.c_expected});
  }
  if (table.empty()) return;
  const std::string file = file_stem + "-theory.csv", style = series_style(colour);
  plan.data[file] = table.text();
  const std::string line = "lines linewidth 1.2 dashtype 2 " + style.substr(style.find("linecolor"));
  panels.slowing.push_back(fmt::format("'{}' using 1:2 with {} notitle", file, line));
  panels.theory = fmt::format("keyentry with {} title {}", line, gnuplot_string("theory of " + series.name));
  ++plan.curves;
}

void add_profile(PlotPlan& plan, Panels& panels, const ModelResponse& one, const std::string& file_stem,
                 std::size_t colour) {
  if (!one.profile) return;
  const ResponseProfile& profile = *one.profile;
  CsvTable table({"x_over_z: dimensionless", "z_response: dimensionless", "standard_error: dimensionless",
                  "x: bead diameters", "response: per bead"});
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    const double x = profile.x[i] / profile.z;
    if (std::abs(x) > 1) continue;
    table.add_row(
        {x, profile.z * profile.pressure[i], profile.z * profile.standard_error[i], profile.x[i], profile.pressure[i]});
    panels.height.add(profile.z * profile.pressure[i]);
  }
  const std::string file = file_stem + "-profile.csv";
  plan.data[file] = table.text();
  const std::string style = series_style(colour);
  panels.profiles.push_back(
      fmt::format("'{}' using 1:2 with lines linewidth 1.2 {} notitle", file, style.substr(style.find("linecolor"))));
  ++plan.curves;
  panels.shallowest = panels.deepest == 0 ? profile.z : std::min(panels.shallowest, profile.z);
  panels.deepest = std::max(panels.deepest, profile.z);
}

}  // namespace

Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "model-classes";
  plan.script = "studies/" + study;
  plan.height = 3.3;
  Panels panels;
  panels.height.add(0);
  std::vector<std::string> shown;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (series[k].aside) continue;
    const std::string stem = fmt::format("{}-{}", plan.id, k + 1), style = series_style(k);
    add_slowing(plan, panels, series[k], stem, style);
    add_theory(plan, panels, series[k], stem, k);
    const ModelResponse& last = series[k].responses.back();
    add_profile(plan, panels, last, stem, k);
    panels.titles.push_back(fmt::format("keyentry with linespoints linewidth 1 pointsize 0.55 {} title {}", style,
                                        gnuplot_string(series[k].name)));
    shown.push_back(last.parameter.empty() ? last.series : fmt::format("{} at {}", last.series, last.parameter));
  }
  if (panels.slowing.empty() || panels.profiles.empty()) {
    throw InputError(
        "the figure of the models has nothing to show, because no model with two peaks was measured; ask for "
        "parameters at which the width of the peaks can be told");
  }
  if (!panels.theory.empty()) panels.titles.push_back(panels.theory);
  const Range D = widened_by_factor(panels.D, 1.4), c = widened_by_factor(panels.c, 1.4);
  return plot_figure(plan,
                     {{"slowing", fmt::format("{}", fmt::join(panels.slowing, ", \\\n    "))},
                      {"profiles", fmt::format("{}", fmt::join(panels.profiles, ", \\\n    "))},
                      {"titles", fmt::format("{}", fmt::join(panels.titles, ", \\\n    "))},
                      {"D_low", exact(D.low)},
                      {"D_high", exact(D.high)},
                      {"D_ticks", log_ticks(D)},
                      {"c_low", exact(c.low)},
                      {"c_high", exact(c.high)},
                      {"c_ticks", log_ticks(c)},
                      {"c0", exact(tan30)},
                      {"height_low", exact(panels.height.low - 0.03 * panels.height.size())},
                      {"height_high", exact(panels.height.high + 0.05 * panels.height.size())},
                      {"height_ticks", linear_ticks(panels.height, 6)}},
                     {"studies/" + study + ".captions",
                      {{"shown", enumeration(shown)},
                       {"exponents", enumeration(panels.exponents)},
                       {"depths", panels.shallowest == panels.deepest
                                      ? caption_number(panels.deepest)
                                      : caption_number(panels.shallowest) + " to " + caption_number(panels.deepest)}}},
                     run_folder);
}

}  // namespace granuscope
