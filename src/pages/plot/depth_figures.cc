#include "plot/depth_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot_script.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr const char* depth_id = "transport-with-depth";

bool shows(const DepthFit& fit) { return fit.identifiable && fit.peak_position.known() && fit.width_squared.known(); }

bool has_depths(const Transport& result) { return std::any_of(result.depths.begin(), result.depths.end(), shows); }

std::string file_name(const std::string& part) { return fmt::format("{}-{}.csv", depth_id, part); }

Range with_margins(const Range& data) {
  const double margin = 0.08 * (data.size() > 0 ? data.size() : 1);
  Range axis = data;
  axis.low -= margin;
  axis.high += margin;
  return axis;
}

/// Everything one figure consists of, filled step by step.
struct Draft {
  PlotPlan plan;
  TemplateVariables script;
  TemplateVariables caption;
};

void set_both(Draft& draft, const std::string& name, const std::string& text) {
  draft.script[name] = text;
  draft.caption[name] = text;
}

void add_depths(Draft& draft, const Transport& result) {
  CsvTable positions({"z: bead diameters", "x_p/z: dimensionless", "standard_error: dimensionless",
                      "x_p-c0*z: bead diameters", "standard_error: bead diameters"});
  CsvTable widths({"z: bead diameters", "W^2/z: bead diameters", "standard_error: bead diameters",
                   "W^2: bead diameters squared", "standard_error: bead diameters squared"});
  Range position_range, width_range, z_range, shift_range, square_range;
  shift_range.add(0);
  square_range.add(0);
  position_range.add(tan30);
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
    const double shift = fit.peak_position.value - tan30 * fit.z;
    positions.add_row({fit.z, position, position_error, shift, fit.peak_position.standard_error});
    widths.add_row({fit.z, width, width_error, fit.width_squared.value, fit.width_squared.standard_error});
    for (const int sign : {-1, 1}) {
      shift_range.add(shift + sign * fit.peak_position.standard_error);
      square_range.add(fit.width_squared.value + sign * fit.width_squared.standard_error);
      position_range.add(position + sign * position_error);
      width_range.add(width + sign * width_error);
    }
  }
  draft.plan.data[file_name("position")] = positions.text();
  draft.plan.data[file_name("width")] = widths.text();
  draft.plan.curves += 7;  // above both point sets and the line at c0, below both point sets and lines at zero

  shift_range.add((result.c_thrust.value - tan30) * z_range.high);
  const Range position_axis = with_margins(position_range);
  const Range width_axis = with_margins(width_range);
  draft.script["position_low"] = exact(position_axis.low);
  draft.script["position_high"] = exact(position_axis.high);
  draft.script["width_low"] = exact(width_axis.low);
  draft.script["width_high"] = exact(width_axis.high);
  const std::string position_ticks = linear_ticks(position_axis, 5);
  const std::string width_ticks = linear_ticks(width_axis, 5);
  draft.script["position_ticks"] = position_ticks;
  draft.script["width_ticks"] = width_ticks;
  const Range shift_axis = with_margins(shift_range);
  const Range square_axis = with_margins(square_range);
  draft.script["shift_low"] = exact(shift_axis.low);
  draft.script["shift_high"] = exact(shift_axis.high);
  const std::string shift_ticks = linear_ticks(shift_axis, 5), square_ticks = linear_ticks(square_axis, 5);
  draft.script["shift_ticks"] = shift_ticks;
  // The lines fall where the peaks are slower than without friction: the numbers stand where they do not pass.
  const bool falls = !result.c.known() || result.c.value < tan30;
  draft.script["text_top"] = falls ? "0.84" : "0.33";
  draft.script["square_low"] = exact(square_axis.low);
  draft.script["square_high"] = exact(square_axis.high);
  draft.script["square_ticks"] = square_ticks;
  draft.script["left_room"] = exact(room_for_labels({position_ticks, shift_ticks}));
  draft.script["right_room"] = exact(room_for_labels({width_ticks, square_ticks}));
  Range z_axis;
  z_axis.add(0);
  z_axis.add(10 * std::ceil((z_range.high + 1) / 10));
  draft.script["z_limit"] = exact(z_axis.high);
  draft.script["z_ticks"] = linear_ticks(z_axis, 5);
  draft.caption["depths"] = std::to_string(shown);
  draft.caption["unidentified"] =
      unidentified == 0 ? "" : count_in_words(unidentified) + (unidentified == 1 ? " depth" : " depths");
}

/// The slope and offset of one line, and the ratio that they imply at finite depth.
void add_slope(Draft& draft, const std::string& name, const Estimate& slope, const std::string& offset_name,
               const Estimate& offset) {
  const bool known = slope.known() && offset.known();
  draft.script[name] = known ? exact(slope.value) : "";
  draft.script[offset_name] = known ? exact(offset.value) : "";
  draft.caption[name] = known ? "known" : "";
  draft.caption[name + "_reason"] = known ? "" : slope.known() ? offset.reason : slope.reason;
  draft.script[name + "_text"] =
      known ? gnuplot_string(fmt::format("slope {} = {}", name, value_with_error(slope.value, slope.standard_error)))
            : "";
  if (known) draft.plan.curves += 2;  // above and below
}

/// The speed that follows from the thrust ratio, beside the slope c.
void add_thrust(Draft& draft, const Transport& result) {
  // Plotted over the window, of which something must be on the axis.
  const bool known =
      result.c_thrust.known() && std::any_of(result.depths.begin(), result.depths.end(), [&](const DepthFit& fit) {
        return shows(fit) && fit.layer > result.window_layers[0];
      });
  const auto text = [](const std::string& what, const Estimate& number) {
    if (!number.known()) return std::string();
    return gnuplot_string(fmt::format("{} {}", what, value_with_error(number.value, number.standard_error)));
  };
  set_both(draft, "thrust", known ? exact(result.c_thrust.value) : "");
  draft.script["thrust_text"] = text("c from thrust", result.c_thrust);
  draft.script["difference_text"] = known ? text("difference", result.c_minus_c_thrust) : "";
  if (known) ++draft.plan.curves;
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
        "use "
        "more samples or deeper layers, or switch the figure off");
  }

  Draft draft;
  draft.plan.id = depth_id;
  draft.plan.script = "plot/transport_with_depth";
  draft.plan.height = 4.3;
  set_both(draft, "mu", caption_number(result->scanned()));
  draft.caption["mu_differs"] = result->scanned() == spec.mu ? "" : caption_number(spec.mu);
  const double window_top = result->rows().depth(result->window_layers[0]);
  const double window_bottom = result->rows().depth(result->window_layers[1]);
  draft.script["c0"] = exact(tan30);
  draft.script["window_top"] = exact(window_top);
  draft.script["window_bottom"] = exact(window_bottom);
  draft.caption["window_top"] = caption_number(window_top);
  draft.caption["window_bottom"] = caption_number(window_bottom);
  add_depths(draft, *result);
  add_slope(draft, "c", result->c, "x_0", result->position_offset);
  add_slope(draft, "D", result->D, "w_0", result->width_offset);
  add_thrust(draft, *result);
  draft.script["slopes"] = draft.script["c"].empty() && draft.script["D"].empty() ? "" : "yes";

  return plot_figure(draft.plan, draft.script,
                     {"plot/transport_with_depth.captions", draft.caption, terms_of(*analysis.scan)}, run_folder);
}

namespace {

constexpr const char* profiles_id = "response-profiles";
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

struct Panel {
  const ResponseProfile* profile = nullptr;
  const DepthFit* fit = nullptr;  ///< nullptr if the layer was not fitted or the fit identifies no peak
  bool has_curve = false;         ///< the fitted G is plotted
};

const ResponseProfile& nearest_profile(const Transport& result, int layer) {
  return *std::min_element(result.profiles.begin(), result.profiles.end(),
                           [layer](const ResponseProfile& a, const ResponseProfile& b) {
                             return std::abs(a.layer - layer) < std::abs(b.layer - layer);
                           });
}

Panel make_panel(const Transport& result, const ResponseProfile& profile) {
  Panel panel;
  panel.profile = &profile;
  for (const DepthFit& fit : result.depths) {
    if (fit.layer == profile.layer && fit.identifiable && fit.peak_position.known()) panel.fit = &fit;
  }
  // A profile without errors is exact, and whatever curve rounding may give it says nothing.
  const std::vector<double>& errors = profile.standard_error;
  panel.has_curve = std::any_of(profile.fit.begin(), profile.fit.end(), [](double g) { return std::isfinite(g); }) &&
                    std::any_of(errors.begin(), errors.end(), [](double error) { return error > 0; });
  return panel;
}

/// The panels for the layers asked for, each profile once; `nearest` collects what had to be replaced.
std::vector<Panel> choose_panels(const Transport& result, const std::vector<int>& layers,
                                 std::vector<std::string>& nearest) {
  std::vector<Panel> panels;
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

std::string data_of(const Panel& panel) {
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
double half_width(const std::vector<Panel>& panels) {
  double shown = 0, available = 0;
  for (const Panel& panel : panels) {
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

Range heights(const std::vector<Panel>& panels, double half_width) {
  Range range;
  range.add(0);
  for (const Panel& panel : panels) {
    const ResponseProfile& profile = *panel.profile;
    for (std::size_t i = 0; i < profile.x.size(); ++i) {
      if (std::abs(profile.x[i]) > half_width) continue;
      range.add(profile.pressure[i] - profile.standard_error[i]);
      range.add(profile.pressure[i] + profile.standard_error[i]);
      if (panel.has_curve) range.add(profile.fit[i]);
    }
  }
  return range;
}

/// The right-hand peak, seen closely: where the fit puts it, or where it would stand without friction.
double centre_of(const Panel& panel) {
  return panel.fit != nullptr ? panel.fit->peak_position.value : tan30 * panel.profile->z;
}

/// Half the width of that view, the same in every panel: six widths of the widest peak.
double close_half_width(const std::vector<Panel>& panels, double shown) {
  double half = 8;
  for (const Panel& panel : panels) {
    if (panel.fit != nullptr && panel.fit->width.known()) half = std::max(half, 6 * panel.fit->width.value);
    half = std::min(half, shown / 2);
  }
  return std::ceil(half);
}

/// How far the residuals of the close views reach, at least three standard errors.
double residual_reach(const std::vector<Panel>& panels, double half_width) {
  double reach = 3;
  for (const Panel& panel : panels) {
    if (!panel.has_curve) continue;
    for (std::size_t i = 0; i < panel.profile->x.size(); ++i) {
      if (std::abs(panel.profile->x[i] - centre_of(panel)) > half_width) continue;
      const double r = std::abs(residual(*panel.profile, i));
      if (std::isfinite(r)) reach = std::max(reach, r);
    }
  }
  return 1.15 * reach;
}

std::string quality_of(const Panel& panel) {
  if (panel.fit == nullptr || panel.fit->degrees_of_freedom <= 0) return "";
  return fmt::format("χ²/dof = {:.2f}, {} dof", panel.fit->chi2_per_dof, panel.fit->degrees_of_freedom);
}

std::string head_of(const Panel& panel, int layers_computed) {
  const int layer = panel.profile->layer;
  return fmt::format("z = {:.1f}: layer {} of {}", panel.profile->z, layer, layers_computed);
}

std::string note_of(const Panel& panel) {
  if (panel.fit == nullptr) return "peaks not identified by the fit";
  std::string note =
      "xₚ = " + value_with_error(panel.fit->peak_position.value, panel.fit->peak_position.standard_error);
  if (panel.fit->width.known()) {
    note += ",  W = " + value_with_error(panel.fit->width.value, panel.fit->width.standard_error);
  }
  return note;
}

struct PanelLists {
  std::vector<std::string> layers, heads, notes, peaks, curves, centres, ticks, marks, qualities, depths, unfitted;
};

PanelLists lists_of(const std::vector<Panel>& panels, int layers_computed, double close_view) {
  PanelLists lists;
  for (const Panel& panel : panels) {
    const int layer = panel.profile->layer;
    lists.layers.push_back(std::to_string(layer));
    lists.heads.push_back(gnuplot_string(head_of(panel, layers_computed)));
    lists.notes.push_back(gnuplot_string(note_of(panel)));
    lists.peaks.push_back(panel.fit != nullptr ? exact(panel.fit->peak_position.value) : "NaN");
    Range close;
    close.add(centre_of(panel) - close_view);
    close.add(centre_of(panel) + close_view);
    lists.centres.push_back(exact(centre_of(panel)));
    lists.ticks.push_back(fmt::format("\"{}\"", linear_ticks(close, 5)));
    lists.marks.push_back(fmt::format("\"{}\"", without_labels(linear_ticks(close, 5))));
    lists.qualities.push_back(gnuplot_string(quality_of(panel)));
    lists.curves.push_back(panel.has_curve ? "1" : "0");
    lists.depths.push_back(fmt::format("z = {:.1f} (layer {}, {} layers above the bottom)", panel.profile->z, layer,
                                       layers_computed - layer));
    if (panel.fit == nullptr || !panel.has_curve) lists.unfitted.push_back(fmt::format("layer {}", layer));
  }
  return lists;
}

bool shows_the_papers_layers(const std::vector<Panel>& panels, int layers_computed) {
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
  const std::vector<Panel> panels = choose_panels(*result, spec.layers, nearest);
  const double shown = half_width(panels);
  const double close_view = close_half_width(panels, shown);
  const PanelLists lists = lists_of(panels, spec.layers_computed, close_view);
  // Beyond two depths there is room for the profiles alone.
  const bool detailed = panels.size() <= 2;
  const double reach = residual_reach(panels, close_view);
  const Range range = heights(panels, shown);
  Range x_axis;
  x_axis.add(-shown);
  x_axis.add(shown);
  const double room = range.size() > 0 ? range.size() : 1;

  PlotPlan plan;
  plan.id = profiles_id;
  plan.script = "plot/response_profiles";
  const double rows = std::ceil(static_cast<double>(panels.size()) / 2);
  plan.height = detailed ? 5.0 : 0.3 + std::min(2.9, 9.0 / rows) * rows;
  for (const Panel& panel : panels) {
    plan.data[fmt::format("{}-layer-{}.csv", profiles_id, panel.profile->layer)] = data_of(panel);
    plan.curves += panel.has_curve ? 3 : 2;
    if (detailed) plan.curves += panel.has_curve ? 5 : 1;
  }
  const std::string mu = caption_number(result->scanned());
  const TemplateVariables variables = {
      {"mu", mu},
      {"panels", std::to_string(panels.size())},
      {"layers", fmt::format("{}", fmt::join(lists.layers, ", "))},
      {"heads", fmt::format("{}", fmt::join(lists.heads, ", "))},
      {"notes", fmt::format("{}", fmt::join(lists.notes, ", "))},
      {"peaks", fmt::format("{}", fmt::join(lists.peaks, ", "))},
      {"curves", fmt::format("{}", fmt::join(lists.curves, ", "))},
      {"detailed", detailed ? "yes" : ""},
      {"centres", fmt::format("{}", fmt::join(lists.centres, ", "))},
      {"close_ticks", fmt::format("{}", fmt::join(lists.ticks, ", "))},
      {"close_marks", fmt::format("{}", fmt::join(lists.marks, ", "))},
      {"qualities", fmt::format("{}", fmt::join(lists.qualities, ", "))},
      {"close_view", exact(close_view)},
      {"reach", exact(reach)},
      {"residual_ticks", three_ticks(reach)},
      {"x_limit", exact(shown)},
      {"x_ticks", linear_ticks(x_axis, 5)},
      {"y_ticks", linear_ticks(range, 6)},
      {"y_low", exact(range.low - 0.05 * room)},
      {"y_high", exact(range.high + 0.22 * room)}};  // room for the labels above the peaks
  const EstimatorName estimator = result->spec.response.estimator;
  return plot_figure(plan, variables,
                     {"plot/response_profiles.captions",
                      {{"mu", mu},
                       {"mu_differs", result->scanned() == spec.mu ? "" : caption_number(spec.mu)},
                       {"samples", std::to_string(result->samples)},
                       {"linear", estimator == EstimatorName::multiplexed ? "yes" : ""},
                       {"unloaded", estimator == EstimatorName::fluctuation ? "yes" : ""},
                       {"finite", loads_one_bead(estimator) ? "yes" : ""},
                       {"depths", enumeration(lists.depths)},
                       {"how_many", count_in_words(panels.size()) + (panels.size() == 1 ? " depth" : " depths")},
                       {"panels", std::to_string(panels.size()) + (panels.size() == 1 ? " panel" : " panels")},
                       {"detailed", detailed ? "yes" : ""},
                       {"deeper", panels.size() > 1 ? "yes" : ""},
                       {"unfitted", enumeration(lists.unfitted)},
                       {"nearest", fmt::format("{}", fmt::join(nearest, ". "))},
                       {"paper_depths", shows_the_papers_layers(panels, spec.layers_computed) ? "yes" : ""}},
                      terms_of(*result->scan)},
                     run_folder);
}

}  // namespace granuscope
