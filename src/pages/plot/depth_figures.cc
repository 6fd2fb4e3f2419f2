#include "plot/depth_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "model/lattice.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

bool shows(const DepthFit& fit) { return fit.identifiable && fit.peak_position.known() && fit.width_squared.known(); }

bool has_depths(const Transport& result) { return std::ranges::any_of(result.depths, shows); }

Range with_margins(const Range& data) {
  const double margin = 0.08 * (data.size() > 0 ? data.size() : 1);
  Range axis = data;
  axis.low -= margin;
  axis.high += margin;
  return axis;
}

/// A depth figure as it is being filled: above position and width over depth, below the lines themselves.
struct DepthPlot {
  Plot plot;
  Panel position = left_panel(), width = right_panel(), shift = left_panel(), square = right_panel();
  Range shift_range;
  TemplateVariables caption;
};

constexpr double lower_row = 2.2;  ///< inches

Ink depth_ink(bool inside) { return {"blue", inside ? 7 : 6}; }
Style level_style() { return {.colour = "frame", .width = 0.8}; }

void add_depths(DepthPlot& figure, const Transport& result) {
  const std::vector<std::string> of_position{
      "z: bead diameters",        "x_p/z: dimensionless",           "standard_error: dimensionless",
      "x_p-c0*z: bead diameters", "standard_error: bead diameters", "chi2_per_dof: dimensionless"},
      of_width{"z: bead diameters",
               "W^2/z: bead diameters",
               "standard_error: bead diameters",
               "W^2: bead diameters squared",
               "standard_error: bead diameters squared",
               "chi2_per_dof: dimensionless"};
  // Those outside the window of the slopes, and those inside.
  std::array<CsvTable, 2> positions{CsvTable(of_position), CsvTable(of_position)},
      widths{CsvTable(of_width), CsvTable(of_width)};
  Range position_range, width_range, z_range, square_range;
  figure.shift_range.add(0);
  square_range.add(0);
  position_range.add(result.c0());
  width_range.add(0);
  int shown = 0;
  std::size_t unidentified = 0;
  for (const DepthFit& fit : result.depths) {
    z_range.add(fit.z);  // those not shown, too: the lines reach over the whole window
    if (!shows(fit)) {
      ++unidentified;
      continue;
    }
    ++shown;
    const double position = fit.peak_position.value / fit.z;
    const double position_error = fit.peak_position.standard_error / fit.z;
    const double width = fit.width_squared.value / fit.z;
    const double width_error = fit.width_squared.standard_error / fit.z;
    const double shift = fit.peak_position.value - result.c0() * fit.z;
    const double chi2 = fit.degrees_of_freedom > 0 ? fit.chi2_per_dof : 0;
    const bool inside = fit.layer >= result.window_layers[0] && fit.layer <= result.window_layers[1];
    positions[inside].add_row({fit.z, position, position_error, shift, fit.peak_position.standard_error, chi2});
    widths[inside].add_row(
        {fit.z, width, width_error, fit.width_squared.value, fit.width_squared.standard_error, chi2});
    figure.shift_range.add(shift, fit.peak_position.standard_error);
    square_range.add(fit.width_squared.value, fit.width_squared.standard_error);
    position_range.add(position, position_error);
    width_range.add(width, width_error);
  }
  figure.position.y = linear_axis("xₚ/z", with_margins(position_range), 5);
  figure.width.y = linear_axis("W²/z", with_margins(width_range), 5);
  figure.shift.y = linear_axis("xₚ − c₀ z", with_margins(figure.shift_range), 5);
  figure.square.y = linear_axis("W²", with_margins(square_range), 5);
  const Range z_axis = range_of(0, 10 * std::ceil((z_range.high + 1) / 10));
  for (Panel* panel : {&figure.position, &figure.width, &figure.shift, &figure.square}) {
    panel->x = linear_axis("depth z  (bead diameters)", z_axis, 5);
  }
  figure.position.add_level(result.c0(), level_style());
  figure.shift.add_level(0, level_style());
  const std::string series = fmt::format("{} = {}", result.scan->symbol, caption_number(result.scanned()));
  for (const bool inside : {false, true}) {
    if (positions[inside].empty()) continue;
    const std::string part = inside ? "" : "-outside";
    const std::string position = figure.plot.add_data("position" + part, positions[inside]),
                      width = figure.plot.add_data("width" + part, widths[inside]);
    const Style measured = depth_ink(inside).bars(0.8, 0.4);
    figure.position.add(position, "1:2:3", measured, series);
    figure.width.add(width, "1:2:3", measured, series);
    figure.shift.add(position, "1:4:5", measured, series);
    figure.square.add(width, "1:4:5", measured, series);
  }
  figure.caption["depths"] = std::to_string(shown);
  figure.caption["unidentified"] =
      unidentified == 0 ? "" : count_in_words(unidentified) + (unidentified == 1 ? " depth" : " depths");
}

/// The line of one slope and its offset below, and above the ratio that they imply at finite depth. Whether it is
/// known.
bool add_slope(DepthPlot& figure, const std::string& name, const Estimate& slope, const Estimate& offset, Panel& above,
               Panel& below, double subtracted) {
  const bool known = slope.known() && offset.known();
  figure.caption[name] = known ? "known" : "";
  figure.caption[name + "_reason"] = known ? "" : slope.known() ? offset.reason : slope.reason;
  if (!known) return false;
  const Style line{.colour = "black", .width = 1.2};
  const Range& window = figure.position.band;
  above.curves.insert(
      above.curves.begin(),
      {"", "", fmt::format("{} + {} / $1", exact(slope.value), exact(offset.value)), window.low, window.high, line});
  below.add_function(fmt::format("{} + {} * $1", exact(offset.value), exact(slope.value - subtracted)), window.low,
                     window.high, line);
  return true;
}

/// The speed that follows from the thrust ratio, beside the slope c, and what is told of both. Whether it is shown.
bool add_thrust(DepthPlot& figure, const Transport& result) {
  // Plotted over the window, of which something must be on the axis.
  const bool known = result.c_thrust.known() && std::ranges::any_of(result.depths, [&](const DepthFit& fit) {
                       return shows(fit) && fit.layer > result.window_layers[0];
                     });
  const bool with_c = result.c.known() && result.position_offset.known();
  const Range& window = figure.position.band;
  if (known) {
    const double slope = result.c_thrust.value - result.c0();
    // It meets the line of c where the window begins.
    const double offset =
        with_c ? result.position_offset.value + (result.c.value - result.c_thrust.value) * window.low : 0;
    figure.shift_range.add(slope * window.high + offset);
    figure.shift.add_function(fmt::format("{} * $1 + {}", exact(slope), exact(offset)), window.low, window.high,
                              {.colour = "bluish_green", .width = 1.6});
  }
  figure.caption["thrust"] = known ? exact(result.c_thrust.value) : "";
  // The lines fall where the peaks are slower than without friction: the numbers stand where they do not pass.
  const double top = !result.c.known() || result.c.value < result.c0() ? 0.84 : 0.33;
  const auto tell = [&](const std::string& what, const Estimate& number, double below, const char* colour) {
    if (!number.known()) return;
    figure.shift.texts.push_back(
        {fmt::format("{} {}", what, value_with_error(number)), 0.95, top - below, "right", colour});
  };
  if (with_c) tell("slope c =", result.c, 0, "black");
  tell("c from thrust", result.c_thrust, 0.11, "bluish_green");
  constexpr double rounding = 1e-12;
  if (known && std::abs(result.c_minus_c_thrust.value) > rounding)
    tell("difference", result.c_minus_c_thrust, 0.22, "black");
  return known;
}

}  // namespace

Figure plot_transport_with_depth(const Analysis& analysis, const TransportWithDepthSpec& spec,
                                 const std::filesystem::path& run_folder) {
  // The exact frictionless pile settles at once: it is shown only if there is nothing else. Slopes come before none.
  const Transport* result = nearest_result(analysis.results, spec.mu, [](const Transport& transport) {
    return !transport.exact && transport.c.known() && has_depths(transport);
  });
  if (result == nullptr)
    result = nearest_result(analysis.results, spec.mu,
                            [](const Transport& transport) { return !transport.exact && has_depths(transport); });
  if (result == nullptr) result = nearest_result(analysis.results, spec.mu, has_depths);
  if (result == nullptr) {
    throw InputError(
        "the figure of c and D against depth has nothing to show, because the fit identified the peaks at no depth; "
        "use more samples or deeper layers, or switch the figure off");
  }

  DepthPlot figure;
  figure.plot.id = transport_with_depth_id;
  figure.plot.height = 4.3;
  figure.plot.key = {.inches = 0.5, .lines = 2, .sample = 1.8, .entries = {}};
  const double row = figure.plot.height - figure.plot.key.inches;
  figure.position.bottom = figure.width.bottom = lower_row + 0.48;
  figure.shift.top = figure.square.top = row - lower_row + 0.12;
  figure.caption["mu"] = caption_number(result->scanned());
  figure.caption["mu_differs"] = result->scanned() == spec.mu ? "" : caption_number(spec.mu);
  Range window;
  for (const int layer : result->window_layers) window.add(result->rows().depth(layer));
  for (Panel* panel : {&figure.position, &figure.width, &figure.shift, &figure.square}) panel->band = window;
  figure.caption["window_top"] = caption_number(window.low);
  figure.caption["window_bottom"] = caption_number(window.high);
  const bool thrust = add_thrust(figure, *result);
  add_depths(figure, *result);
  const bool with_c =
      add_slope(figure, "c", result->c, result->position_offset, figure.position, figure.shift, result->c0());
  const bool with_D = add_slope(figure, "D", result->D, result->width_offset, figure.width, figure.square, 0);
  if (with_D) {
    figure.square.texts.push_back({"slope D = " + value_with_error(result->D), 0.05, 0.91, "left", "black"});
  }
  figure.plot.panels = {figure.position, figure.shift, figure.width, figure.square};
  figure.plot.add_key("measured", depth_ink(true).points(0.5));
  if (with_c || with_D) {
    const char* lines = !with_D ? "xₚ = x₀ + c z" : with_c ? "xₚ = x₀ + c z, W² = w₀ + D z" : "W² = w₀ + D z";
    figure.plot.add_key(fmt::format("fitted: {}", lines), {.width = 1.2});
  }
  figure.plot.add_key("c₀ = tan 30°", level_style());
  if (thrust) figure.plot.add_key("c from thrust", {.colour = "bluish_green", .width = 1.6});
  return plot_figure(figure.plot,
                     {"plot/transport_with_depth.captions", figure.caption, terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

namespace {

constexpr const char* profiles_id = "response-profiles";
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct ProfilePanel {
  const ResponseProfile* profile = nullptr;
  const DepthFit* fit = nullptr;  ///< nullptr if the layer was not fitted or the fit identifies no peak
  bool has_curve = false;         ///< the fitted G is plotted
};

const ResponseProfile& nearest_profile(const Transport& result, int layer) {
  return *std::ranges::min_element(result.profiles, [layer](const ResponseProfile& a, const ResponseProfile& b) {
    return std::abs(a.layer - layer) < std::abs(b.layer - layer);
  });
}

ProfilePanel make_panel(const Transport& result, const ResponseProfile& profile) {
  ProfilePanel panel;
  panel.profile = &profile;
  for (const DepthFit& fit : result.depths) {
    if (fit.layer == profile.layer && fit.identifiable && fit.peak_position.known()) panel.fit = &fit;
  }
  // A profile without errors is exact, and whatever curve rounding may give it says nothing.
  const std::vector<double>& errors = profile.standard_error;
  panel.has_curve = panel.fit != nullptr &&
                    std::ranges::any_of(profile.fit, [](double g) { return std::isfinite(g); }) &&
                    std::ranges::any_of(errors, [](double error) { return error > 0; });
  return panel;
}

/// The panels for the layers asked for, each profile once; `nearest` collects what had to be replaced.
std::vector<ProfilePanel> choose_panels(const Transport& result, const std::vector<int>& layers,
                                        std::vector<std::string>& nearest) {
  std::vector<ProfilePanel> panels;
  std::set<int> taken;
  for (const int layer : layers) {
    const ResponseProfile& profile = nearest_profile(result, layer);
    if (profile.layer != layer) {
      nearest.push_back(
          fmt::format("Layer {} was not measured; the nearest one, {}, stands for it", layer, profile.layer));
    }
    if (taken.insert(profile.layer).second) panels.push_back(make_panel(result, profile));
  }
  return panels;
}

/// How far the mean lies from the fit, in its own standard errors; unknown where it has none.
double residual(const ResponseProfile& profile, std::size_t i) {
  if (!(profile.standard_error[i] > 0)) return unknown;
  return (profile.pressure[i] - profile.fit[i]) / profile.standard_error[i];
}

std::string data_of(const ProfilePanel& panel) {
  const ResponseProfile& profile = *panel.profile;
  std::vector<std::string> columns = {"x: bead diameters", "P: 1/bead diameter", "standard_error: 1/bead diameter"};
  if (panel.has_curve)
    columns.insert(columns.end(), {"fit: 1/bead diameter", "residual_in_standard_errors: standard errors"});
  CsvTable table(columns);
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    std::vector<double> row = {profile.x[i], profile.pressure[i], profile.standard_error[i]};
    if (panel.has_curve) row.insert(row.end(), {profile.fit[i], residual(profile, i)});
    table.add_row(row);
  }
  return table.text();
}

/// Half the width shown: both peaks with five widths of surroundings, the same in every panel, in tens of beads.
double half_width(const std::vector<ProfilePanel>& panels) {
  double shown = 0, available = 0;
  for (const ProfilePanel& panel : panels) {
    available = std::max(available, -panel.profile->x.front());
    if (panel.fit == nullptr) continue;
    const double width = panel.fit->width.known() ? panel.fit->width.value : 1;
    shown = std::max(shown, panel.fit->peak_position.value + 5 * width + 5);
    // Its name, above the peak, must stand clear of the frame.
    shown = std::max(shown, 1.09 * panel.fit->peak_position.value);
  }
  if (shown == 0) return available;
  return std::min(available, 10 * std::ceil(shown / 10));
}

Range heights(const std::vector<ProfilePanel>& panels, double half_width) {
  Range range;
  range.add(0);
  for (const ProfilePanel& panel : panels) {
    const ResponseProfile& profile = *panel.profile;
    for (std::size_t i = 0; i < profile.x.size(); ++i) {
      if (std::abs(profile.x[i]) > half_width) continue;
      range.add(profile.pressure[i], profile.standard_error[i]);
      if (panel.has_curve) range.add(profile.fit[i]);
    }
  }
  return range;
}

/// The right-hand peak, seen closely: where the fit puts it, or where it would stand without friction.
double centre_of(const ProfilePanel& panel) {
  return panel.fit != nullptr ? panel.fit->peak_position.value : panel.profile->c0 * panel.profile->z;
}

/// Half the width of that view, the same in every panel: six widths of the widest peak.
double close_half_width(const std::vector<ProfilePanel>& panels, double shown) {
  double half = 8;
  for (const ProfilePanel& panel : panels) {
    if (panel.fit != nullptr && panel.fit->width.known()) half = std::max(half, 6 * panel.fit->width.value);
    half = std::min(half, shown / 2);
  }
  return std::ceil(half);
}

/// How far the residuals of the close views reach, at least three standard errors.
double residual_reach(const std::vector<ProfilePanel>& panels, double half_width) {
  double reach = 3;
  for (const ProfilePanel& panel : panels) {
    if (!panel.has_curve) continue;
    for (std::size_t i = 0; i < panel.profile->x.size(); ++i) {
      if (std::abs(panel.profile->x[i] - centre_of(panel)) > half_width) continue;
      const double r = std::abs(residual(*panel.profile, i));
      if (std::isfinite(r)) reach = std::max(reach, r);
    }
  }
  return 1.15 * reach;
}

std::string quality_of(const ProfilePanel& panel) {
  if (panel.fit == nullptr || panel.fit->degrees_of_freedom <= 0) return "";
  return fmt::format("χ²/dof = {:.2f}, {} dof", panel.fit->chi2_per_dof, panel.fit->degrees_of_freedom);
}

std::string head_of(const ProfilePanel& panel, int layers_computed) {
  const int layer = panel.profile->layer;
  return fmt::format("z = {:.1f}: layer {} / {}", panel.profile->z, layer, layers_computed);
}

std::string note_of(const ProfilePanel& panel) {
  if (panel.fit == nullptr) return "peaks not identified by the fit";
  std::string note = "xₚ = " + value_with_error(panel.fit->peak_position);
  if (panel.fit->width.known()) {
    note += ",  W = " + value_with_error(panel.fit->width);
  }
  return note;
}

/// Beside the right end of an axis there is no room for half of a number.
constexpr double room_for_half_a_number = -0.03;

/// What the script is told of each depth.
Json fields_of(const std::vector<ProfilePanel>& panels, int layers_computed, double close_view) {
  Json all = Json::array();
  for (const ProfilePanel& panel : panels) {
    const double centre = centre_of(panel);
    const Range close = range_of(centre - close_view, centre + close_view);
    const Axis axis = linear_axis("", close, 5, widened(close, room_for_half_a_number));
    all.push_back({{"number", all.size() + 1},
                   {"file", fmt::format("{}-layer-{}.csv", profiles_id, panel.profile->layer)},
                   {"head", head_of(panel, layers_computed)},
                   {"note", note_of(panel)},
                   {"quality", quality_of(panel)},
                   {"fitted", panel.has_curve},
                   {"peak", panel.fit == nullptr ? Json() : Json{{"at", panel.fit->peak_position.value}}},
                   {"close", axis_json(axis)},
                   {"bare", axis_json(without_words(axis))}});
  }
  return all;
}

bool shows_the_papers_layers(const std::vector<ProfilePanel>& panels, int layers_computed) {
  return layers_computed == 200 && panels.size() == 2 && panels[0].profile->layer == 110 &&
         panels[1].profile->layer == 170;
}

}  // namespace

Figure plot_response_profiles(const std::vector<Transport>& results, const ResponseProfilesSpec& spec,
                              const std::filesystem::path& run_folder) {
  const Transport* result =
      nearest_result(results, spec.mu, [](const Transport& transport) { return !transport.profiles.empty(); });
  if (result == nullptr || spec.layers.empty()) {
    throw InputError(
        "the figure of response profiles has no profile to show, because no friction coefficient was measured at its "
        "layers; list usable layers for it, or switch the figure off");
  }
  std::vector<std::string> nearest;
  const std::vector<ProfilePanel> panels = choose_panels(*result, spec.layers, nearest);
  const double shown = half_width(panels);
  const double close_view = close_half_width(panels, shown);
  std::vector<std::string> depths, unfitted;
  for (const ProfilePanel& panel : panels) {
    const int layer = panel.profile->layer;
    depths.push_back(fmt::format("z = {:.1f} (layer {}, {} layers above the bottom)", panel.profile->z, layer,
                                 spec.layers_computed - layer));
    if (panel.fit == nullptr || !panel.has_curve) unfitted.push_back(fmt::format("layer {}", layer));
  }
  // Beyond two depths there is room for the profiles alone, and without a peak nothing to be enlarged.
  const bool detailed = panels.size() <= 2 && unfitted.size() < panels.size();
  const double reach = residual_reach(panels, close_view);
  const Range range = heights(panels, shown);
  const Range x_axis = range_of(-shown, shown);
  const double room = range.size() > 0 ? range.size() : 1;

  Plot plot;
  plot.id = profiles_id;
  const double rows = std::ceil(static_cast<double>(panels.size()) / 2);
  plot.height = detailed ? 5.0 : 0.3 + std::min(2.9, 9.0 / rows) * rows;
  for (const ProfilePanel& panel : panels) {
    plot.data[fmt::format("{}-layer-{}.csv", profiles_id, panel.profile->layer)] = data_of(panel);
    plot.other_curves += panel.has_curve ? 3 : 2;
    if (detailed) plot.other_curves += panel.has_curve ? 5 : 1;
  }
  const std::string mu = caption_number(result->scanned());
  Range y_axis = range;
  y_axis.low -= 0.05 * room;
  y_axis.high += 0.32 * room;  // room for the labels above the peaks
  plot.own = {{"depths", fields_of(panels, spec.layers_computed, close_view)},
              {"how_many", panels.size()},
              {"detailed", detailed},
              {"reach", reach},
              {"position", axis_json(linear_axis("position x  (bead diameters)", x_axis, 5,
                                                 widened(x_axis, room_for_half_a_number)))},
              {"response", axis_json(linear_axis("response P(x)", y_axis, 6, range))},
              {"residual", axis_json({"residual / σ", -reach, 1.6 * reach, false, three_marks(reach)})},
              {"right_hand_peak", "right-hand peak"}};
  plot.key = {.inches = 0.3, .horizontal = true, .centred = true, .entries = {}};
  plot.add_key("±1 standard error", {.with = "filledcurves", .colour = "sky_blue"});
  plot.add_key("measured mean", {.colour = "blue", .width = 0.7});
  if (std::ranges::any_of(panels, &ProfilePanel::has_curve))
    plot.add_key("fitted double Gaussian", {.colour = "black", .width = 1.4});
  const EstimatorName estimator = result->spec.response.estimator;
  return plot_figure(plot,
                     {"plot/response_profiles.captions",
                      {{"mu", mu},
                       {"mu_differs", result->scanned() == spec.mu ? "" : caption_number(spec.mu)},
                       {"samples", std::to_string(result->samples)},
                       {"linear", estimator == EstimatorName::multiplexed ? "yes" : ""},
                       {"unloaded", estimator == EstimatorName::fluctuation ? "yes" : ""},
                       {"finite", loads_one_bead(estimator) ? "yes" : ""},
                       {"depths", enumeration(depths)},
                       {"panels", std::to_string(panels.size()) + (panels.size() == 1 ? " panel" : " panels")},
                       {"detailed", detailed ? "yes" : ""},
                       {"two_peaks", unfitted.size() < panels.size() ? "yes" : ""},
                       {"grow", panels.size() > 1 && unfitted.empty() && !result->exact ? "yes" : ""},
                       {"unfitted", enumeration(unfitted)},
                       {"nearest", fmt::format("{}", fmt::join(nearest, ". "))},
                       {"paper_depths", shows_the_papers_layers(panels, spec.layers_computed) ? "yes" : ""}},
                      terms_of(*result->scan, result->spec.lattice.angle)},
                     run_folder);
}

}  // namespace granuscope
