#include "plot/stress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "stress";

/// The number 1/sqrt(3) and those next to it all read 0.5774.
std::string friction_in_words(double mu) {
  if (mu == tan30) return "1/√3";
  if (mu == std::nextafter(tan30, 0.0)) return "1/√3, one number below";
  if (mu == std::nextafter(tan30, 1.0)) return "1/√3, one number above";
  return mu == 1e-9 ? "10⁻⁹" : caption_number(mu);
}

}  // namespace

Figure draw_stress(const std::vector<StressTrial>& trials, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "stress";
  plan.height = 3.4;
  std::vector<std::string> curves, titles, unsolved;
  Range layers, residuals;
  layers.add(1);
  double worst = 0;
  int columns = 0, deepest = 0;
  for (const StressTrial& trial : trials) {
    if (!trial.deep) continue;
    columns = trial.columns;
    deepest = std::max(deepest, trial.layers);
    if (trial.outcome != "solved") {
      unsolved.push_back(fmt::format("μ = {} ({})", friction_in_words(trial.mu), trial.reason));
      continue;
    }
    CsvTable table({"first_layer", "last_layer", "residual"});
    for (const ResidualAtDepth& range : trial.depths) {
      // A logarithmic axis has no place for layer 0, nor for what balances exactly.
      if (range.first_layer == 0 || !(range.residual > 0)) continue;
      table.add_row({static_cast<double>(range.first_layer), static_cast<double>(range.last_layer), range.residual});
      layers.add(range.first_layer);
      residuals.add(range.residual);
    }
    if (table.empty()) continue;
    worst = std::max(worst, trial.residual);
    const std::string file = fmt::format("{}-{}.csv", figure_id, curves.size() + 1),
                      style = series_style(curves.size());
    plan.data[file] = table.text();
    curves.push_back(
        fmt::format("'{}' using 1:3 with linespoints linewidth 0.8 pointsize 0.5 {} notitle", file, style));
    titles.push_back(fmt::format("keyentry with linespoints linewidth 0.8 pointsize 0.5 {} title {}", style,
                                 gnuplot_string("μ = " + friction_in_words(trial.mu))));
  }
  if (curves.empty()) {
    throw InputError(
        "the stress test has no residuals to show, because none of its deep piles was solved; give "
        "figures.stress.layers "
        "a smaller number");
  }
  plan.curves = static_cast<int>(curves.size());
  const Range across = widened_by_factor(layers, 1.3), up = widened_by_factor(residuals, 2);
  Figure figure = draw_plot(plan,
                            {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                             {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                             {"left", exact(across.low)},
                             {"right", exact(across.high)},
                             {"layer_ticks", log_ticks(across)},
                             {"residual_ticks", log_ticks(up)},
                             {"low", exact(up.low)},
                             {"high", exact(up.high)}},
                            run_folder);
  set_words(figure, "plot/stress.words",
            {{"columns", fmt::format("{}", columns)},
             {"layers", fmt::format("{}", deepest)},
             {"worst", significant(worst, 2)},
             {"unsolved", enumeration(unsolved)}});
  return figure;
}

}  // namespace granuscope
