// The figures beside that of the classes: noise against its theory, the mean share of the middle leg, gravity.
#include "studies/model_classes/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/bead_forces.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot_script.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

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

namespace {

/// In the style of a series: its colour, and dashes for lines.
std::string appearance(std::size_t colour, CurveKind kind) {
  const std::string style = series_style(colour);
  if (kind == CurveKind::points) return "points pointsize 0.6 linewidth 1 " + style;
  if (kind == CurveKind::joined_points) return "linespoints pointsize 0.55 linewidth 1 " + style;
  return "lines linewidth 1 " + style.substr(style.find("linecolor"));
}

void add_axis(TemplateVariables& variables, const std::string& name, Range range, bool logarithmic) {
  const std::string ticks = logarithmic ? log_ticks(widened_by_factor(range, 1.3)) : linear_ticks(range, 6);
  const double margin = range.size() > 0 ? 0.06 * range.size() : 0.5;
  const Range shown = logarithmic ? widened_by_factor(range, 1.3)
                                  : Range{range.low == 0 ? 0 : range.low - margin, range.high + margin, false};
  variables[name + "_low"] = exact(shown.low);
  variables[name + "_high"] = exact(shown.high);
  variables[name + "_ticks"] = ticks;
}

void add_panel(TemplateVariables& variables, const std::string& side, const ModelPanel& panel) {
  if (panel.curves.empty()) {
    throw InputError(fmt::format(
        "the panel of {} against {} has nothing to show, because nothing of it was measured well enough; ask for more "
        "samples",
        panel.y_label, panel.x_label));
  }
  variables[side + "_x"] = panel.x_label;
  variables[side + "_y"] = panel.y_label;
  variables[side + "_scale"] = !panel.log_x && !panel.log_y
                                   ? ""
                                   : fmt::format("set logscale {}{}", panel.log_x ? "x" : "", panel.log_y ? "y" : "");
  variables[side + "_curves"] = fmt::format("{}", fmt::join(panel.curves, ", \\\n    "));
  add_axis(variables, side + "_x", panel.x, panel.log_x);
  add_axis(variables, side + "_y", panel.y, panel.log_y);
}

}  // namespace

void add_curve(PlotPlan& plan, ModelPanel& panel, const std::string& name, const CurveRows& rows, CurveKind kind,
               std::size_t colour, const std::string& x_column, const std::string& y_column) {
  if (rows.empty()) return;
  const bool line = kind == CurveKind::line;
  const std::string unit = y_column.substr(y_column.find(':'));
  CsvTable table(line ? std::vector<std::string>{x_column, y_column}
                      : std::vector<std::string>{x_column, y_column, "standard_error" + unit});
  for (const auto& [x, y, error] : rows) {
    table.add_row(line ? std::vector<double>{x, y} : std::vector<double>{x, y, error});
    panel.x.add(x);
    // With its bar, where that is not the whole of a logarithmic axis.
    for (const double end : {y - error, y, y + error}) {
      if (end > 0 || !panel.log_y) panel.y.add(end);
    }
  }
  const std::string file = fmt::format("{}-{}.csv", plan.id, name), with = appearance(colour, kind);
  plan.data[file] = table.text();
  if (!line) {
    const std::string bars = kind == CurveKind::points ? "yerrorbars" : "yerrorlines";
    panel.curves.push_back(
        fmt::format("'{}' using 1:2:3 with {} {} notitle", file, bars, with.substr(with.find(' ') + 1)));
  } else {
    panel.curves.push_back(fmt::format("'{}' using 1:2 with {} notitle", file, with));
  }
  ++plan.curves;
}

std::string key_entry(const std::string& title, std::size_t colour, CurveKind kind) {
  return fmt::format("keyentry with {} title {}", appearance(colour, kind), gnuplot_string(title));
}

Figure plot_panels(PlotPlan plan, const ModelPanel& left, const ModelPanel& right,
                   const std::vector<std::string>& titles, const Wording& wording,
                   const std::filesystem::path& run_folder) {
  plan.script = "studies/model_panels";
  plan.height = 3.2;
  TemplateVariables variables = {{"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))}};
  add_panel(variables, "left", left);
  add_panel(variables, "right", right);
  return plot_figure(plan, variables, wording, run_folder);
}

namespace {

PlotPlan plan_of(const char* id) {
  PlotPlan plan;
  plan.id = id;
  return plan;
}

Wording wording_of(const PlotPlan& plan, TemplateVariables variables = {}) {
  std::string file = plan.id;
  for (char& letter : file) letter = letter == '-' ? '_' : letter;
  return {"studies/" + file + ".captions", std::move(variables)};
}

}  // namespace

namespace {

/// What one series adds to the figure of the noise.
struct NoiseRows {
  CurveRows thrust, speed, spreading;
  NoiseTheory theory;  ///< of the strongest noise
  bool narrow = false;
};

NoiseRows noise_rows(const ModelSeries& series) {
  NoiseRows rows;
  for (const ModelResponse& one : series.responses) {
    if (!one.theory || !one.speed_loss.known() || !one.thrust_loss.known()) continue;
    const double x = one.theory->disorder * one.theory->disorder;
    if (one.theory->disorder == rows.theory.disorder) return {};  // grids of one noise have no law in it
    rows.thrust.push_back({x, one.thrust_loss.value, one.thrust_loss.standard_error});
    rows.speed.push_back({x, one.speed_loss.value, one.speed_loss.standard_error});
    rows.spreading.push_back({x, one.spreading_gain.value, one.spreading_gain.standard_error});
    rows.theory = *one.theory;
    rows.narrow = one.theory->narrow && one.width < one.theory->cell;
  }
  return rows;
}

}  // namespace

Figure plot_noise(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder) {
  PlotPlan plan = plan_of("model-noise");
  ModelPanel loss{.x_label = "Δ²", .y_label = "1 − c²/c₀²", .x = {}, .y = {}, .curves = {}};
  ModelPanel gain{.x_label = "Δ²", .y_label = "D − D₀  (bead diameters)", .x = {}, .y = {}, .curves = {}};
  for (ModelPanel* panel : {&loss, &gain}) panel->x.add(0), panel->y.add(0);
  std::vector<std::string> titles, factors;
  std::size_t colour = 0;
  for (const ModelSeries& one : series) {
    const NoiseRows rows = noise_rows(one);
    if (rows.thrust.size() < 2) continue;
    const double end = rows.thrust.back()[0];
    const auto add = [&](ModelPanel& panel, const std::string& what, const CurveRows& points, double slope,
                         const std::string& column) {
      const std::string name = fmt::format("{}-{}", colour, what), x = "disorder_squared: dimensionless";
      add_curve(plan, panel, name, points, CurveKind::points, colour, x, column);
      const CurveRows line = {{0, 0, 0}, {end, slope * end, 0}};
      add_curve(plan, panel, name + "-theory", line, CurveKind::line, colour, x, column);
    };
    const NoiseShift& of_peaks = rows.narrow ? *rows.theory.narrow : rows.theory.wide;
    add(loss, "thrust", rows.thrust, rows.theory.wide.kappa, "thrust_loss: dimensionless");
    titles.push_back(key_entry(one.name + ": thrust", colour, CurveKind::points));
    ++colour;
    add(loss, "speed", rows.speed, of_peaks.kappa, "speed_loss: dimensionless");
    add(gain, "spreading", rows.spreading, of_peaks.spreading, "D_gain: bead diameters");
    titles.push_back(key_entry(one.name + ": peaks", colour, CurveKind::points));
    ++colour;
    factors.push_back(fmt::format("κ = {:.3g} for long waves, {:.3g} and D − D₀ = {:.3g} Δ² for these peaks ({})",
                                  rows.theory.wide.kappa, of_peaks.kappa, of_peaks.spreading, one.name));
  }
  return plot_panels(plan, loss, gain, titles, wording_of(plan, {{"factors", enumeration(factors)}}), run_folder);
}

Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder) {
  PlotPlan plan = plan_of("model-middle");
  ModelPanel speed{.x_label = "mean share ⟨p⟩ of the middle leg", .y_label = "c", .x = {}, .y = {}, .curves = {}};
  ModelPanel depth{.x_label = "mean share p of the middle leg",
                   .y_label = "depth of tractions  (bead diameters)",
                   .x = {},
                   .y = {},
                   .log_y = true,
                   .curves = {}};
  std::vector<std::string> titles;
  std::size_t colour = 0;
  const std::string middle = "mean_middle: dimensionless";
  for (const ModelSeries& one : series) {
    CurveRows rows;
    for (const ModelResponse& response : one.responses) {
      if (one.aside || !response.middle.known() || !response.c.known()) continue;
      rows.push_back({response.middle.value, response.c.value, response.c.standard_error});
    }
    if (rows.empty()) continue;
    ++colour;
    add_curve(plan, speed, fmt::format("{}-speed", colour), rows, CurveKind::points, colour, middle,
              "c: dimensionless");
    titles.push_back(key_entry(one.name, colour, CurveKind::points));
  }
  CurveRows mean_alone;
  for (int k = 0; k <= 40; ++k) {
    const double p = speed.x.low + speed.x.size() * k / 40;
    mean_alone.push_back({p, tan30 * std::sqrt(1 - p), 0});
  }
  add_curve(plan, speed, "mean-alone", mean_alone, CurveKind::line, 0, middle, "c: dimensionless");
  titles.push_back(key_entry("c₀ √(1 − ⟨p⟩)", 0, CurveKind::line));
  std::map<int, CurveRows> by_noise;  // in per cent of the mean
  for (const TractionDepth& one : tractions) {
    if (!one.z.known()) continue;
    by_noise[static_cast<int>(std::lround(100 * one.noise / one.middle))].push_back(
        {one.middle, one.z.value, one.z.standard_error});
  }
  for (const auto& [noise, rows] : by_noise) {
    ++colour;
    add_curve(plan, depth, fmt::format("tractions-{}", noise), rows, CurveKind::joined_points, colour,
              "middle: dimensionless", "depth: bead diameters");
    titles.push_back(key_entry(fmt::format("p ± {} %", noise), colour, CurveKind::joined_points));
  }
  return plot_panels(plan, speed, depth, titles,
                     wording_of(plan, {{"columns", fmt::format("{}", tractions.front().columns)}}), run_folder);
}

Figure render_pile_of(const ModelSeries& series, const std::filesystem::path& run_folder) {
  constexpr double depth = 40;  // bead diameters: two pictures share a row of the printed report
  constexpr double darkest = 3;
  const ModelResponse& one = series.responses.back();
  const RowGeometry rows = rows_of(one.sampler.model);
  WeightsPicture picture;
  picture.id = "pile-of-";
  for (const char letter : series.name) {
    if (letter == ' ' || letter == ',') {
      if (picture.id.back() != '-') picture.id += '-';
    } else {
      picture.id += letter;
    }
  }
  picture.pile.sampler = one.sampler;
  picture.pile.lattice = {64, static_cast<int>((depth - rows.depth(0)) / rows.spacing) + 1 + bottom_margin};
  picture.pile.load = Load::uniform;
  picture.depth = depth;
  picture.scene = ForceChainSpec{}.scene;
  picture.scene.backend = "none";  // no window of a GL context for so little
  picture.scene.range = {{0, darkest}};
  picture.wording = {"studies/model_pile.captions",
                     {{"series", series.name},
                      {"parameter", one.parameter},
                      {"columns", std::to_string(picture.pile.lattice.columns)},
                      {"seed", std::to_string(one.sampler.seed)}}};
  picture.redraw = "cp experiment.toml again.toml && granuscope run again.toml --out . --only analyse --only plot";
  SceneStatistics statistics;
  return render_weights(picture, run_folder, statistics);
}

Figure plot_gravity(const std::vector<ModelSeries>& series, const std::filesystem::path& run_folder) {
  PlotPlan plan = plan_of("model-gravity");
  ModelPanel stress{.x_label = "depth z  (bead diameters)",
                    .y_label = "stresses  (loads of one top bead)",
                    .x = {},
                    .y = {},
                    .log_y = true,
                    .curves = {}};
  ModelPanel profile{.x_label = "x/z", .y_label = "z P(x, z)", .x = {}, .y = {}, .curves = {}};
  std::vector<std::string> titles;
  const ModelResponse* light = nullptr;
  double deepest = 0;
  std::size_t colour = 0;
  const auto add = [&](const ModelResponse& one) {
    CurveRows horizontal, vertical, response;
    for (const StressAtDepth& at : one.stress) {
      if (!at.thrust_ratio.known()) continue;
      horizontal.push_back({at.z, at.weight * at.thrust_ratio.value, at.weight * at.thrust_ratio.standard_error});
      vertical.push_back({at.z, at.weight, 0});
    }
    const std::string name = fmt::format("g-{}", exact(one.bead_weight)), z_column = "z: bead diameters";
    add_curve(plan, stress, name + "-horizontal", horizontal, CurveKind::points, colour, z_column,
              "three_sigma_xx: loads of one top bead");
    add_curve(plan, stress, name + "-vertical", vertical, CurveKind::line, colour, z_column,
              "sigma_zz: loads of one top bead");
    // Where less is known of the peaks the response is lost in the noise of what beads weigh.
    constexpr double most_uncertain = 0.01;
    if (one.profile && one.c.known() && one.c.standard_error < most_uncertain) {
      const double z = deepest = one.profile->z;
      for (std::size_t i = 0; i < one.profile->x.size(); ++i) {
        if (std::abs(one.profile->x[i]) < z) {
          response.push_back({one.profile->x[i] / z, z * one.profile->pressure[i], 0});
        }
      }
      add_curve(plan, profile, name + "-response", response, CurveKind::line, colour, "x_over_z: dimensionless",
                "z_response: dimensionless");
    }
    titles.push_back(key_entry(fmt::format("g = {}", one.bead_weight), colour, CurveKind::joined_points));
    ++colour;
  };
  for (const ModelSeries& one : series) {
    for (const ModelResponse& response : one.responses) {
      if (!one.aside && !response.stress.empty()) light = &response;  // that of the largest mu
    }
  }
  if (light != nullptr) add(*light);
  for (const ModelSeries& one : series) {
    for (const ModelResponse& response : one.responses) {
      if (response.bead_weight > 0) add(response);
    }
  }
  return plot_panels(
      plan, stress, profile, titles,
      wording_of(plan, {{"parameter", light == nullptr ? "" : light->parameter}, {"depth", caption_number(deepest)}}),
      run_folder);
}

}  // namespace granuscope
