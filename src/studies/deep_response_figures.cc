#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>
#include <set>

#include "ensemble/fluctuation_plan.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_colours.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "studies/deep_response.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

/// Error of a D that is shown, relative to the D of the peaks in the first octave.
constexpr double noisiest = 0.25;

/// Curves of a panel, one for each friction coefficient.
struct Curves {
  std::vector<std::string> drawn;
  Range range;

  /// Columns 1, `value` and `value` + 1 of a data file; y errors are one standard error.
  void add(const std::string& file, int value, const std::string& style, const std::string& dashes) {
    const std::string colour = style.substr(style.find("linecolor"));
    drawn.push_back(fmt::format("'{}' using 1:{} with lines linewidth 0.8{} {} notitle", file, value, dashes, colour));
    drawn.push_back(fmt::format("'{}' using 1:{}:{} with yerrorbars linewidth 0.9 pointsize 0.55 {} notitle", file,
                                value, value + 1, style));
  }
  void reach(const Estimate& one) {
    range.add(one.value - one.standard_error);
    range.add(one.value + one.standard_error);
  }
  std::string script() const { return fmt::format("{}", fmt::join(drawn, ", \\\n    ")); }
};

/// Lines of checks are dashed.
std::string dashes(DeepMeasurement by) {
  return by == DeepMeasurement::fluctuations ? "" : by == DeepMeasurement::wide ? " dashtype 2" : " dashtype 3";
}

std::string data_file(const PlotPlan& plan, const DeepResponse& one) {
  const char* const check = one.by == DeepMeasurement::fluctuations ? ""
                            : one.by == DeepMeasurement::wide       ? "-wide"
                                                                    : "-loads";
  return fmt::format("{}{}-mu-{}.csv", plan.id, check, exact(one.spec.sampler.mu));
}

/// Titles of the curves: one a friction coefficient, one for each kind of check.
class Titles {
 public:
  /// The style of a curve.
  std::string style_of(const DeepResponse& one) {
    const auto [at, first] = styles_.try_emplace(one.spec.sampler.mu, series_style(styles_.size()));
    if (first) titles_.push_back(title(one.spec.sampler.mu, at->second));
    if (one.by != DeepMeasurement::fluctuations) checks_.insert(one.by);
    return at->second;
  }
  bool empty() const { return titles_.empty(); }
  /// Of at most three titles.
  std::size_t rows() const { return (titles_.size() + checks_.size() + 2) / 3; }
  std::string script() const {
    std::vector<std::string> all = titles_;
    for (const DeepMeasurement by : checks_) {
      all.push_back(fmt::format("keyentry with lines linewidth 0.9{} linecolor rgb '{}' title '{}'", dashes(by),
                                plot_colours().at("black"),
                                by == DeepMeasurement::wide ? "twice the columns" : "by loads (multiplexed)"));
    }
    return fmt::format("{}", fmt::join(all, ", \\\n    "));
  }

 private:
  static std::string title(double mu, const std::string& style) {
    return fmt::format("keyentry with linespoints linewidth 0.9 pointsize 0.55 {} title {}", style,
                       gnuplot_string("μ = " + caption_number(mu)));
  }

  std::map<double, std::string> styles_;
  std::vector<std::string> titles_;
  std::set<DeepMeasurement> checks_;
};

void caption(Figure& figure, const std::string& template_name, const std::vector<DeepResponse>& measured) {
  const DeepResponse& first = measured.front();
  set_captions(figure, template_name,
               {{"columns", std::to_string(first.spec.lattice.columns)},
                {"piles", std::to_string(first.samples)},
                {"deepest", caption_number(std::round(first.octaves.back().to))},
                {"reference", std::to_string(fluctuation_plan(first.spec).reference)}});
}

}  // namespace

Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "deep-response";
  plan.script = "studies/deep_response";
  plan.height = 3;
  Curves exponents;
  Titles titles;
  Range depth;
  exponents.range.add(1);
  for (const DeepResponse& one : measured) {
    CsvTable table({"z", "exponent", "standard_error", "z_from", "z_to", "c", "c_error", "D", "D_error"});
    for (const OctaveOfDepth& octave : one.octaves) {
      if (!octave.exponent.known()) continue;
      const double z = std::sqrt(octave.from * octave.to);
      table.add_row({z, octave.exponent.value, octave.exponent.standard_error, octave.from, octave.to, octave.c.value,
                     octave.c.standard_error, octave.D.value, octave.D.standard_error});
      depth.add(z);
      exponents.reach(octave.exponent);
    }
    if (table.empty()) continue;
    const std::string file = data_file(plan, one);
    plan.data[file] = table.text();
    exponents.add(file, 2, titles.style_of(one), dashes(one.by));
  }
  if (titles.empty()) {
    throw InputError(
        "the figure of the response with depth has nothing to show, because no two lags were fitted; give "
        "studies.deep_response.mu where peaks stand apart, or more piles");
  }
  plan.curves = static_cast<int>(exponents.drawn.size()) + 1;  // and the line at 1
  const Range axis = widened_by_factor(depth, 1.4);
  const double room = 0.06 * exponents.range.size();
  Figure figure = plot_figure(plan,
                              {{"curves", exponents.script()},
                               {"titles", titles.script()},
                               {"key_rows", std::to_string(titles.rows())},
                               {"key_inches", exact(0.17 * static_cast<double>(titles.rows()))},
                               {"left", exact(axis.low)},
                               {"right", exact(axis.high)},
                               {"depth_ticks", log_ticks(axis)},
                               {"low", exact(exponents.range.low - room)},
                               {"high", exact(exponents.range.high + room)},
                               {"ticks", linear_ticks(exponents.range, 6)}},
                              run_folder);
  caption(figure, "studies/deep_response.captions", measured);
  return figure;
}

Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "dispersion";
  plan.script = "studies/dispersion";
  plan.height = 3;
  Curves speeds, diffusions;
  Titles titles;
  Range waves;
  speeds.range.add(0);
  for (const DeepResponse& one : measured) {
    CsvTable table({"k", "D", "D_error", "c_minus_c_thrust", "c_error", "c", "k_from", "k_to", "z_from", "z_to"});
    for (const BandOfModes& band : one.bands) {
      // A logarithmic axis shows positive numbers only: to leave out the others of a noisy band would be a choice.
      if (!(band.D.standard_error < noisiest * one.octaves.front().D.value) || !(band.D.value > 0)) continue;
      const Estimate above{band.c.value - one.c_thrust.value, band.c.standard_error, ""};
      table.add_row({band.k, band.D.value, band.D.standard_error, above.value, above.standard_error, band.c.value,
                     band.k_from, band.k_to, band.z_from, band.z_to});
      waves.add(band.k);
      diffusions.reach(band.D);
      speeds.reach(above);
    }
    if (table.empty()) continue;
    const std::string file = data_file(plan, one), style = titles.style_of(one);
    plan.data[file] = table.text();
    diffusions.add(file, 2, style, dashes(one.by));
    speeds.add(file, 4, style, dashes(one.by));
  }
  if (titles.empty()) {
    throw InputError(
        "the figure of the dispersion relation has nothing to show, because no band of modes was fitted; give "
        "studies.deep_response.mu where peaks stand apart, or more piles");
  }
  plan.curves = static_cast<int>(speeds.drawn.size() + diffusions.drawn.size()) + 2;  // and a guide in each panel
  const Range axis = widened_by_factor(waves, 1.3), D_axis = widened_by_factor(diffusions.range, 1.3);
  const double room = 0.06 * speeds.range.size();
  Figure figure = plot_figure(plan,
                              {{"c_curves", speeds.script()},
                               {"D_curves", diffusions.script()},
                               {"titles", titles.script()},
                               {"key_rows", std::to_string(titles.rows())},
                               {"key_inches", exact(0.17 * static_cast<double>(titles.rows()))},
                               {"left", exact(axis.low)},
                               {"right", exact(axis.high)},
                               {"k_ticks", log_ticks(axis)},
                               {"c_low", exact(speeds.range.low - room)},
                               {"c_high", exact(speeds.range.high + room)},
                               {"c_ticks", linear_ticks(speeds.range, 6)},
                               {"D_low", exact(D_axis.low)},
                               {"D_high", exact(D_axis.high)},
                               {"D_ticks", log_ticks(D_axis)}},
                              run_folder);
  caption(figure, "studies/dispersion.captions", measured);
  return figure;
}

}  // namespace granuscope
