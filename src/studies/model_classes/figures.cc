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
#include "plot/growing_panel.h"
#include "plot/plot.h"
#include "studies/study.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

struct Panels {
  Panel slowing = left_panel(), profiles = right_panel();
  std::vector<std::string> exponents;
  std::vector<KeyEntry> theory;
  Range D, c, height;
  double shallowest = 0, deepest = 0;  ///< of the profiles
};

void add_slowing(Plot& plot, Panels& panels, const ModelSeries& series, const std::string& name, const Ink& ink) {
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
  Style style = ink.joined_bars(1, 0.55);
  style.with = "xyerrorlines";
  panels.slowing.add(plot.add_data(name, table), "1:3:2:4", style);
  if (series.alpha.exponent.known()) {
    panels.exponents.push_back(fmt::format("{} ({})", value_with_error(series.alpha.exponent), series.name));
  }
}

/// c0 - c against D by the theory of the noise of a series, as far as the series goes.
void add_theory(Plot& plot, Panels& panels, const ModelSeries& series, const std::string& name, const Ink& ink) {
  CsvTable table({"D: bead diameters", "c0_minus_c: dimensionless"});
  for (const ModelResponse& one : series.responses) {
    if (!one.theory || one.theory->D0 > 0 || !one.slowing.known()) continue;
    table.add_row({one.D_expected, one.speed_without_disorder - one.c_expected});
  }
  if (table.empty()) return;
  panels.slowing.add(plot.add_data(name + "-theory", table), "1:2", ink.line(1.2, 2));
  panels.theory = {{"theory of " + series.name, ink.line(1.2, 2)}};
}

void add_profile(Plot& plot, Panels& panels, const ModelResponse& one, const std::string& name, const Ink& ink) {
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
  panels.profiles.add(plot.add_data(name + "-profile", table), "1:2", ink.line(1.2));
  panels.shallowest = panels.deepest == 0 ? profile.z : std::min(panels.shallowest, profile.z);
  panels.deepest = std::max(panels.deepest, profile.z);
}

}  // namespace

Figure plot_models(const std::vector<ModelSeries>& series, const std::string& study,
                   const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "model-classes";
  plot.height = 3.3;
  plot.key = {.inches = 0.72, .lines = 3, .entries = {}};
  Panels panels;
  panels.height.add(0);
  std::vector<std::string> shown;
  for (std::size_t k = 0; k < series.size(); ++k) {
    if (series[k].aside) continue;
    const std::string name = std::to_string(k + 1);
    const Ink ink = ink_of_series(k);
    add_slowing(plot, panels, series[k], name, ink);
    add_theory(plot, panels, series[k], name, ink);
    const ModelResponse& last = series[k].responses.back();
    add_profile(plot, panels, last, name, ink);
    plot.add_key(series[k].name, ink.joined(1, 0.55));
    shown.push_back(last.parameter.empty() ? last.series : fmt::format("{} at {}", last.series, last.parameter));
  }
  if (panels.slowing.curves.empty() || panels.profiles.curves.empty()) {
    throw InputError(
        "the figure of the models has nothing to show, because no model with two peaks was measured; ask for "
        "parameters at which the width of the peaks can be told");
  }
  plot.key.entries.insert(plot.key.entries.end(), panels.theory.begin(), panels.theory.end());
  Panel &slowing = panels.slowing, &profiles = panels.profiles;
  slowing.x = log_axis("D  (bead diameters)", widened_by_factor(panels.D, 1.4));
  slowing.y = log_axis("c₀ − c", widened_by_factor(panels.c, 1.4));
  profiles.left = 0.585;
  profiles.x = {"x/z", -1, 1, false, {{"−1", -1}, {"−0.5", -0.5}, {"0", 0}, {"0.5", 0.5}, {"1", 1}}};
  const Range& height = panels.height;
  profiles.y = linear_axis("z P(x, z)", {height.low - 0.03 * height.size(), height.high + 0.05 * height.size(), false},
                           6, height);
  for (const double x : {tan30, -tan30}) {
    profiles.arrows.push_back({x, 0, x, 1, "first", false, {.colour = "frame", .dash = 3}});
  }
  plot.panels = {slowing, profiles};
  return plot_figure(plot,
                     {"studies/" + study + ".captions",
                      {{"shown", enumeration(shown)},
                       {"exponents", enumeration(panels.exponents)},
                       {"depths", panels.shallowest == panels.deepest
                                      ? caption_number(panels.deepest)
                                      : caption_number(panels.shallowest) + " to " + caption_number(panels.deepest)}}},
                     run_folder);
}

namespace {

Style points(std::size_t colour) { return ink_of_series(colour).bars(1, 0.6); }
Style joined_points(std::size_t colour) { return ink_of_series(colour).joined_bars(1, 0.55); }
Style line(std::size_t colour) { return ink_of_series(colour).line(1); }

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
  Plot plot = two_panels("model-noise");
  GrowingPanel loss{"Δ²", "1 − c²/c₀²"}, gain{"Δ²", "D − D₀  (bead diameters)"};
  for (GrowingPanel* panel : {&loss, &gain}) panel->x.add(0), panel->y.add(0);
  std::vector<std::string> factors;
  std::size_t colour = 0;
  for (const ModelSeries& one : series) {
    const NoiseRows rows = noise_rows(one);
    if (rows.thrust.size() < 2) continue;
    const double end = rows.thrust.back()[0];
    const auto add = [&](GrowingPanel& panel, const std::string& what, const CurveRows& rows_of_it, double slope,
                         const std::string& column) {
      const std::string name = fmt::format("{}-{}", colour, what), x = "disorder_squared: dimensionless";
      panel.add(plot, name, rows_of_it, points(colour), x, column);
      panel.add(plot, name + "-theory", {{0, 0, 0}, {end, slope * end, 0}}, line(colour), x, column);
    };
    const NoiseShift& of_peaks = rows.narrow ? *rows.theory.narrow : rows.theory.wide;
    add(loss, "thrust", rows.thrust, rows.theory.wide.kappa, "thrust_loss: dimensionless");
    plot.add_key(one.name + ": thrust", ink_of_series(colour).points(0.6));
    ++colour;
    add(loss, "speed", rows.speed, of_peaks.kappa, "speed_loss: dimensionless");
    add(gain, "spreading", rows.spreading, of_peaks.spreading, "D_gain: bead diameters");
    plot.add_key(one.name + ": peaks", ink_of_series(colour).points(0.6));
    ++colour;
    factors.push_back(fmt::format("κ = {:.3g} for long waves, {:.3g} and D − D₀ = {:.3g} Δ² for these peaks ({})",
                                  rows.theory.wide.kappa, of_peaks.kappa, of_peaks.spreading, one.name));
  }
  return plot_panels(plot, loss, gain, {{"factors", enumeration(factors)}}, run_folder);
}

Figure plot_middle(const std::vector<ModelSeries>& series, const std::vector<TractionDepth>& tractions,
                   const std::filesystem::path& run_folder) {
  Plot plot = two_panels("model-middle");
  GrowingPanel speed{"mean share ⟨p⟩ of the middle leg", "c"},
      depth{"mean share p of the middle leg", "depth of tractions  (bead diameters)", true};
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
    speed.add(plot, fmt::format("{}-speed", colour), rows, points(colour), middle, "c: dimensionless");
    plot.add_key(one.name, ink_of_series(colour).points(0.6));
  }
  CurveRows mean_alone;
  for (int k = 0; k <= 40; ++k) {
    const double p = speed.x.low + speed.x.size() * k / 40;
    mean_alone.push_back({p, tan30 * std::sqrt(1 - p), 0});
  }
  speed.add(plot, "mean-alone", mean_alone, line(0), middle, "c: dimensionless");
  plot.add_key("c₀ √(1 − ⟨p⟩)", line(0));
  std::map<int, CurveRows> by_noise;  // in per cent of the mean
  for (const TractionDepth& one : tractions) {
    if (!one.z.known()) continue;
    by_noise[static_cast<int>(std::lround(100 * one.noise / one.middle))].push_back(
        {one.middle, one.z.value, one.z.standard_error});
  }
  for (const auto& [noise, rows] : by_noise) {
    ++colour;
    depth.add(plot, fmt::format("tractions-{}", noise), rows, joined_points(colour), "middle: dimensionless",
              "depth: bead diameters");
    plot.add_key(fmt::format("p ± {} %", noise), ink_of_series(colour).joined(1, 0.55));
  }
  return plot_panels(plot, speed, depth, {{"columns", fmt::format("{}", tractions.front().columns)}}, run_folder);
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
  Plot plot = two_panels("model-gravity");
  GrowingPanel stress{"depth z  (bead diameters)", "stresses  (loads of one top bead)", true},
      profile{"x/z", "z P(x, z)"};
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
    stress.add(plot, name + "-horizontal", horizontal, points(colour), z_column,
               "three_sigma_xx: loads of one top bead");
    stress.add(plot, name + "-vertical", vertical, line(colour), z_column, "sigma_zz: loads of one top bead");
    // Where less is known of the peaks the response is lost in the noise of what beads weigh.
    constexpr double most_uncertain = 0.01;
    if (one.profile && one.c.known() && one.c.standard_error < most_uncertain) {
      const double z = deepest = one.profile->z;
      for (std::size_t i = 0; i < one.profile->x.size(); ++i) {
        if (std::abs(one.profile->x[i]) < z) {
          response.push_back({one.profile->x[i] / z, z * one.profile->pressure[i], 0});
        }
      }
      profile.add(plot, name + "-response", response, line(colour), "x_over_z: dimensionless",
                  "z_response: dimensionless");
    }
    plot.add_key(fmt::format("g = {}", one.bead_weight), ink_of_series(colour).joined(1, 0.55));
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
  return plot_panels(plot, stress, profile,
                     {{"parameter", light == nullptr ? "" : light->parameter}, {"depth", caption_number(deepest)}},
                     run_folder);
}

}  // namespace granuscope
