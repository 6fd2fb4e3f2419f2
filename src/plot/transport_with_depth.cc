#include "plot/transport_with_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/point_selection.h"
#include "plot/window_points.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "transport-with-depth";

bool shows(const DepthFit& fit) { return fit.identifiable && fit.peak_position.known() && fit.width_squared.known(); }

bool has_depths(const Transport& result) { return std::any_of(result.depths.begin(), result.depths.end(), shows); }

std::string file_name(const std::string& part) { return fmt::format("{}-{}.csv", figure_id, part); }

/// The share of a panel's height, at its bottom, that its inset takes.
constexpr double inset_share = 0.56;

/// The axis of a large panel: the data in the upper part, room for the inset below them.
Range with_room_below(const Range& data) {
  const double size = data.size() > 0 ? data.size() : 0.1 * std::max(std::abs(data.high), 0.01);
  Range axis;
  axis.high = data.high + 0.08 * size;
  axis.low = data.low - 0.05 * size;
  axis.low = axis.high - axis.size() / (1 - inset_share);
  return axis;
}

/// The part of such an axis that belongs to the data: only there it has tick marks.
Range upper_part(const Range& axis) {
  Range part = axis;
  part.low = axis.high - axis.size() * (1 - inset_share);
  return part;
}

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
  std::vector<LeftOut> not_logarithmic;  ///< "mu = 0"
};

void set_both(Draft& draft, const std::string& name, const std::string& text) {
  draft.script[name] = text;
  draft.caption[name] = text;
}

/// What the insets leave out; c and D of one mu in one name where they share their reason.
std::vector<LeftOut> unknown_points(const std::vector<Transport>& results) {
  std::vector<LeftOut> unknown;
  for (const Transport& result : results) {
    const std::string mu = "μ = " + caption_number(result.mu());
    if (!result.c.known() && !result.D.known() && result.c.reason == result.D.reason) {
      unknown.push_back({mu, result.c.reason});
      continue;
    }
    if (!result.c.known()) unknown.push_back({"c at " + mu, result.c.reason});
    if (!result.D.known()) unknown.push_back({"D at " + mu, result.D.reason});
  }
  return unknown;
}

void add_depths(Draft& draft, const Transport& result) {
  CsvTable positions({"z", "x_p/z", "standard_error", "x_p-c0*z", "standard_error"});
  CsvTable widths({"z", "W^2/z", "standard_error", "W^2", "standard_error"});
  Range position_range, width_range, z_range, shown_z_range, shift_range, square_range;
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
    shown_z_range.add(fit.z);
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
  // At few samples a slope can lie well off the ratios it belongs to; it must be seen all the same.
  for (const int sign : {-1, 1}) {
    position_range.add(result.c.value + sign * result.c.standard_error);
    width_range.add(result.D.value + sign * result.D.standard_error);
  }
  draft.plan.data[file_name("position")] = positions.text();
  draft.plan.data[file_name("width")] = widths.text();
  draft.plan.curves += 7;  // above both point sets and the line at c0, below both point sets and lines at zero

  position_range.add(result.c_thrust.value);
  shift_range.add((result.c_thrust.value - tan30) * z_range.high);
  const Range position_axis = with_room_below(position_range);
  const Range width_axis = with_room_below(width_range);
  draft.script["position_low"] = exact(position_axis.low);
  draft.script["position_high"] = exact(position_axis.high);
  draft.script["width_low"] = exact(width_axis.low);
  draft.script["width_high"] = exact(width_axis.high);
  const std::string position_ticks = linear_ticks(upper_part(position_axis), 6);
  const std::string width_ticks = linear_ticks(upper_part(width_axis), 6);
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
  draft.script["z_first"] = exact(shown_z_range.low);
  Range z_axis;
  z_axis.add(0);
  z_axis.add(10 * std::ceil((z_range.high + 1) / 10));
  draft.script["z_limit"] = exact(z_axis.high);
  draft.script["z_ticks"] = linear_ticks(z_axis, 5);
  draft.caption["depths"] = std::to_string(shown);
  draft.caption["unidentified"] =
      unidentified == 0 ? "" : count_in_words(unidentified) + (unidentified == 1 ? " depth" : " depths");
}

/// The slope of one large panel: line, band and the ratio it implies at finite depth.
void add_slope(Draft& draft, const std::string& name, const Estimate& slope, const std::string& offset_name,
               const Estimate& offset) {
  const bool known = slope.known() && offset.known();
  draft.script[name] = known ? exact(slope.value) : "";
  draft.script[name + "_error"] = known ? exact(slope.standard_error) : "";
  draft.script[offset_name] = known ? exact(offset.value) : "";
  draft.caption[name] = known ? "known" : "";
  draft.caption[name + "_reason"] = known ? "" : slope.known() ? offset.reason : slope.reason;
  draft.script[name + "_text"] =
      known ? gnuplot_string(fmt::format("slope {} = {}", name, value_with_error(slope.value, slope.standard_error)))
            : "";
  if (known) draft.plan.curves += 4;  // line, band and ratio above, line below
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
  if (known) draft.plan.curves += 2;
}

void add_c_inset(Draft& draft, const Analysis& analysis) {
  CsvTable speeds({"mu", "c", "standard_error"});
  CsvTable thrusts({"mu", "c_thrust", "standard_error"});
  Range c_range, mu_range;
  std::vector<PowerLawPoint> slowing;
  for (const Transport& result : analysis.results) {
    if (result.c.known()) {
      speeds.add_row({result.mu(), result.c.value, result.c.standard_error});
      c_range.add(result.c.value - result.c.standard_error);
      c_range.add(result.c.value + result.c.standard_error);
      mu_range.add(result.mu());
      if (!result.exact)
        slowing.push_back({result.mu(), result.mu(), 0, tan30 - result.c.value, result.c.standard_error});
    }
    // Beside the slope alone: the speeds of the thrust reach far beyond those of the peaks at large friction.
    if (result.c.known() && result.c_thrust.known()) {
      thrusts.add_row({result.mu(), result.c_thrust.value, result.c_thrust.standard_error});
      c_range.add(result.c_thrust.value - result.c_thrust.standard_error);
      c_range.add(result.c_thrust.value + result.c_thrust.standard_error);
    }
  }
  const bool plotted = !speeds.empty();
  const bool with_thrust = plotted && !thrusts.empty();
  const ScalingFit& gamma = analysis.scaling.gamma;
  // As in the other figures, the paper's law passes through the middle of the window's points on logarithmic axes.
  const WindowMiddle middle = middle_of_window(slowing, gamma.window);
  const bool with_law = gamma.exponent.known() && gamma.intercept.known() && !middle.extent.empty;
  if (plotted) draft.plan.data[file_name("c-of-mu")] = speeds.text();
  if (with_thrust) draft.plan.data[file_name("c-thrust-of-mu")] = thrusts.text();
  draft.plan.curves += (plotted ? 1 : 0) + (with_thrust ? 1 : 0) + (with_law ? 2 : 0);
  draft.script["c_guide"] = with_law ? exact(middle.y / middle.x) : "";
  const double margin = 0.08 * std::max(c_range.size(), 0.005);
  set_both(draft, "inset_c", plotted ? "yes" : "");
  set_both(draft, "inset_c_thrust", with_thrust ? "yes" : "");
  set_both(draft, "gamma", with_law ? exact(gamma.exponent.value) : "");
  set_both(draft, "gamma_low", caption_number(gamma.window[0]));
  set_both(draft, "gamma_high", caption_number(gamma.window[1]));
  draft.script["gamma_intercept"] = with_law ? exact(gamma.intercept.value) : "";
  const double mu_margin = 0.06 * std::max(mu_range.high, 0.01);
  Range mu_axis;
  mu_axis.add(-mu_margin);  // mu = 0 stands clear of the frame
  mu_axis.add(mu_range.high + mu_margin);
  draft.script["mu_low"] = exact(mu_axis.low);
  draft.script["mu_high"] = exact(mu_axis.high);
  mu_range.add(0);
  const Range fitted = window_on_axis(gamma.window, mu_axis);
  draft.script["gamma_from"] = with_law ? exact(fitted.low) : "";
  draft.script["gamma_to"] = with_law ? exact(fitted.high) : "";
  c_range.low -= margin;
  c_range.high += margin;
  draft.script["linear_mu_ticks"] = plotted ? linear_ticks(mu_range, 4) : "";
  draft.script["c_low"] = exact(c_range.low);
  draft.script["c_high"] = exact(c_range.high);
  draft.script["c_ticks"] = plotted ? linear_ticks(c_range, 4) : "";
}

void add_D_inset(Draft& draft, const Analysis& analysis) {
  CsvTable inside({"mu", "D", "low", "high"});
  CsvTable outside({"mu", "D", "low", "high"});
  const ScalingFit& beta = analysis.scaling.beta;
  Range mu_range, D_range;
  std::vector<PowerLawPoint> points;
  for (const Transport& result : analysis.results) {
    const std::string mu = "μ = " + caption_number(result.mu());
    if (!result.D.known()) continue;
    if (result.exact) {
      draft.not_logarithmic.push_back({mu, "exact"});
    } else if (result.D.value <= 0) {
      draft.not_logarithmic.push_back({mu, "D is not positive"});
    } else {
      mu_range.add(result.mu());
      points.push_back({result.mu(), result.mu(), 0, result.D.value, result.D.standard_error});
      D_range.add(result.D.value);
      D_range.add(result.D.value + result.D.standard_error);
    }
  }
  const bool plotted = !mu_range.empty;
  // A single friction coefficient stands on an axis of a factor of four.
  const Range mu_axis = widened_by_factor(mu_range, mu_range.high > 1.5 * mu_range.low ? 1.25 : 2);
  const Range D_axis = widened_by_factor(D_range, 2);
  for (const Transport& result : analysis.results) {
    if (!result.D.known() || result.exact || result.D.value <= 0) continue;
    const double low = std::max(result.D.value - result.D.standard_error, D_axis.low);
    (in_window(result.mu(), beta.window) ? inside : outside)
        .add_row({result.mu(), result.D.value, low, result.D.value + result.D.standard_error});
  }
  const WindowMiddle middle = middle_of_window(points, beta.window);
  const bool with_law = beta.exponent.known() && beta.intercept.known() && !middle.extent.empty;
  if (!inside.empty()) draft.plan.data[file_name("D-of-mu-inside")] = inside.text();
  if (!outside.empty()) draft.plan.data[file_name("D-of-mu-outside")] = outside.text();
  draft.plan.curves += (inside.empty() ? 0 : 1) + (outside.empty() ? 0 : 1) + (with_law ? 3 : 0);
  draft.script["D_guide"] = with_law ? exact(middle.y / std::pow(middle.x, 2.5)) : "";
  const Range fitted = window_on_axis(beta.window, mu_axis);
  draft.script["beta_from"] = with_law ? exact(fitted.low) : "";
  draft.script["beta_to"] = with_law ? exact(fitted.high) : "";
  set_both(draft, "inset_D", plotted ? "yes" : "");
  set_both(draft, "beta", with_law ? exact(beta.exponent.value) : "");
  set_both(draft, "beta_low", caption_number(beta.window[0]));
  set_both(draft, "beta_high", caption_number(beta.window[1]));
  draft.script["beta_intercept"] = with_law ? exact(beta.intercept.value) : "";
  draft.script["D_inside"] = inside.empty() ? "" : "yes";
  draft.script["D_outside"] = outside.empty() ? "" : "yes";
  draft.script["mu_log_low"] = plotted ? exact(mu_axis.low) : "";
  draft.script["mu_log_high"] = plotted ? exact(mu_axis.high) : "";
  draft.script["D_log_low"] = plotted ? exact(D_axis.low) : "";
  draft.script["D_log_high"] = plotted ? exact(D_axis.high) : "";
  draft.script["mu_ticks"] = plotted ? log_ticks(mu_axis) : "";
  draft.script["D_ticks"] = plotted ? log_ticks(D_axis) : "";
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
  draft.plan.id = figure_id;
  draft.plan.script = "plot/transport_with_depth";
  draft.plan.height = 6.3;
  set_both(draft, "mu", caption_number(result->mu()));
  draft.caption["mu_differs"] = result->mu() == spec.mu ? "" : caption_number(spec.mu);
  const double window_top = Lattice::depth(result->window_layers[0]);
  const double window_bottom = Lattice::depth(result->window_layers[1]);
  draft.script["c0"] = exact(tan30);
  draft.script["window_top"] = exact(window_top);
  draft.script["window_bottom"] = exact(window_bottom);
  draft.caption["window_top"] = caption_number(window_top);
  draft.caption["window_bottom"] = caption_number(window_bottom);
  add_depths(draft, *result);
  add_slope(draft, "c", result->c, "x_0", result->position_offset);
  add_slope(draft, "D", result->D, "w_0", result->width_offset);
  add_thrust(draft, *result);
  add_c_inset(draft, analysis);
  add_D_inset(draft, analysis);
  const auto either = [&](const char* one, const char* other) {
    return draft.script[one].empty() && draft.script[other].empty() ? "" : "yes";
  };
  draft.script["slopes"] = either("c", "D");
  draft.script["insets"] = either("inset_c", "inset_D");
  draft.script["laws"] = either("gamma", "beta");
  draft.caption["unknown"] = with_reasons(unknown_points(analysis.results));
  draft.caption["not_logarithmic"] = with_reasons(draft.not_logarithmic);

  Figure figure = plot_figure(draft.plan, draft.script, run_folder);
  set_captions(figure, "plot/transport_with_depth.captions", draft.caption);
  return figure;
}

}  // namespace granuscope
