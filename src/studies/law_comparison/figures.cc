#include "figures.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* thrust_id = "law-comparison";
constexpr const char* cost_id = "law-cost";

std::string in_words(const Estimate& number) {
  return number.known() ? value_with_error(number.value, number.standard_error) : "unknown";
}

std::string name_in_words(const LawOnPiles& one) {
  const SamplerSpec& law = one.spec.sampler;
  const LatticeSpec& lattice = one.spec.lattice;
  const std::string lambda = law.law == Law::polytope ? ", λ = " + caption_number(law.lambda) : "";
  const std::string rules = law.rules == RepairRules::all ? "" : " (" + name_of(law.rules) + ")";
  return fmt::format("{}{}{}, {} × {}", name_of(law.law), rules, lambda, lattice.columns, lattice.layers);
}

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

Figure plot_laws(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = thrust_id;
  plan.script = "studies/law_thrust";
  std::vector<std::string> curves, titles, repaired, failed;
  Range layers, alphas;
  layers.add(0);
  alphas.add(1);
  for (const LawOnPiles& one : laws) {
    CsvTable table({"layer: layers", "thrust_ratio: dimensionless", "thrust_error: dimensionless",
                    "weight_variance: loads of one top bead squared", "variance_error: loads of one top bead squared"});
    for (const ThrustAtDepth& depth : one.depths) {
      if (!depth.thrust_ratio.known()) continue;
      const double alpha = depth.thrust_ratio.value, error = depth.thrust_ratio.standard_error;
      table.add_row({static_cast<double>(depth.layer), alpha, error, depth.weight_variance.value,
                     depth.weight_variance.standard_error});
      layers.add(depth.layer);
      alphas.add(alpha - error);
      alphas.add(alpha + error);
    }
    if (one.failed > 0) {
      failed.push_back(fmt::format("{} of {} piles of {}", one.failed, one.failed + one.samples, name_in_words(one)));
    }
    if (table.empty()) continue;
    const std::string file = fmt::format("{}-{}.csv", thrust_id, curves.size() + 1);
    plan.data[file] = table.text();
    const std::string style = series_style(curves.size());
    curves.push_back(
        fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 0.8 pointsize 0.45 {} notitle", file, style));
    const std::string name = fmt::format("{}:  κ = {}", name_in_words(one), in_words(one.alpha_thrust));
    const std::string work =
        one.draws_per_bead < 100 ? caption_number(one.draws_per_bead, 3) : fmt::format("{:.0f}", one.draws_per_bead);
    titles.push_back(fmt::format(
        "keyentry with points pointsize 0.6 {} title (wide ? {} : {})", style,
        gnuplot_string(fmt::format("{},  var w = {},  {} draws per bead", name, in_words(one.weight_variance), work)),
        gnuplot_string(name)));
    if (one.spec.sampler.law == Law::granusolve && one.spec.sampler.rules == RepairRules::all) {
      repaired.push_back(fmt::format(
          "on {} × {} beads the pair rule gave {:.2f} %, arcs and rings {:.3f} % and backtracks {:.3f} % of the beads "
          "their "
          "value",
          one.spec.lattice.columns, one.spec.lattice.layers, 100 * one.pair_per_bead, 100 * one.arc_per_bead,
          100 * one.backtracked_per_bead));
    }
  }
  if (curves.empty()) {
    throw InputError(
        "the comparison of laws has nothing to show, because no pile of it was completed; give it smaller piles or "
        "less "
        "friction");
  }
  plan.curves = static_cast<int>(curves.size()) + 1;  // the line at 1
  const double key_inches = 0.1 + 0.165 * static_cast<double>(titles.size());
  plan.height = 3.1 + key_inches;
  return plot_figure(plan,
                     {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                      {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                      {"lines", std::to_string(titles.size())},
                      {"key_inches", exact(key_inches)},
                      {"layer_high", exact(layers.high + 1)},
                      {"layer_ticks", linear_ticks(layers, 8)},
                      {"low", exact(alphas.low - 0.02)},
                      {"high", exact(alphas.high + 0.02)},
                      {"ticks", linear_ticks(alphas, 6)}},
                     {"studies/law_thrust.captions",
                      {{"mu", caption_number(laws.front().spec.sampler.mu)},
                       {"repaired", enumeration(repaired)},
                       {"failed", enumeration(failed)}}},
                     run_folder);
}

Figure plot_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder) {
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
        "the figure of the laws' work has nothing to show, because no size was completed; give smaller cost_sizes");
  }
  PlotPlan plan;
  plan.id = cost_id;
  plan.script = "studies/work_against_size";
  plan.half_width = true;
  plan.height = 2.3;
  std::vector<std::string> curves, titles;
  std::map<std::string, std::vector<std::string>> growth;  // of each law
  const LawOnPiles *least = nullptr, *most = nullptr;
  for (const auto& [which, sizes] : curves_of) {
    CsvTable table({"columns: beads", "layers: layers", "piles: piles", "draws_per_bead: draws per bead"});
    for (const LawOnPiles* one : sizes) {
      table.add_row({static_cast<double>(one->spec.lattice.columns), static_cast<double>(one->spec.lattice.layers),
                     static_cast<double>(one->samples), one->draws_per_bead});
    }
    const auto& [law, mu] = which;
    const std::string file = fmt::format("{}-{}-mu-{}.csv", cost_id, law, exact(mu));
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
  std::vector<std::string> of_each_law;
  of_each_law.reserve(growth.size());
  for (const auto& [law, numbers] : growth) of_each_law.push_back(fmt::format("{} {}", law, enumeration(numbers)));
  return plot_figure(plan,
                     {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                      {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                      {"of_laws", "yes"},
                      {"left", exact(columns.low - 0.5)},
                      {"right", exact(columns.high + 0.5)},
                      {"size_ticks", linear_ticks(columns, 8)},
                      {"low", exact(up.low)},
                      {"high", exact(up.high)},
                      {"ticks", log_ticks(up)}},
                     {"studies/law_cost.captions",
                      {{"growth", fmt::format("{}", fmt::join(of_each_law, "; "))},
                       {"piles", std::to_string(most->samples)},
                       {"smallest", size_in_words(*least)},
                       {"largest", size_in_words(*most)},
                       {"incomplete", enumeration(incomplete)}}},
                     run_folder);
}

}  // namespace granuscope
