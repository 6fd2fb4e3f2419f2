#include "plot/counted_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "counted-work";

double beads_of(const CountedWork& work) {
  return static_cast<double>(work.spec.lattice.columns) * work.spec.lattice.layers;
}

/// Largest over smallest draws per bead among the sizes at one friction coefficient.
double spread_of(const std::vector<const CountedWork*>& sizes) {
  Range range;
  for (const CountedWork* work : sizes) range.add(work->draws_per_bead);
  return range.low > 0 ? range.high / range.low : std::nan("");
}

}  // namespace

Figure draw_counted_work(const std::vector<CountedWork>& work, const std::filesystem::path& run_folder) {
  std::map<double, std::vector<const CountedWork*>> by_mu;
  std::vector<std::string> incomplete;
  Range beads, draws;
  draws.add(0);
  for (const CountedWork& one : work) {
    if (one.failed > 0) {
      incomplete.push_back(fmt::format("{} of {} piles of {} × {} beads at μ = {}", one.failed,
                                       one.failed + one.samples, one.spec.lattice.columns, one.spec.lattice.layers,
                                       caption_number(one.spec.sampler.mu)));
    }
    if (!std::isfinite(one.draws_per_bead)) continue;
    by_mu[one.spec.sampler.mu].push_back(&one);
    beads.add(beads_of(one));
    draws.add(one.draws_per_bead);
  }
  if (by_mu.empty()) {
    throw InputError(
        "the figure of counted work has nothing to show, because no pile was drawn for it; list friction coefficients "
        "in figures.counted_work.mu");
  }

  if (draws.high == 0) draws.add(1);  // without friction nothing is drawn, and an axis has two ends

  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "counted_work";
  plan.height = 2.5;
  std::vector<std::string> curves, titles;
  double worst = 1;
  std::size_t index = 0;
  for (const auto& [mu, sizes] : by_mu) {
    CsvTable table({"beads", "columns", "layers", "piles", "draws_per_bead", "mended_per_bead", "climbed_per_bead"});
    for (const CountedWork* one : sizes) {
      table.add_row({beads_of(*one), static_cast<double>(one->spec.lattice.columns),
                     static_cast<double>(one->spec.lattice.layers), static_cast<double>(one->samples),
                     one->draws_per_bead, one->mended_per_bead, one->climbed_per_bead});
    }
    const std::string file = fmt::format("{}-mu-{}.csv", figure_id, exact(mu));
    plan.data[file] = table.text();
    const std::string style = series_style(index++);
    curves.push_back(
        fmt::format("'{}' using 1:5 with linespoints linewidth 1.2 pointsize 0.55 {} notitle", file, style));
    titles.push_back(fmt::format("keyentry with linespoints linewidth 1.2 pointsize 0.55 {} title {}", style,
                                 gnuplot_string("μ = " + caption_number(mu))));
    if (const double spread = spread_of(sizes); std::isfinite(spread)) worst = std::max(worst, spread);
  }
  plan.curves = static_cast<int>(curves.size());
  const Range axis = widened_by_factor(beads, beads.high > 1.5 * beads.low ? 1.4 : 2);
  Figure figure = draw_plot(plan,
                            {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                             {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                             {"low", exact(axis.low)},
                             {"high", exact(axis.high)},
                             {"ticks", log_ticks(axis)},
                             {"draws_high", exact(1.12 * draws.high)},
                             {"draws_ticks", linear_ticks(draws, 6)}},
                            run_folder);
  set_words(figure, "plot/counted_work.words",
            {{"spread", fmt::format("{:.2f}", worst)},
             {"piles", std::to_string(by_mu.begin()->second.front()->samples)},
             {"incomplete", enumeration(incomplete)}});
  return figure;
}

}  // namespace granuscope
