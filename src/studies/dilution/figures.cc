#include "figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/csv_table.h"
#include "plot/figure_captions.h"
#include "plot/plot_script.h"
#include "plot/series_style.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

std::string joined(const std::vector<std::string>& items) { return fmt::format("{}", fmt::join(items, ", \\\n    ")); }

std::string colour_of(const std::string& style) { return style.substr(style.find("linecolor")); }

std::string key_entry(const std::string& style, const std::string& title) {
  return fmt::format("keyentry with linespoints linewidth 1 pointsize 0.55 {} title {}", style, gnuplot_string(title));
}

}  // namespace

Figure plot_solvable_shares(const DilutedPiles& measured, const std::filesystem::path& run_folder) {
  if (measured.solvable.empty()) {
    throw InputError(
        "the figure of solvable piles has nothing to show: no pile was tried; give the study mu, sizes and shares");
  }
  PlotPlan plan;
  plan.id = "solvable-piles";
  plan.script = "studies/solvable_piles";
  plan.height = 3.3;
  std::vector<std::string> by_size, by_friction, titles;
  // Left: all sizes at the largest friction; right: all frictions at the smallest size.
  const double most_mu = measured.solvable.back().mu;
  const int least_size = measured.solvable.front().size;
  double most_share = 0;
  for (std::size_t first = 0, next = 0; first < measured.solvable.size(); first = next) {
    const SolvableShare& head = measured.solvable[first];
    CsvTable table({"opened_share: dimensionless", "solvable_share: dimensionless", "standard_error: dimensionless",
                    "solvable_at_the_edge_too: dimensionless", "standard_error: dimensionless",
                    "no_idle_bead: dimensionless"});
    for (next = first; next < measured.solvable.size(); ++next) {
      const SolvableShare& one = measured.solvable[next];
      if (one.mu != head.mu || one.size != head.size) break;
      const Estimate inside = one.solvable(), at_all = one.at_all();
      table.add_row(
          {one.share, inside.value, inside.standard_error, at_all.value, at_all.standard_error, one.no_idle_bead});
      most_share = std::max(most_share, one.share);
    }
    const std::string file = fmt::format("{}-mu-{}-size-{}.csv", plan.id, exact(head.mu), head.size);
    plan.data[file] = table.text();
    const auto add = [&](std::vector<std::string>& curves, const std::string& title, bool bound) {
      const std::string style = series_style(titles.size());
      curves.push_back(
          fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 1 pointsize 0.55 {} notitle", file, style));
      if (bound) {
        curves.push_back(fmt::format("'{}' using 1:6 with lines dashtype 3 {} notitle", file, colour_of(style)));
      }
      titles.push_back(key_entry(style, title));
      plan.curves += bound ? 2 : 1;
    };
    if (head.mu == most_mu) add(by_size, fmt::format("left: {0} × {0} beads", head.size), true);
    if (head.size == least_size) add(by_friction, fmt::format("right: μ = {}", caption_number(head.mu)), false);
  }
  Range shares;
  shares.add(0);
  shares.add(std::max(most_share, 0.01));
  return plot_figure(plan,
                     {{"by_size", joined(by_size)},
                      {"by_friction", joined(by_friction)},
                      {"titles", joined(titles)},
                      {"share_high", exact(1.04 * shares.high)},
                      {"share_ticks", linear_ticks(shares, 6)}},
                     {"studies/solvable_piles.captions",
                      {{"piles", fmt::format("{}", measured.solvable.front().piles)},
                       {"mu", caption_number(most_mu)},
                       {"size", fmt::format("{}", least_size)}}},
                     run_folder);
}

Figure plot_diluted_responses(const DilutedPiles& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "diluted-response";
  plan.script = "studies/diluted_response";
  plan.height = 3.3;
  std::vector<std::string> profiles, peaks, titles, mu;
  Range height, lengths, shares;
  height.add(0);
  lengths.add(0);
  shares.add(0);
  double z = 0;
  for (std::size_t first = 0, next = 0; first < measured.responses.size(); first = next) {
    const DilutedResponse& head = measured.responses[first];
    CsvTable table({"opened_share: dimensionless", "peak_position: bead diameters", "standard_error: bead diameters",
                    "width: bead diameters", "standard_error: bead diameters"});
    for (next = first; next < measured.responses.size() && measured.responses[next].mu == head.mu; ++next) {
      const DilutedResponse& one = measured.responses[next];
      if (!one.profile) continue;
      CsvTable profile({"x: bead diameters", "response: per bead", "standard_error: per bead"});
      for (std::size_t i = 0; i < one.profile->x.size(); ++i) {
        profile.add_row({one.profile->x[i], one.profile->pressure[i], one.profile->standard_error[i]});
        height.add(one.profile->pressure[i]);
      }
      const std::string file = fmt::format("{}-mu-{}-share-{}.csv", plan.id, exact(one.mu), exact(one.share));
      plan.data[file] = profile.text();
      const std::string style = series_style(titles.size());
      profiles.push_back(
          fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 1 pointsize 0.5 {} notitle", file, style));
      titles.push_back(
          key_entry(style, fmt::format("μ = {}, q = {}", caption_number(one.mu), caption_number(one.share))));
      ++plan.curves;
      z = one.z;
      shares.add(one.share);
      if (!one.position.known() || !one.width.known()) continue;
      table.add_row(
          {one.share, one.position.value, one.position.standard_error, one.width.value, one.width.standard_error});
      lengths.add(one.position.value);
      lengths.add(one.width.value);
    }
    mu.push_back(caption_number(head.mu));
    if (table.empty()) continue;
    const std::string file = fmt::format("{}-mu-{}.csv", plan.id, exact(head.mu));
    plan.data[file] = table.text();
    const std::string style = series_style(titles.size() - 1);
    peaks.push_back(fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 1 pointtype 7 pointsize 0.6 {} notitle",
                                file, colour_of(style)));
    peaks.push_back(
        fmt::format("'{}' using 1:4:5 with yerrorlines linewidth 1 dashtype 3 pointtype 6 pointsize 0.6 {} notitle",
                    file, colour_of(style)));
    plan.curves += 2;
  }
  if (profiles.empty() || peaks.empty()) {
    throw InputError(
        "the figure of the response of diluted piles has nothing to show, because no peaks were found; give a larger "
        "number of samples, or smaller shares");
  }
  shares.add(shares.high + 0.01);
  const double half = 0.5 * measured.responses.front().columns;
  Range inner;  // no label at a corner of the panel
  inner.add(-0.7 * half);
  inner.add(0.7 * half);
  return plot_figure(plan,
                     {{"profiles", joined(profiles)},
                      {"peaks", joined(peaks)},
                      {"titles", joined(titles)},
                      {"reach", exact(half)},
                      {"x_ticks", linear_ticks(inner, 5)},
                      {"height_low", exact(height.low - 0.03 * height.size())},
                      {"height_high", exact(height.high + 0.05 * height.size())},
                      {"height_ticks", linear_ticks(height, 6)},
                      {"share_high", exact(shares.high)},
                      {"share_ticks", linear_ticks(shares, 5)},
                      {"length_high", exact(1.1 * lengths.high)},
                      {"length_ticks", linear_ticks(lengths, 6)}},
                     {"studies/diluted_response.captions",
                      {{"mu", enumeration(mu)},
                       {"z", caption_number(z)},
                       {"columns", fmt::format("{}", measured.responses.front().columns)},
                       {"layers", fmt::format("{}", measured.responses.front().layers)}}},
                     run_folder);
}

}  // namespace granuscope
