#include "figure.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>

#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

constexpr double percent = 100, milli = 1000;

/// The responses to one kind of load at one friction coefficient, in the order of the loads.
struct Series {
  double mu = 0;
  EstimatorName estimator;
  std::vector<const LoadResponse*> loads;
};

struct Panels {
  std::vector<std::string> D_curves, c_curves, titles;
  Range load, D, c;
};

void add(Range& range, const Estimate& shift, double scale) {
  range.add(scale * (shift.value - shift.standard_error));
  range.add(scale * (shift.value + shift.standard_error));
}

void add_series(PlotPlan& plan, Panels& panels, const Series& series, std::size_t colour) {
  CsvTable table({"load: loads of one top bead", "D_shift_percent: %", "standard_error: %",
                  "c_shift_thousandths: 0.001", "standard_error: 0.001", "D: bead diameters",
                  "standard_error: bead diameters", "c: dimensionless", "standard_error: dimensionless",
                  "piles: piles"});
  for (const LoadResponse* one : series.loads) {
    if (!one->D_shift.known() || !one->c_shift.known()) continue;
    table.add_row({one->load(), percent * one->D_shift.value, percent * one->D_shift.standard_error,
                   milli * one->c_shift.value, milli * one->c_shift.standard_error, one->D.value, one->D.standard_error,
                   one->c.value, one->c.standard_error, static_cast<double>(one->samples)});
    panels.load.add(one->load());
    add(panels.D, one->D_shift, percent);
    add(panels.c, one->c_shift, milli);
  }
  if (table.empty()) return;
  const std::string file = fmt::format("{}-{}-mu-{}.csv", plan.id, name_of(series.estimator), exact(series.mu));
  plan.data[file] = table.text();
  const bool point = series.estimator == EstimatorName::point;
  const std::string style = fmt::format("with yerrorlines linewidth {} dashtype {} pointsize {} {} notitle",
                                        point ? 1.2 : 0.8, point ? 1 : 2, point ? 0.55 : 0.35, series_style(colour));
  panels.D_curves.push_back(fmt::format("'{}' using 1:2:3 {}", file, style));
  panels.c_curves.push_back(fmt::format("'{}' using 1:4:5 {}", file, style));
  plan.curves += 2;
  if (point) {
    panels.titles.push_back(fmt::format("keyentry with points pointsize 0.6 {} title {}", series_style(colour),
                                        gnuplot_string("μ = " + caption_number(series.mu))));
  }
}

std::string in_percent(const Estimate& shift) {
  return value_with_error(percent * shift.value, percent * shift.standard_error) + " %";
}

/// A mark for each load.
std::string load_marks(const LoadComparison& measured) {
  std::set<double> loads;
  for (const LoadResponse& one : measured.responses) {
    if (one.load() > 0) loads.insert(one.load());
  }
  std::vector<std::string> marks;
  marks.reserve(loads.size());
  for (const double load : loads) marks.push_back(fmt::format("'{}' {}", caption_number(load), exact(load)));
  return fmt::format("{}", fmt::join(marks, ", "));
}

/// "μ = 0.1: −24(3) %" for the overload nearest to the paper's.
std::vector<std::string> shifts_of_the_paper(const LoadComparison& measured) {
  std::vector<std::string> shifts;
  for (const LoadResponse& one : measured.responses) {
    const bool of_the_paper = one.spec.response.estimator == EstimatorName::point && one.load() == 1;
    if (!of_the_paper || !one.D_shift.known()) continue;
    shifts.push_back(fmt::format("{} at μ = {}", in_percent(one.D_shift), caption_number(one.spec.sampler.mu)));
  }
  return shifts;
}

}  // namespace

Figure plot_load_comparison(const LoadComparison& measured, const std::string& study,
                            const std::filesystem::path& run_folder) {
  std::vector<Series> all;
  std::map<double, std::size_t> colours;
  double reference = 0;
  for (const LoadResponse& one : measured.responses) {
    if (one.reference) reference = one.load();
    if (one.uniform()) continue;  // there is no response
    const double mu = one.spec.sampler.mu;
    const EstimatorName estimator = one.spec.response.estimator;
    colours.emplace(mu, colours.size());
    if (all.empty() || all.back().mu != mu || all.back().estimator != estimator) all.push_back({mu, estimator, {}});
    all.back().loads.push_back(&one);
  }
  PlotPlan plan;
  plan.id = study;
  plan.script = "studies/" + study;
  plan.height = 3.0;
  Panels panels;
  panels.D.add(0);
  panels.c.add(0);
  for (const Series& series : all) add_series(plan, panels, series, colours.at(series.mu));
  if (plan.curves == 0) {
    throw InputError(
        "the figure of the loads has nothing to show, because nothing could be compared with the linear response; list "
        "friction coefficients at which the width of the peaks can be told");
  }
  plan.curves += 2;  // the lines at 0
  const auto with_margin = [](const Range& range) {
    const double margin = 0.06 * range.size();
    return std::array{range.low - margin, range.high + margin};
  };
  const auto D = with_margin(panels.D), c = with_margin(panels.c);
  const Range load = widened_by_factor(panels.load, 1.3);
  return plot_figure(
      plan,
      {{"D_curves", fmt::format("{}", fmt::join(panels.D_curves, ", \\\n    "))},
       {"c_curves", fmt::format("{}", fmt::join(panels.c_curves, ", \\\n    "))},
       {"titles", fmt::format("{}", fmt::join(panels.titles, ", \\\n    "))},
       {"load_low", exact(load.low)},
       {"load_high", exact(load.high)},
       {"load_ticks", load_marks(measured)},
       {"D_low", exact(D[0])},
       {"D_high", exact(D[1])},
       {"D_ticks", linear_ticks(panels.D, 7)},
       {"c_low", exact(c[0])},
       {"c_high", exact(c[1])},
       {"c_ticks", linear_ticks(panels.c, 7)}},
      {"studies/" + study + ".captions",
       {{"reference", caption_number(reference)}, {"paper_shifts", enumeration(shifts_of_the_paper(measured))}}},
      run_folder);
}

}  // namespace granuscope
