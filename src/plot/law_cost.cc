#include "plot/law_cost.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "law-cost";

std::string size_in_words(const LawOnPiles& one) {
  return fmt::format("{} × {}", one.spec.lattice.columns, one.spec.lattice.layers);
}

/// "1.47 to 8.32 at μ = 0.3", and with "up to 8 × 8 beads" where the curve ends before the others.
std::string growth_in_words(const LawOnPiles& smallest, const LawOnPiles& largest, double most_columns) {
  const std::string end =
      largest.spec.lattice.columns < most_columns ? fmt::format(" up to {} beads", size_in_words(largest)) : "";
  return fmt::format("{} to {} at μ = {}{}", significant(smallest.draws_per_bead, 3),
                     significant(largest.draws_per_bead, 3), caption_number(largest.spec.sampler.mu), end);
}

}  // namespace

Figure draw_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder) {
  std::map<std::pair<std::string, double>, std::vector<const LawOnPiles*>> curves_of;
  std::vector<std::string> incomplete;
  Range columns, draws;
  draws.add(1);
  for (const LawOnPiles& one : costs) {
    if (one.failed > 0) {
      incomplete.push_back(fmt::format("{} of {} piles of {} × {} beads under {} at μ = {}", one.failed,
                                       one.failed + one.samples, one.spec.lattice.columns, one.spec.lattice.layers,
                                       name_of(one.spec.sampler.law), caption_number(one.spec.sampler.mu)));
    }
    // What failed has drawn without an end: its work is no one's.
    if (one.failed > 0 || !std::isfinite(one.draws_per_bead)) continue;
    curves_of[{name_of(one.spec.sampler.law), one.spec.sampler.mu}].push_back(&one);
    columns.add(one.spec.lattice.columns);
    draws.add(one.draws_per_bead);
  }
  if (curves_of.empty()) {
    throw InputError(
        "the figure of the laws' work has nothing to show, because no size was completed; give smaller "
        "figures.law_comparison.cost_sizes");
  }
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/law_cost";
  plan.height = 3;
  std::vector<std::string> curves, titles;
  std::map<std::string, std::vector<std::string>> growth;  // of each law
  const LawOnPiles *least = nullptr, *most = nullptr;
  for (const auto& [which, sizes] : curves_of) {
    CsvTable table({"columns", "layers", "piles", "draws_per_bead"});
    for (const LawOnPiles* one : sizes) {
      table.add_row({static_cast<double>(one->spec.lattice.columns), static_cast<double>(one->spec.lattice.layers),
                     static_cast<double>(one->samples), one->draws_per_bead});
    }
    const auto& [law, mu] = which;
    const std::string file = fmt::format("{}-{}-mu-{}.csv", figure_id, law, exact(mu));
    plan.data[file] = table.text();
    const std::string style = series_style(curves.size());
    curves.push_back(
        fmt::format("'{}' using 1:4 with linespoints linewidth 1.2 pointsize 0.55 {} notitle", file, style));
    titles.push_back(fmt::format("keyentry with linespoints linewidth 1.2 pointsize 0.55 {} title {}", style,
                                 gnuplot_string(fmt::format("{}, μ = {}", law, caption_number(mu)))));
    growth[law].push_back(growth_in_words(*sizes.front(), *sizes.back(), columns.high));
    if (least == nullptr || sizes.front()->spec.lattice.columns < least->spec.lattice.columns) least = sizes.front();
    if (most == nullptr || sizes.back()->spec.lattice.columns > most->spec.lattice.columns) most = sizes.back();
  }
  plan.curves = static_cast<int>(curves.size());
  const Range up = widened_by_factor(draws, 1.5);
  Figure figure = draw_plot(plan,
                            {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                             {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                             {"left", exact(columns.low - 0.5)},
                             {"right", exact(columns.high + 0.5)},
                             {"column_ticks", linear_ticks(columns, 8)},
                             {"low", exact(up.low)},
                             {"high", exact(up.high)},
                             {"ticks", log_ticks(up)}},
                            run_folder);
  std::vector<std::string> of_each_law;
  of_each_law.reserve(growth.size());
  for (const auto& [law, numbers] : growth) of_each_law.push_back(fmt::format("{} {}", law, enumeration(numbers)));
  set_words(figure, "plot/law_cost.words",
            {{"growth", fmt::format("{}", fmt::join(of_each_law, "; "))},
             {"piles", std::to_string(most->samples)},
             {"smallest", size_in_words(*least)},
             {"largest", size_in_words(*most)},
             {"incomplete", enumeration(incomplete)}});
  return figure;
}

}  // namespace granuscope
