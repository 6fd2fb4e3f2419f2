// The figures beside that of the classes: noise against its theory, the mean share of the middle leg, gravity.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "figure.h"
#include "model/lattice.h"
#include "panels.h"
#include "plot/weights_picture.h"
#include "studies/main_line.h"
#include "support/number_format.h"

namespace granuscope {
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
