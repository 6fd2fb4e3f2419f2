#include "plot/scaling_with_friction.h"

#include <fmt/format.h>

#include "model/lattice.h"
#include "plot/figure_captions.h"
#include "plot/plot_language.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "scaling-with-friction";

/// c and D of one friction coefficient, read in one of the two ways.
struct Reading {
  double mu;
  Estimate c, D;
};

Estimate over(const Estimate& estimate, double z) {
  Estimate ratio = estimate;
  ratio.value /= z;
  ratio.standard_error /= z;
  return ratio;
}

std::vector<Reading> slope_readings(const std::vector<Transport>& results) {
  std::vector<Reading> readings;
  for (const Transport& result : results) {
    if (!result.exact) readings.push_back({result.scanned(), result.c, result.D});
  }
  return readings;
}

std::vector<Reading> ratio_readings(const std::vector<Transport>& results, int layer) {
  std::vector<Reading> readings;
  for (const Transport& result : results) {
    // Where no slope could be taken, a ratio at one depth means nothing either: its peaks were identified by chance.
    if (result.exact || (!result.c.known() && !result.D.known())) continue;
    for (const DepthFit& fit : result.depths) {
      if (fit.layer != layer || !fit.identifiable) continue;
      readings.push_back({result.scanned(), over(fit.peak_position, fit.z), over(fit.width_squared, fit.z)});
    }
  }
  return readings;
}

std::vector<PowerLawPoint> diffusion_points(const std::vector<Reading>& readings) {
  std::vector<PowerLawPoint> points;
  for (const Reading& reading : readings) {
    if (reading.D.known()) points.push_back({reading.mu, reading.mu, 0, reading.D.value, reading.D.standard_error});
  }
  return points;
}

std::vector<PowerLawPoint> slowing_points(const std::vector<Reading>& readings) {
  std::vector<PowerLawPoint> points;
  for (const Reading& reading : readings) {
    if (!reading.c.known()) continue;
    points.push_back({reading.mu, reading.mu, 0, tan30 - reading.c.value, reading.c.standard_error});
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
  const RatioScaling* ratio = analysis.by_ratio.empty() ? nullptr : &analysis.by_ratio.front();
  const std::vector<Reading> slopes = slope_readings(analysis.results);
  const std::vector<Reading> ratios =
      ratio == nullptr ? std::vector<Reading>{} : ratio_readings(analysis.results, ratio->layer);
  const std::string ratio_name = ratio == nullptr ? "" : fmt::format("ratios at z = {:.1f}", ratio->z);

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
  D.series.push_back({"slopes", diffusion_points(slopes), analysis.scaling.beta});
  c.series.push_back({"slopes", slowing_points(slopes), analysis.scaling.gamma});
  D.notes = {note("slopes", "β", analysis.scaling.beta)};
  c.notes = {note("slopes", "γ", analysis.scaling.gamma)};
  if (ratio != nullptr) {
    D.series.push_back({"ratios", diffusion_points(ratios), ratio->fits.beta});
    c.series.push_back({"ratios", slowing_points(ratios), ratio->fits.gamma});
    D.notes.push_back(note(ratio_name, "β", ratio->fits.beta));
    c.notes.push_back(note(ratio_name, "γ", ratio->fits.gamma));
  } else {
    D.notes.emplace_back();
    c.notes.emplace_back();
  }
  D.notes.emplace_back("the paper: β ≈ 2.5");
  c.notes.emplace_back("the paper: γ = 1");

  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/scaling_with_friction";
  plan.height = 3.3;
  const PowerLawPanelScript left = add_power_law_panel(plan, D);
  const PowerLawPanelScript right = add_power_law_panel(plan, c);
  if (!left.shown && !right.shown) {
    throw InputError(
        "the figure of D and c0 - c against mu has nothing to show, because no friction coefficient has a positive "
        "one; "
        "use more samples or deeper layers, or switch the figure off");
  }
  const auto either = [](bool one, bool other) { return one || other ? "yes" : ""; };
  std::vector<std::string> off_scale = {off_scale_in_words(left, "D"), off_scale_in_words(right, "c₀ − c")};
  std::erase(off_scale, "");
  const ScalingFits none;
  const ScalingFits& by_ratio = ratio == nullptr ? none : ratio->fits;
  return plot_figure(plan,
                     {{"left_panel", left.text},
                      {"right_panel", right.text},
                      {"slope_law", either(left.law, right.law)},
                      {"ratio_title", left.second || right.second ? ratio_name : ""},
                      {"outside", either(left.outside, right.outside)}},
                     {"plot/scaling_with_friction.captions",
                      {{"low", caption_number(analysis.scaling.beta.window[0])},
                       {"high", caption_number(analysis.scaling.beta.window[1])},
                       {"beta", in_words(analysis.scaling.beta)},
                       {"gamma", in_words(analysis.scaling.gamma)},
                       {"ratios", left.second || right.second ? "yes" : ""},
                       {"z", ratio == nullptr ? "" : fmt::format("{:.1f}", ratio->z)},
                       {"ratio_beta", in_words(by_ratio.beta)},
                       {"ratio_gamma", in_words(by_ratio.gamma)},
                       {"off_scale", enumeration(off_scale)}},
                      terms_of(*analysis.scan)},
                     run_folder);
}

}  // namespace granuscope
