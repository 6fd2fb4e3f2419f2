#include "plot/propagation_and_thrust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_language.h"
#include "plot/plot_script.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "propagation-and-thrust";

bool has_both(const Transport& result) {
  return result.c.known() && result.c_thrust.known() && result.c_minus_c_thrust.known();
}

/// An axis with a margin at both ends, and `room` of its size more at the top.
Range with_margins(Range data, double least, double room = 0) {
  const double size = std::max(data.size(), least);
  data.low -= 0.07 * size;
  data.high += (0.07 + room) * size;
  return data;
}

}  // namespace

Figure plot_propagation_and_thrust(const Analysis& analysis, const std::filesystem::path& run_folder) {
  CsvTable table({"mu: dimensionless", "c: dimensionless", "c_standard_error: dimensionless", "c_thrust: dimensionless",
                  "c_thrust_standard_error: dimensionless", "difference: dimensionless",
                  "difference_standard_error: dimensionless"});
  Range mu, speed, difference;
  mu.add(0);
  speed.add(tan30);
  difference.add(0);
  std::vector<LeftOut> unknown;
  std::vector<std::string> beyond_three;
  for (const Transport& result : analysis.results) {
    const std::string mu_text = caption_number(result.scanned());
    if (!has_both(result)) {
      const std::string& reason = result.c.known() ? result.c_thrust.reason : result.c.reason;
      unknown.push_back({"μ = " + mu_text, reason});
      continue;
    }
    const Estimate& gap = result.c_minus_c_thrust;
    table.add_row({result.scanned(), result.c.value, result.c.standard_error, result.c_thrust.value,
                   result.c_thrust.standard_error, gap.value, gap.standard_error});
    mu.add(result.scanned());
    if (std::abs(gap.value) > 3 * gap.standard_error && !result.exact) beyond_three.push_back(mu_text);
    for (const int sign : {-1, 1}) {
      speed.add(result.c.value + sign * result.c.standard_error);
      speed.add(result.c_thrust.value);
      difference.add(gap.value + sign * gap.standard_error);
    }
  }
  if (table.empty()) {
    throw InputError(
        "the figure of c beside c_thrust has nothing to show, because no friction coefficient has both; use more "
        "samples or deeper layers, or switch the figure off");
  }
  const Range mu_axis = with_margins(mu, 0.01), speed_axis = with_margins(speed, 0.002);
  const Range difference_axis = with_margins(difference, 0.001);

  const std::string speed_ticks = linear_ticks(speed_axis, 6), difference_ticks = linear_ticks(difference_axis, 6);

  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/propagation_and_thrust";
  plan.height = 2.4;
  plan.data[std::string(figure_id) + ".csv"] = table.text();
  plan.curves = 5;
  return plot_figure(plan,
                     {{"c0", exact(tan30)},
                      {"mu_low", exact(mu_axis.low)},
                      {"mu_high", exact(mu_axis.high)},
                      {"mu_ticks", linear_ticks(mu_axis, 6)},
                      {"speed_low", exact(speed_axis.low)},
                      {"speed_high", exact(speed_axis.high)},
                      {"speed_ticks", speed_ticks},
                      {"speed_room", exact(room_for_labels({speed_ticks}))},
                      {"difference_low", exact(difference_axis.low)},
                      {"difference_high", exact(difference_axis.high)},
                      {"difference_ticks", difference_ticks},
                      {"difference_room", exact(room_for_labels({difference_ticks}))}},
                     {"plot/propagation_and_thrust.captions",
                      {{"unknown", with_reasons(unknown)},
                       {"beyond_three", beyond_three.empty() ? "" : "μ = " + enumeration(beyond_three)}},
                      terms_of(*analysis.scan)},
                     run_folder);
}

}  // namespace granuscope
