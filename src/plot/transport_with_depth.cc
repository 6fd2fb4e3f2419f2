#include "plot/transport_with_depth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_language.h"
#include "plot/plot_script.h"
#include "plot/point_selection.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "transport-with-depth";

bool shows(const DepthFit& fit) { return fit.identifiable && fit.peak_position.known() && fit.width_squared.known(); }

bool has_depths(const Transport& result) { return std::any_of(result.depths.begin(), result.depths.end(), shows); }

std::string file_name(const std::string& part) { return fmt::format("{}-{}.csv", figure_id, part); }

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
  draft.plan.id = figure_id;
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

}  // namespace granuscope
