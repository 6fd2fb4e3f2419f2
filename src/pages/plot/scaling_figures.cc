#include "plot/scaling_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr const char* scaling_id = "scaling-with-friction";

std::vector<PowerLawPoint> diffusion_points(const OtherReading& reading) {
  std::vector<PowerLawPoint> points;
  for (const auto& one : reading.points) {
    if (one.D.known()) points.push_back({one.mu, one.mu, 0, one.D.value, one.D.standard_error});
  }
  return points;
}

std::vector<PowerLawPoint> slowing_points(const OtherReading& reading) {
  std::vector<PowerLawPoint> points;
  for (const auto& one : reading.points) {
    if (one.c.known()) points.push_back({one.mu, one.mu, 0, reading.c0 - one.c.value, one.c.standard_error});
  }
  return points;
}

std::string note(const std::string& how, const std::string& symbol, const ScalingFit& fit) {
  return fmt::format("{}: {} {}{}", how, symbol, fit.exponent.known() ? "= " : "", exponent_text(fit));
}

std::string in_words(const ScalingFit& fit) {
  return fit.exponent.known() ? exponent_text(fit) : fmt::format("unknown ({})", fit.exponent.reason);
}

}  // namespace

Figure plot_scaling_with_friction(const Analysis& analysis, const std::filesystem::path& run_folder) {
  std::vector<OtherReading> readings{slopes_of(analysis)};
  const auto second =
      std::ranges::find_if(analysis.readings, [](const OtherReading& one) { return one.id == "at_one_depth"; });
  if (second != analysis.readings.end()) readings.push_back(*second);

  PowerLawPanel D;
  D.id = "D-of-mu";
  D.x_label = "friction coefficient μ";
  D.y_label = "D  (bead diameters)";
  D.y_unit = "bead diameters";
  D.against_mu = true;
  D.left = 0.105;
  D.right = 0.49;
  D.paper_exponent = "2.5";
  PowerLawPanel c = D;
  c.id = "c-of-mu";
  c.y_label = "c₀ − c";
  c.left = 0.60;
  c.right = 0.985;
  c.paper_exponent = "1";
  for (const OtherReading& one : readings) {
    D.series.push_back({one.id, diffusion_points(one), one.fits.beta});
    c.series.push_back({one.id, slowing_points(one), one.fits.gamma});
    D.notes.push_back(note(one.label, "β", one.fits.beta));
    c.notes.push_back(note(one.label, "γ", one.fits.gamma));
  }
  D.notes.resize(2);  // the third has the colour of the guide
  c.notes.resize(2);
  D.notes.emplace_back("the paper: β ≈ 2.5");
  c.notes.emplace_back("the paper: γ = 1");

  Plot plot;
  plot.id = scaling_id;
  plot.height = 3.3;
  plot.key = {.inches = 0.66, .lines = 3, .sample = 2.2, .small = false, .entries = {}};
  const PowerLawShown left = add_power_law_panel(plot, D), right = add_power_law_panel(plot, c);
  if (!left.shown && !right.shown) {
    throw InputError(
        "the figure of D and c0 - c against mu has nothing to show, because no friction coefficient has a positive "
        "one; use more samples or deeper layers, or switch the figure off");
  }
  const Ink blue{"blue", 7};
  plot.add_key("slopes over the depth window", blue.points(0.55));
  if (left.law || right.law) plot.add_key("power law fitted to them", blue.line(1.8));
  if (left.second || right.second) plot.add_key(readings.back().label, Ink{"vermilion", 13}.points(0.6));
  plot.add_key("slope of the paper's exponent", {.width = 1.4, .dash = 3});
  if (left.outside || right.outside) plot.add_key("open: outside the window", Ink{"blue", 6}.points(0.55));
  std::vector<std::string> off_scale = {off_scale_in_words(left, "D"), off_scale_in_words(right, "c₀ − c")};
  std::erase(off_scale, "");
  const ScalingFits& other = readings.back().fits;
  return plot_figure(plot,
                     {"plot/scaling_with_friction.captions",
                      {{"low", caption_number(analysis.scaling.beta.window[0])},
                       {"high", caption_number(analysis.scaling.beta.window[1])},
                       {"beta", left.shown ? in_words(analysis.scaling.beta) : ""},
                       {"gamma", right.shown ? in_words(analysis.scaling.gamma) : ""},
                       {"ratios", left.second || right.second ? readings.back().label : ""},
                       {"ratio_beta", in_words(other.beta)},
                       {"ratio_gamma", in_words(other.gamma)},
                       {"off_scale", enumeration(off_scale)}},
                      terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

namespace {

constexpr const char* diffusion_id = "propagation-against-diffusion";

bool has_both(const Transport& result) { return result.c.known() && result.D.known(); }

bool fits_log_axes(const Transport& result) {
  return has_both(result) && !result.exact && result.D.value > 0 && result.c.value < result.c0();
}

std::string mu_text(const Transport& result) { return "μ = " + caption_number(result.scanned()); }

/// c against D on a logarithmic axis, on which a pile without friction has no place: the line of c0 stands for it.
bool has_place(const Transport& result) { return has_both(result) && !result.exact && result.D.value > 0; }

struct ScalingAxes {
  Range D, c;
  double c0 = tan30;

  double across(double diffusion) const { return std::log(diffusion / D.low) / std::log(D.high / D.low); }
  double up(double speed) const { return (speed - c.low) / c.size(); }
};

/// Where an error bar of D ends on a logarithmic axis, though D may be 0 within its error.
double lower_end(const Estimate& D) { return std::max(D.value - D.standard_error, D.value / 3); }

ScalingAxes make_axes(const std::vector<Transport>& results) {
  ScalingAxes axes;
  if (!results.empty()) axes.c0 = results.front().c0();
  axes.c.add(axes.c0);
  for (const Transport& result : results) {
    if (!has_place(result)) continue;
    axes.D.add(lower_end(result.D));
    axes.D.add(result.D.value + result.D.standard_error);
    axes.c.add(result.c.value, result.c.standard_error);
  }
  const double c_size = std::max(axes.c.size(), 0.001);
  axes.D = widened_by_factor(axes.D, 1.25);
  axes.c.low -= 0.07 * c_size;
  axes.c.high += 0.12 * c_size;  // room for the name of the point on the line of c0
  return axes;
}

/// The height of both panels together, in inches, as the script lays them out.
constexpr double figure_height = 3.3, panel_height = 2.24, upper_panel_height = 1.61;

/// "0.3" beside every point of the left panel.
void name_points(Panel& shown, const std::vector<Transport>& results, const ScalingAxes& axes, const ScalingFit& alpha,
                 const Range& window_D) {
  const double room = room_for_labels(shown.y.ticks, shown.left - shown.name);
  LabelledPanel panel{(shown.right - shown.left - room) * plot_width_inches, panel_height, {}, {}};
  std::vector<NamedPoint> points;
  const auto place = [&axes](double D, double c) { return PanelPlace{axes.across(D), axes.up(c)}; };
  panel.lines.push_back({place(axes.D.low, axes.c0), place(axes.D.high, axes.c0)});
  if (alpha.exponent.known() && alpha.intercept.known() && window_D.size() > 0) {
    const auto law = [&](double D) {
      return place(D, axes.c0 - std::exp(alpha.intercept.value) * std::pow(D, alpha.exponent.value));
    };
    constexpr int pieces = 16;
    for (int k = 0; k < pieces; ++k) {
      const double step = std::pow(window_D.high / window_D.low, 1.0 / pieces), from = std::pow(step, k);
      panel.lines.push_back({law(window_D.low * from), law(window_D.low * from * step)});
    }
  }
  for (const Transport& result : results) {
    if (!has_place(result)) continue;
    const double c = result.c.value, error = result.c.standard_error;
    points.push_back({place(result.D.value, c),
                      range_of(axes.across(lower_end(result.D)), axes.across(result.D.value + result.D.standard_error)),
                      range_of(axes.up(c - error), axes.up(c + error)), caption_number(result.scanned())});
  }
  add_names(shown, points, panel);
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
    slopes.points.push_back({result.scanned(), result.D.value, result.D.standard_error, result.c0() - result.c.value,
                             result.c.standard_error});
  }
  panel.series.push_back(slopes);
  panel.notes = {alpha.exponent.known() ? "this run: α = " + exponent_text(alpha) : "", "", "the paper: α = 0.4"};
  return panel;
}

}  // namespace

Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder) {
  const std::vector<std::string> columns{"mu: dimensionless", "D: bead diameters", "D_standard_error: bead diameters",
                                         "c: dimensionless", "c_standard_error: dimensionless"};
  CsvTable inside(columns), outside(columns);
  for (const Transport& result : analysis.results) {
    if (!has_place(result)) continue;
    (in_window(result.scanned(), analysis.scaling.alpha.window) ? inside : outside)
        .add_row({result.scanned(), result.D.value, result.D.standard_error, result.c.value, result.c.standard_error});
  }
  if (inside.empty() && outside.empty()) {
    throw InputError(
        "the figure of c against D has nothing to show, because no friction coefficient has both; use more samples or "
        "deeper layers, or switch the figure off");
  }
  Plot plot;
  plot.id = diffusion_id;
  plot.height = figure_height;
  plot.key = {.inches = 0.5, .lines = 2, .sample = 2.2, .small = false, .entries = {}};

  const ScalingFit& alpha = analysis.scaling.alpha;
  Range window_D;
  for (const Transport& result : analysis.results) {
    if (fits_log_axes(result) && in_window(result.scanned(), alpha.window)) window_D.add(result.D.value);
  }
  const ScalingAxes axes = make_axes(analysis.results);
  const Ink blue{"blue", 7};
  Panel left = left_panel();
  left.right = 0.49;
  left.x = log_axis("diffusion coefficient D  (bead diameters)", axes.D);
  left.y = linear_axis("propagation coefficient c", axes.c, 7);
  name_points(left, analysis.results, axes, alpha, window_D);
  left.add_level(axes.c0, {.colour = "frame", .width = 0.8});
  if (!inside.empty()) left.add(plot.add_data("points", inside), "2:4:3:5", blue.both_bars(0.8, 0.5));
  if (!outside.empty())
    left.add(plot.add_data("points-outside", outside), "2:4:3:5", Ink{"blue", 6}.both_bars(0.8, 0.5));
  plot.panels.push_back(left);
  const PowerLawShown law = add_power_law_panel(plot, law_panel(analysis));
  const bool with_law = law.law && window_D.size() > 0;
  if (with_law) {
    std::vector<Curve>& curves = plot.panels.front().curves;
    curves.insert(curves.begin(), {"", "",
                                   fmt::format("{} - exp({}) * $1**{}", exact(axes.c0), exact(alpha.intercept.value),
                                               exact(alpha.exponent.value)),
                                   window_D.low, window_D.high, blue.line(1.8)});
  }
  plot.add_key("measured at each μ", blue.points(0.55));
  plot.add_key("c₀ = tan 30°", {.colour = "frame", .width = 0.8});
  if (with_law) plot.add_key("fitted power law", blue.line(1.8));
  plot.add_key("the paper's exponent", {.width = 1.4, .dash = 3});
  if (law.outside || !outside.empty()) plot.add_key("outside the window", Ink{"blue", 6}.points(0.55));
  return plot_figure(
      plot,
      {"plot/propagation_against_diffusion.captions",
       {{"not_logarithmic", with_reasons(reasons_off_log_axes(analysis.results))},
        {"unknown", with_reasons(unknown_points(analysis.results))},
        {"slower", alpha.exponent.known() && alpha.exponent.value > 3 * alpha.exponent.standard_error ? "yes" : ""},
        {"law_panel", law.shown ? "yes" : ""},
        {"alpha", with_law ? exponent_text(alpha) : ""},
        {"alpha_low", caption_number(alpha.window[0])},
        {"alpha_high", caption_number(alpha.window[1])},
        {"alpha_reason", alpha.exponent.known() ? "fewer than two points lie in its window" : alpha.exponent.reason},
        {"off_scale", off_scale_in_words(law, "")}},
       terms_of(*analysis.scan, analysis.angle())},
      run_folder);
}

namespace {

constexpr const char* thrust_id = "propagation-and-thrust";

bool has_both_speeds(const Transport& result) {
  return result.c.known() && result.c_thrust.known() && result.c_minus_c_thrust.known();
}

/// An axis with a margin at both ends.
Range with_margins(Range data, double least) {
  const double size = std::max(data.size(), least);
  data.low -= 0.07 * size;
  data.high += 0.07 * size;
  return data;
}

}  // namespace

Figure plot_propagation_and_thrust(const Analysis& analysis, const std::filesystem::path& run_folder) {
  CsvTable table({"mu: dimensionless", "c: dimensionless", "c_standard_error: dimensionless", "c_thrust: dimensionless",
                  "c_thrust_standard_error: dimensionless", "difference: dimensionless",
                  "difference_standard_error: dimensionless"});
  Range mu, speed, difference;
  mu.add(0);
  speed.add(analysis.c0());
  difference.add(0);
  std::vector<LeftOut> unknown;
  std::vector<std::string> beyond_three;
  for (const Transport& result : analysis.results) {
    const std::string mu_text = caption_number(result.scanned());
    if (!has_both_speeds(result)) {
      const std::string& reason = result.c.known() ? result.c_thrust.reason : result.c.reason;
      unknown.push_back({"μ = " + mu_text, reason});
      continue;
    }
    const Estimate& gap = result.c_minus_c_thrust;
    table.add_row({result.scanned(), result.c.value, result.c.standard_error, result.c_thrust.value,
                   result.c_thrust.standard_error, gap.value, gap.standard_error});
    mu.add(result.scanned());
    if (std::abs(gap.value) > 3 * gap.standard_error && !result.exact) beyond_three.push_back(mu_text);
    speed.add(result.c.value, result.c.standard_error);
    speed.add(result.c_thrust.value);
    difference.add(gap.value, gap.standard_error);
  }
  if (table.empty()) {
    throw InputError(
        "the figure of c beside c_thrust has nothing to show, because no friction coefficient has both; use more "
        "samples or deeper layers, or switch the figure off");
  }
  Plot plot;
  plot.id = thrust_id;
  plot.height = 2.4;
  plot.key = {.inches = 0.34, .horizontal = true, .centred = true, .sample = 2, .small = false, .entries = {}};
  const std::string file = plot.add_data("", table);
  const Style level{.colour = "frame", .width = 0.8};
  const Ink peaks{"blue", 7}, thrust{"bluish_green", 12}, gap{"black", 7};
  Panel left = left_panel(), right = right_panel();
  left.x = right.x = linear_axis("friction coefficient μ", with_margins(mu, 0.01), 6);
  left.y = linear_axis("speed", with_margins(speed, 0.002), 6);
  left.add_level(analysis.c0(), level);
  left.add(file, "1:4:5", thrust.bars(0.9, 0.7));
  left.add(file, "1:2:3", peaks.bars(0.9, 0.5));
  right.left = 0.605;
  right.name = 0.512;
  right.y = linear_axis("difference", with_margins(difference, 0.001), 6);
  right.add_level(0, level);
  right.add(file, "1:6:7", gap.bars(0.9, 0.5));
  plot.panels = {left, right};
  plot.add_key("slope c of the peaks", peaks.points(0.55));
  plot.add_key("from the thrust ratio", thrust.points(0.7));
  plot.add_key("c₀", level);
  plot.add_key("difference", gap.points(0.55));
  return plot_figure(plot,
                     {"plot/propagation_and_thrust.captions",
                      {{"unknown", with_reasons(unknown)},
                       {"beyond_three", beyond_three.empty() ? "" : "μ = " + enumeration(beyond_three)}},
                      terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

}  // namespace granuscope
