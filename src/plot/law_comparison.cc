#include "plot/law_comparison.h"

#include <fmt/format.h>

#include <cmath>

#include "plot/choice.h"
#include "plot/csv_table.h"
#include "plot/figure_words.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr const char* figure_id = "law-comparison";

std::string in_words(const Estimate& number) {
  return number.known() ? value_with_error(number.value, number.standard_error) : "unknown";
}

std::string name_in_words(const LawOnPiles& one) {
  const SamplerSpec& law = one.spec.sampler;
  const LatticeSpec& lattice = one.spec.lattice;
  const std::string lambda = law.law == Law::polytope ? ", λ = " + caption_number(law.lambda) : "";
  const std::string rules = law.rules == MendingRules::all ? "" : " (" + name_of(law.rules) + ")";
  return fmt::format("{}{}{}, {} × {}", name_of(law.law), rules, lambda, lattice.columns, lattice.layers);
}

}  // namespace

Figure draw_law_comparison(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = figure_id;
  plan.script = "plot/law_comparison";
  plan.height = 5;
  std::vector<std::string> curves, titles, mended, failed;
  Range layers, alphas;
  layers.add(0);
  alphas.add(1);
  for (const LawOnPiles& one : laws) {
    CsvTable table({"layer", "thrust_ratio", "thrust_error", "weight_variance", "variance_error"});
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
    const std::string file = fmt::format("{}-{}.csv", figure_id, curves.size() + 1);
    plan.data[file] = table.text();
    const std::string style = series_style(curves.size());
    curves.push_back(
        fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 0.8 pointsize 0.45 {} notitle", file, style));
    titles.push_back(
        fmt::format("keyentry with points pointsize 0.6 {} title {}", style,
                    gnuplot_string(fmt::format("{}:  α = {},  var w = {},  {} draws per bead", name_in_words(one),
                                               in_words(one.alpha_thrust), in_words(one.weight_variance),
                                               one.draws_per_bead < 100 ? caption_number(one.draws_per_bead, 3)
                                                                        : fmt::format("{:.0f}", one.draws_per_bead)))));
    if (one.spec.sampler.law == Law::granusolve && one.spec.sampler.rules == MendingRules::all) {
      mended.push_back(fmt::format(
          "on {} × {} beads the pair rule gave {:.2f} %, arcs and rings {:.3f} % and climbs {:.3f} % of the beads "
          "their "
          "value",
          one.spec.lattice.columns, one.spec.lattice.layers, 100 * one.pair_per_bead, 100 * one.arc_per_bead,
          100 * one.climbed_per_bead));
    }
  }
  if (curves.empty()) {
    throw InputError(
        "the comparison of laws has nothing to show, because no pile was drawn for it; give "
        "figures.law_comparison.samples");
  }
  plan.curves = static_cast<int>(curves.size()) + 1;  // the line at 1
  Figure figure = draw_plot(plan,
                            {{"curves", fmt::format("{}", fmt::join(curves, ", \\\n    "))},
                             {"titles", fmt::format("{}", fmt::join(titles, ", \\\n    "))},
                             {"layer_high", exact(layers.high + 1)},
                             {"layer_ticks", linear_ticks(layers, 8)},
                             {"low", exact(alphas.low - 0.02)},
                             {"high", exact(alphas.high + 0.02)},
                             {"ticks", linear_ticks(alphas, 6)}},
                            run_folder);
  set_words(figure, "plot/law_comparison.words",
            {{"mu", caption_number(laws.front().spec.sampler.mu)},
             {"mended", enumeration(mended)},
             {"failed", enumeration(failed)}});
  return figure;
}

}  // namespace granuscope
