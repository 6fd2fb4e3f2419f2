#include "plot/scaling_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr const char* scaling_id = "scaling-with-friction";
/// Of the plots of one panel with what lies over the law below it, inches.
constexpr double half_height = 2.9;

std::string in_words(const ScalingFit& fit) {
  return fit.exponent.known() ? exponent_text(fit) : fmt::format("unknown ({})", fit.exponent.reason);
}

/// Half as wide as the page. Throws InputError where no point is shown: "the figure of", `nothing`.
PowerLawShown fill_half(Plot& plot, const PowerLawPanel& panel, const char* nothing) {
  plot.height = half_height;
  plot.half_width = true;
  PowerLawShown shown = add_power_law_panel(plot, panel);
  if (shown.shown) return shown;
  throw InputError("the figure of {}; use more samples or deeper layers, or switch the figure off", nothing);
}

}  // namespace

Figure plot_scaling_with_friction(const Analysis& analysis, const std::filesystem::path& run_folder) {
  PowerLawPanel panel;
  panel.id = "D-of-mu";
  panel.x_label = "friction coefficient μ";
  panel.y_label = "D  (bead diameters)";
  panel.y_unit = "bead diameters";
  panel.paper_exponent = 2.5;
  panel.paper_note = "the paper: β ≈ 2.5";
  panel.ratios = true;
  const auto add = [&](const OtherReading& reading, const Ink& ink) {
    std::vector<PowerLawPoint> points;
    for (const auto& [mu, c, D] : reading.points) {
      if (D.known()) points.push_back({mu, mu, 0, D.value, D.standard_error});
    }
    const ScalingFit& fit = reading.fits.beta;
    panel.series.push_back(
        {reading.id, points, fit, ink,
         fmt::format("{}: β {}{}", reading.label, fit.exponent.known() ? "= " : "", exponent_text(fit))});
  };
  const auto second =
      std::ranges::find_if(analysis.readings, [](const OtherReading& one) { return one.id == "at_one_depth"; });
  const bool ratios = second != analysis.readings.end();
  if (ratios) add(*second, {"vermilion", 13});
  add(slopes_of(analysis), {"blue", 7});

  Plot plot;
  plot.id = scaling_id;
  const PowerLawShown shown =
      fill_half(plot, panel, "D against mu has nothing to show, because no friction coefficient has a positive one");
  const ScalingFit& beta = analysis.scaling.beta;
  return plot_figure(plot,
                     {"plot/scaling_with_friction.captions",
                      {{"low", caption_number(beta.window[0])},
                       {"high", caption_number(beta.window[1])},
                       {"beta", in_words(beta)},
                       {"ratios", ratios ? second->label : ""},
                       {"ratio_beta", ratios ? in_words(second->fits.beta) : ""},
                       {"off_scale", shown.off_scale}},
                      terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

namespace {

constexpr const char* diffusion_id = "propagation-against-diffusion";

bool has_both(const Transport& result) { return result.c.known() && result.D.known(); }

/// On a logarithmic axis of D; a pile without friction has no place there: the line of c0 stands for it.
bool has_place(const Transport& result) { return has_both(result) && !result.exact && result.D.value > 0; }

}  // namespace

std::vector<LeftOut> points_left_out(const std::vector<Transport>& results, bool of_slowing) {
  std::vector<LeftOut> left_out;
  for (const Transport& result : results) {
    const std::string why = result.exact                                  ? (of_slowing ? "" : "exact")
                            : !result.D.known()                           ? result.D.reason
                            : !result.c.known()                           ? result.c.reason
                            : result.D.value <= 0                         ? "D is not positive"
                            : of_slowing && result.c.value >= result.c0() ? "c₀ − c is not positive"
                                                                          : "";
    if (!why.empty()) left_out.push_back({"μ = " + caption_number(result.scanned()), why});
  }
  return left_out;
}

Figure plot_propagation_against_diffusion(const Analysis& analysis, const std::filesystem::path& run_folder) {
  const ScalingFit& alpha = analysis.scaling.alpha;
  PowerLawPanel panel;
  panel.id = "c-of-D";
  panel.x_label = "diffusion coefficient D  (bead diameters)";
  panel.y_label = "propagation coefficient c";
  panel.x_unit = "bead diameters";
  panel.level = analysis.c0();
  panel.level_note = "c₀ = tan 30°";
  panel.ratios = true;
  PowerLawSeries slopes{"slopes", {}, alpha, {"blue", 7}, ""};
  for (const Transport& result : analysis.results) {
    if (!has_place(result)) continue;
    slopes.points.push_back({result.scanned(), result.D.value, result.D.standard_error, panel.level - result.c.value,
                             result.c.standard_error});
  }
  if (alpha.exponent.known()) slopes.note = "slopes: α = " + exponent_text(alpha);
  panel.series.push_back(slopes);
  Plot plot;
  plot.id = diffusion_id;
  const PowerLawShown shown =
      fill_half(plot, panel, "c against D has nothing to show, because no friction coefficient has both");
  return plot_figure(
      plot,
      {"plot/propagation_against_diffusion.captions",
       {{"left_out", with_reasons(points_left_out(analysis.results, false))},
        {"slower", alpha.exponent.known() && alpha.exponent.value > 3 * alpha.exponent.standard_error ? "yes" : ""},
        {"alpha", shown.law ? exponent_text(alpha) : ""},
        {"alpha_low", caption_number(alpha.window[0])},
        {"alpha_high", caption_number(alpha.window[1])},
        {"alpha_reason", alpha.exponent.known() ? "fewer than two points lie in its window" : alpha.exponent.reason},
        {"off_scale", shown.off_scale}},
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
  plot.height = 2.1;
  plot.key = {.inches = 0.34, .horizontal = true, .centred = true, .sample = 2, .entries = {}};
  const std::string file = plot.add_data("", table);
  const Style level{.colour = "frame", .width = 0.8};
  const Ink peaks{"blue", 7}, thrust{"bluish_green", 13};
  Panel left = left_panel(), right = right_panel();
  left.x = right.x = linear_axis("friction coefficient μ", with_margins(mu, 0.01), 6);
  left.y = linear_axis("speed", with_margins(speed, 0.002), 6);
  left.add_level(analysis.c0(), level);
  left.add(file, "1:4:5", thrust.bars(0.9, 0.8));
  left.add(file, "1:2:3", peaks.bars(0.9, 0.5));
  right.y = linear_axis("c − c₀√κ", with_margins(difference, 0.001), 6);
  right.add_level(0, level);
  right.add(file, "1:6:7", peaks.bars(0.9, 0.5));
  plot.panels = {left, right};
  plot.add_key("slope c of the peaks", peaks.points(0.55));
  plot.add_key("from the thrust ratio", thrust.points(0.7));
  plot.add_key("c₀", level);
  return plot_figure(plot,
                     {"plot/propagation_and_thrust.captions",
                      {{"unknown", with_reasons(unknown)},
                       {"beyond_three", beyond_three.empty() ? "" : "μ = " + enumeration(beyond_three)}},
                      terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

}  // namespace granuscope
