#include "plot/main_finding.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/claims.h"
#include "model/lattice.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/power_law_panel.h"
#include "plot/scaling_figures.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr double height_inches = 72 / 25.4;

/// c_0 - c of a reading against mu, or against D, as far as logarithmic axes show it.
std::vector<PowerLawPoint> points_of(const OtherReading& reading, bool against_D) {
  std::vector<PowerLawPoint> points;
  for (const OtherReading::Point& one : reading.points) {
    const PowerLawPoint point{one.mu, against_D ? one.D.value : one.mu, against_D ? one.D.standard_error : 0,
                              reading.c0 - one.c.value, one.c.standard_error};
    if (one.c.known() && one.D.known() && fits_log_axes(point)) points.push_back(point);
  }
  return points;
}

}  // namespace

bool has_exponents(const Analysis& analysis) {
  const auto any = [](const ScalingFits& fits) {
    return fits.beta.exponent.known() || fits.gamma.exponent.known() || fits.alpha.exponent.known();
  };
  return any(analysis.scaling) ||
         std::ranges::any_of(analysis.readings, [&](const OtherReading& one) { return any(one.fits); });
}

bool has_main_finding(const Analysis& analysis) {
  return has_exponents(analysis) && points_of(slopes_of(analysis), false).size() > 1;
}

Figure plot_main_finding(const Analysis& analysis, const std::filesystem::path& run_folder) {
  if (!has_main_finding(analysis)) {
    throw InputError(
        "the figure of c0 - c has nothing to show, because fewer than two friction coefficients have a c below c0; use "
        "more samples or deeper layers");
  }
  // Reading at one depth lies above the slopes, small friction below them.
  std::vector<std::pair<OtherReading, Ink>> readings{{slopes_of(analysis), {"blue", 7}}};
  for (const OtherReading& one : analysis.readings) {
    if (points_of(one, true).size() < 2 || !one.fits.gamma.exponent.known() || !one.fits.alpha.exponent.known())
      continue;
    if (one.id == "at_one_depth") {
      readings.insert(readings.begin(), {one, {"vermilion", 13}});
    } else {
      readings.push_back({one, {"dark_blue", 9}});
    }
  }
  Plot plot;
  plot.id = main_finding_id;
  plot.height = height_inches;
  for (const bool against_D : {false, true}) {
    PowerLawPanel panel;
    panel.id = against_D ? "alpha" : "gamma";
    panel.x_label = against_D ? "diffusion coefficient D (bead diameters)" : "friction coefficient μ";
    panel.x_unit = against_D ? "bead diameters" : "dimensionless";
    panel.y_label = "c₀ − c";
    panel.left = against_D ? 0.575 : 0.075;
    panel.right = panel.left + 0.41;
    panel.paper_exponent = against_D ? paper_alpha.value : paper_gamma.value;
    panel.paper_note = against_D ? "the paper: α = 0.4" : "the paper: γ = 1";
    if (against_D) panel.guide_exponent = linear_in_D.value;
    panel.guide_note = "dashed, stochastic theory: α = 1";
    for (const auto& [reading, ink] : readings) {
      const ScalingFit& fit = against_D ? reading.fits.alpha : reading.fits.gamma;
      panel.series.push_back({reading.id, points_of(reading, against_D), fit, ink,
                              fmt::format("{}: {} = {}", reading.label, against_D ? "α" : "γ", exponent_text(fit))});
    }
    add_power_law_panel(plot, panel);
  }

  TemplateVariables variables{{"left_out", with_reasons(points_left_out(analysis.results, true))}};
  for (const char* symbol : {"gamma", "alpha"}) {
    for (const std::string id : {"at_one_depth", "limit"}) variables[id + "_" + symbol] = "";
  }
  for (const char* name : {"at_one_depth_label", "limit_low", "limit_high"}) variables[name] = "";
  for (const auto& [reading, ink] : readings) {
    const bool slopes = reading.id == "slopes", one_depth = reading.id == "at_one_depth";
    const std::string name = slopes || one_depth ? reading.id + "_" : "limit_";  // of small friction
    if (one_depth) variables[name + "label"] = reading.label;
    for (const auto& [symbol, fit] :
         {std::pair("gamma", &reading.fits.gamma), std::pair("alpha", &reading.fits.alpha)}) {
      variables[name + symbol] = fit->exponent.known() ? exponent_text(*fit) : "";
      if (slopes) variables[name + symbol + "_reason"] = fit->exponent.reason;
    }
    if (one_depth) continue;
    variables[name + "low"] = caption_number(reading.fits.gamma.window[0]);
    variables[name + "high"] = caption_number(reading.fits.gamma.window[1]);
  }
  return plot_figure(plot, {"plot/main_finding.captions", variables, terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

}  // namespace granuscope
