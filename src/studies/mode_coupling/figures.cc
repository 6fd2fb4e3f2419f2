#include "studies/mode_coupling/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "studies/mode_coupling/kpz_peak.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr int line_steps = 40;
constexpr double most_error_shown = 0.25;

std::string title_of(double mu) { return "μ = " + caption_number(mu); }

std::string said_of(const Estimate& number, double mu) {
  return fmt::format("{} at μ = {}", in_words(number), caption_number(mu));
}

double bell(double x) { return std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi); }

}  // namespace

Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "predicted-width";
  plot.height = 3.6;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  Panel panel;
  std::vector<std::string> ratios;
  Range z, spreading;
  for (const CoupledSpreading& one : measured) {
    const std::vector<double>& predicted = one.predicted.width_squared;
    if (predicted.empty()) continue;
    CsvTable table({"z: bead diameters", "measured: bead diameters", "standard_error: bead diameters",
                    "predicted: bead diameters", "by_waves: bead diameters"});
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const LagResponse& lag = one.response.lags[i];
      const double at = lag.z;
      const auto& by_waves = one.from_waves.width_squared;
      table.add_row({at, lag.width_squared.value / at, lag.width_squared.standard_error / at, predicted[i] / at,
                     by_waves.empty() ? std::nan("") : by_waves[i] / at});
      z.add(at);
      spreading.add(lag.width_squared.value / at);
      spreading.add(predicted[i] / at);
    }
    const std::string file = plot.add_data("mu-" + exact(one.mu), table);
    const Ink ink = ink_of_series(plot.key.entries.size());
    panel.add(file, "1:4", ink.line(1.2));
    panel.add(file, "1:5", ink.line(0.8, 2));
    panel.add(file, "1:2:3", ink.bars(0.9, 0.6));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    if (one.strength.known()) ratios.push_back(said_of(one.strength, one.mu));
  }
  if (panel.curves.empty()) {
    throw InputError(
        "the figure of the predicted widths has nothing to show: the response is not known at every lag of any "
        "friction coefficient; give the study more piles");
  }
  plot.add_key("predicted", {.width = 1.2});
  plot.add_key("from D(k)", {.width = 0.8, .dash = 2});
  panel.x = log_axis("depth z  (bead diameters)", widened_by_factor(z, 1.4));
  panel.y = log_axis("W²/z  (bead diameters)", widened_by_factor(spreading, 1.3));
  plot.panels = {panel};
  return plot_figure(plot,
                     {"studies/predicted_width.captions",
                      {{"strengths", enumeration(ratios)},
                       {"first", caption_number(std::round(z.low))},
                       {"deepest", caption_number(std::round(z.high))},
                       {"piles", std::to_string(measured.front().response.samples)}}},
                     run_folder);
}

Figure plot_waves(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "waves-of-sound";
  plot.height = 3;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  Panel spreading = left_panel(), speed = right_panel();
  std::vector<std::string> chi2, ratios;
  Range k, diffusion, faster;
  faster.add(0);
  for (const CoupledSpreading& one : measured) {
    if (!one.of_waves.B.known()) continue;
    const double D = one.of_waves.D.value, B = one.of_waves.B.value;
    CsvTable table({"k: 1/bead diameter", "D: bead diameters", "standard_error: bead diameters",
                    "c_less_c_thrust: dimensionless", "standard_error: dimensionless"});
    Range waves;
    for (const BandOfModes& band : one.response.bands) {
      if (!band.D.known() || !band.c.known() || band.D.standard_error > most_error_shown * band.D.value) continue;
      const double ahead = band.c.value - one.response.c_thrust.value;
      table.add_row({band.k, band.D.value, band.D.standard_error, ahead, band.c.standard_error});
      waves.add(band.k);
      diffusion.add(band.D.value, band.D.standard_error);
      faster.add(ahead, band.c.standard_error);
    }
    if (table.empty()) continue;
    CsvTable form({"k: 1/bead diameter", "D: bead diameters", "c_less_c_thrust: dimensionless"});
    for (int step = 0; step <= line_steps; ++step) {
      const double at = waves.low * std::pow(waves.high / waves.low, static_cast<double>(step) / line_steps);
      form.add_row({at, D + 2 * B / std::sqrt(at), B * std::sqrt(at)});
      faster.add(B * std::sqrt(at));
    }
    k.add(waves.low);
    k.add(waves.high);
    const std::string file = plot.add_data("mu-" + exact(one.mu), table),
                      line = plot.add_data("form-mu-" + exact(one.mu), form);
    const Ink ink = ink_of_series(plot.key.entries.size());
    spreading.add(line, "1:2", ink.line(1));
    spreading.add(file, "1:2:3", ink.bars(0.8, 0.5));
    speed.add(line, "1:3", ink.line(1));
    speed.add(file, "1:4:5", ink.bars(0.8, 0.5));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    chi2.push_back(fmt::format("{:.1f} of {} at μ = {}", one.of_waves.chi2, one.of_waves.degrees_of_freedom,
                               caption_number(one.mu)));
    if (one.speeds.ratio.known()) ratios.push_back(said_of(one.speeds.ratio, one.mu));
  }
  if (plot.key.entries.empty()) {
    throw InputError(
        "the figure of the waves has nothing to show: no diffusion coefficient is known of waves of one length; give "
        "the study more piles");
  }
  plot.add_key("D + 2 B k^{−1/2}, B k^{1/2}", {.width = 1});
  spreading.x = speed.x = log_axis("wave number k  (1/bead diameter)", widened_by_factor(k, 1.2));
  spreading.y = log_axis("D(k)  (bead diameters)", widened_by_factor(diffusion, 1.3));
  speed.y = linear_axis("c(k) − c_thrust", widened(faster, 0.06), 6, faster);
  plot.panels = {spreading, speed};
  return plot_figure(
      plot, {"studies/waves_of_sound.captions", {{"chi2", enumeration(chi2)}, {"ratios", enumeration(ratios)}}},
      run_folder);
}

Figure plot_peak_shape(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "peak-shape";
  plot.height = 3;
  plot.key = {.inches = 0.55, .lines = 2, .centred = true, .entries = {}};
  const auto shown =
      std::find_if(measured.rbegin(), measured.rend(), [](const auto& one) { return !one.peaks.empty(); });
  if (shown == measured.rend()) {
    throw InputError(
        "the figure of the peaks' shape has nothing to show: the response is not known at every lag; give it "
        "more piles");
  }
  const double root = std::sqrt(kpz_peak().variance);
  const Style gaussian{.width = 0.9, .dash = 2}, kpz{.width = 0.9, .dash = 3},
      levy{.colour = "vermilion", .width = 1.3};
  Panel heights = left_panel(), excess = right_panel();
  Range difference;
  CsvTable shapes({"x: widths", "gaussian: dimensionless", "kpz: dimensionless"});
  const auto entries = static_cast<std::ptrdiff_t>(kpz_peak().density.size());
  for (std::ptrdiff_t i = 1 - entries; i < entries; ++i) {
    const double x = KpzPeak::step * static_cast<double>(i) / root;
    const double height = root * kpz_peak().density[static_cast<std::size_t>(std::abs(i))];
    if (std::abs(x) > 4) continue;
    shapes.add_row({x, bell(x), height});
    difference.add(height - bell(x));
  }
  const std::string theory = plot.add_data("theory", shapes);
  heights.add(theory, "1:2", gaussian);
  heights.add(theory, "1:3", kpz);
  excess.add(theory, "1:(0)", gaussian);
  excess.add(theory, "1:($3-$2)", kpz);
  std::vector<std::string> words;
  for (std::size_t i = 0; i < shown->peaks.size(); ++i) {
    const ScaledPeak& peak = shown->peaks[i];
    CsvTable table(
        {"x: widths", "height: dimensionless", "standard_error: dimensionless", "above_gaussian: dimensionless"});
    double next = -100;
    for (std::size_t j = 0; j < peak.x.size(); ++j) {
      const double x = peak.x[j];
      if (x < next) continue;
      next = x + 0.16;
      const double above = peak.height[j].value - bell(x);
      table.add_row({x, peak.height[j].value, peak.height[j].standard_error, above});
      difference.add(above, peak.height[j].standard_error);
    }
    const std::string file = plot.add_data(std::to_string(i + 1), table);
    const Ink ink = ink_of_series(i);
    heights.add(file, "1:2", ink.points(0.4));
    excess.add(file, "1:4:3", ink.bars(0.7, 0.4));
    plot.add_key(fmt::format("z = {:.0f}", peak.z), ink.points(0.6));
    const PeakShapeTest& test = shown->shapes[i];
    words.push_back(fmt::format("{:.0f}, {:.0f} and {:.0f} at z = {:.0f}", test.gaussian, test.kpz, test.levy, test.z));
  }
  const double deepest = shown->peaks.back().z;
  const ScaledPeak form = scaled_peak(shown->form, deepest, shown->response.spec.lattice.columns);
  CsvTable predicted({"x: widths", "height: dimensionless", "above_gaussian: dimensionless"});
  for (std::size_t i = 0; i < form.x.size(); ++i) {
    const double above = form.height[i].value - bell(form.x[i]);
    predicted.add_row({form.x[i], form.height[i].value, above});
    difference.add(above);
  }
  const std::string file = plot.add_data("predicted", predicted);
  heights.add(file, "1:2", levy);
  excess.add(file, "1:3", levy);
  plot.add_key(fmt::format("predicted, z = {:.0f}", deepest), levy);
  plot.add_key("Gaussian", gaussian);
  plot.add_key("f_{KPZ}", kpz);
  heights.x = excess.x = {"(x − xₚ)/W", -4, 4, false, {{"−4", -4}, {"−2", -2}, {"0", 0}, {"2", 2}, {"4", 4}}};
  heights.y = linear_axis("2 W P(x)", {-0.02, 0.48, false}, 6);
  excess.y = linear_axis("2 W P − Gaussian", widened(difference, 0.06), 6, difference);
  excess.name = 0.51;
  plot.panels = {heights, excess};
  return plot_figure(plot,
                     {"studies/peak_shape.captions",
                      {{"mu", caption_number(shown->mu)},
                       {"chi2", enumeration(words)},
                       {"degrees", std::to_string(shown->shapes.back().degrees_of_freedom)}}},
                     run_folder);
}

}  // namespace granuscope
