#include "studies/mode_coupling/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "studies/mode_coupling/theory.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Point types of checks: open squares and circles.
constexpr int wide_points = 4, loads_points = 6;

std::string title_of(double mu) { return "μ = " + caption_number(mu); }

}  // namespace

Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "predicted-width";
  plot.height = 3.6;
  plot.key = {.inches = 0.72, .lines = 3, .centred = true, .entries = {}};
  Panel panel;
  std::vector<std::string> ratios, words;
  std::map<std::string, int> checked;
  bool loads_predicted = false;
  Range z, spreading;
  for (const CoupledSpreading& one : measured) {
    const std::vector<double>& predicted = one.predicted.width_squared;
    if (predicted.empty()) continue;
    CsvTable table({"z: bead diameters", "measured: bead diameters", "standard_error: bead diameters",
                    "predicted: bead diameters", "predicted_error: bead diameters", "without_torque: bead diameters"});
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const LagResponse& lag = one.response.lags[i];
      const double at = lag.z;
      table.add_row({at, lag.width_squared.value / at, lag.width_squared.standard_error / at, predicted[i] / at,
                     one.predicted.width_squared_error[i] / at, one.without_torque.width_squared[i] / at});
      z.add(at);
      spreading.add(lag.width_squared.value / at);
      spreading.add(predicted[i] / at);
    }
    const std::string file = plot.add_data("mu-" + exact(one.mu), table);
    const Ink ink = ink_of_series(plot.key.entries.size());
    panel.add(file, "1:4", ink.line(1.2));
    panel.add(file, "1:6", ink.line(0.8, 2));
    panel.add(file, "1:2:3", ink.bars(0.9, 0.6));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    for (const CheckedSpreading& check : one.checks) {
      const bool wide = check.response.by == DeepMeasurement::wide;
      CsvTable points({"z: bead diameters", "measured: bead diameters", "standard_error: bead diameters"});
      for (const LagResponse& lag : check.response.lags) {
        if (!lag.width_squared.known()) continue;
        points.add_row({lag.z, lag.width_squared.value / lag.z, lag.width_squared.standard_error / lag.z});
        spreading.add(lag.width_squared.value / lag.z);
      }
      if (!wide && !check.predicted.width_squared.empty()) {
        CsvTable line({"z: bead diameters", "predicted: bead diameters"});
        for (std::size_t i = 0; i < check.response.lags.size(); ++i) {
          const double at = check.response.lags[i].z;
          line.add_row({at, check.predicted.width_squared[i] / at});
          spreading.add(check.predicted.width_squared[i] / at);
        }
        panel.add(plot.add_data("loads-predicted-mu-" + exact(one.mu), line), "1:2", ink.line(1.2, 3));
        loads_predicted = true;
      }
      panel.add(plot.add_data(fmt::format("{}-mu-{}", wide ? "wide" : "loads", exact(one.mu)), points), "1:2:3",
                Ink{ink.colour, wide ? wide_points : loads_points}.bars(0.7, 1.1));
      checked[wide ? "twice the columns" : "by loads (multiplexed)"] = wide ? wide_points : loads_points;
      words.push_back(fmt::format("{:.1f} at μ = {} {}", check.predicted.chi2, caption_number(one.mu),
                                  wide ? "in piles twice as wide" : "by loads"));
    }
    if (one.fit.strength.known())
      ratios.push_back(fmt::format("{} at μ = {}", in_words(one.fit.strength), caption_number(one.mu)));
  }
  if (panel.curves.empty()) {
    throw InputError(
        "the figure of the predicted widths has nothing to show: the response is not known at every lag of any "
        "friction coefficient; give the study more piles");
  }
  for (const auto& [title, marker] : checked) plot.add_key(title, Ink{"black", marker}.points(1.1));
  plot.add_key("predicted", {.width = 1.2});
  plot.add_key("without torque", {.width = 0.8, .dash = 2});
  if (loads_predicted) plot.add_key("predicted, by loads", {.width = 1.2, .dash = 3});
  panel.x = log_axis("depth z  (bead diameters)", widened_by_factor(z, 1.4));
  panel.y = log_axis("W²/z  (bead diameters)", widened_by_factor(spreading, 1.3));
  plot.panels = {panel};
  return plot_figure(plot,
                     {"studies/predicted_width.captions",
                      {{"strengths", enumeration(ratios)},
                       {"checks", words.empty() ? "" : enumeration(words)},
                       {"octaves", std::to_string(measured.front().response.octaves.size() - 1)},
                       {"first", caption_number(std::round(z.low))},
                       {"deepest", caption_number(std::round(z.high))},
                       {"piles", std::to_string(measured.front().response.samples)}}},
                     run_folder);
}

Figure plot_coupling(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "coupling-of-fields";
  plot.height = 3;
  plot.key = {.inches = 0.72, .lines = 3, .centred = true, .entries = {}};
  Panel thrust = left_panel(), spectra = right_panel();
  Range square, change, k, power;
  change.add(0);
  square.add(0);
  for (const CoupledSpreading& one : measured) {
    const Ink ink = ink_of_series(plot.key.entries.size());
    const std::string mu = exact(one.mu);
    const auto add_thrust = [&](const std::vector<LoadedPiles>& loaded, double LoadLine::*x, const char* name,
                                int dash) {
      CsvTable table({"x_squared: dimensionless", "thrust_ratio_change: dimensionless", "standard_error: dimensionless",
                      fmt::format("{}: dimensionless", name), "thrust_ratio: dimensionless",
                      "thrust_error: dimensionless"});
      for (const LoadedPiles& piles : loaded) {
        const Estimate less =
            estimate(transform([](double a, double b) { return a - b; }, piles.thrust, loaded.front().thrust));
        const Estimate A = estimate(piles.thrust);
        const double value = piles.line.*x;
        table.add_row({value * value, less.value, less.standard_error, value, A.value, A.standard_error});
        square.add(value * value);
        change.add(less.value);
      }
      thrust.add(plot.add_data(fmt::format("{}-mu-{}", name, mu), table), "1:2:3", ink.joined_bars(0.9, 0.55, dash));
    };
    add_thrust(one.leaning, &LoadLine::slope, "slope", 0);
    add_thrust(one.turned, &LoadLine::offset, "offset", 2);
    plot.add_key(title_of(one.mu), ink.points(0.6));
    for (std::size_t layer = 0; layer < one.layers.size(); ++layer) {
      const LayerFluctuations& at = one.layers[layer];
      CsvTable spectrum({"k: 1/bead diameter", "C_torque: loads of one top bead squared",
                         "standard_error: loads of one top bead squared", "C_H: loads of one top bead squared",
                         "standard_error: loads of one top bead squared"});
      // Modes a fifth apart are averaged no further: neighbours show the noise.
      double next = 0;
      for (std::size_t m = 0; m < at.k.size(); ++m) {
        if (at.k[m] < next || at.k[m] > 1.5) continue;
        next = 1.12 * at.k[m];
        const Estimate torque = estimate(at.of_torque[m]), H = estimate(at.of_H[m]);
        if (!(torque.value > 0)) continue;
        spectrum.add_row({at.k[m], torque.value, torque.standard_error, H.value, H.standard_error});
        k.add(at.k[m]);
        power.add(torque.value);
      }
      if (spectrum.empty()) continue;
      spectra.add(plot.add_data(fmt::format("layer-{}-mu-{}", at.layer, mu), spectrum), "1:2",
                  ink.line(0.9, static_cast<int>(one.layers.size() - layer)));
    }
  }
  plot.add_key("slope", {.width = 0.9});
  plot.add_key("offset", {.width = 0.9, .dash = 2});
  std::vector<std::string> depths;
  const auto& layers = measured.front().layers;
  for (std::size_t layer = layers.size(); layer-- > 0;) {
    plot.add_key(fmt::format("layer {}", layers[layer].layer),
                 {.width = 0.9, .dash = static_cast<int>(layers.size() - layer)});
    depths.push_back(std::to_string(layers[layer].layer));
  }
  thrust.x = linear_axis("square of the load’s slope or offset", {0, 1.05 * square.high, false}, 4, square);
  thrust.y = linear_axis("κ − κ(0)", widened(change, 0.06), 6, change);
  spectra.x = log_axis("wave number k  (1/bead diameter)", widened_by_factor(k, 1.2));
  spectra.y = log_axis("C(k)", widened_by_factor(power, 1.4));
  plot.panels = {thrust, spectra};
  return plot_figure(plot,
                     {"studies/coupling_of_fields.captions",
                      {{"piles", std::to_string(measured.front().leaning.front().spec.response.samples)},
                       {"layers", enumeration({depths.rbegin(), depths.rend()})},
                       {"columns", std::to_string(measured.front().response.spec.lattice.columns)}}},
                     run_folder);
}

Figure plot_spectra(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "spectra-of-fields";
  plot.height = 3.6;
  plot.key = {.inches = 0.72, .lines = 3, .centred = true, .entries = {}};
  Panel spectra = left_panel(), dispersion = right_panel();
  std::vector<std::string> layers, chi2;
  Range k, power, waves, diffusion;
  for (const CoupledSpreading& one : measured) {
    const DiffusionOfWaves law(one.response.bands);
    if (one.predicted.D_of_bands.empty() || !law.known()) continue;
    const Ink ink = ink_of_series(plot.key.entries.size());
    const std::string mu = exact(one.mu);
    const double c_squared = one.plateau.c_thrust_squared.value;
    const double plateau = (one.plateau.of_w.value + one.plateau.of_H.value / c_squared) / 2;
    layers.clear();
    for (const SaturatingSpectrum& spectrum : one.spectra) {
      CsvTable table({"k: 1/bead diameter", "C_w: loads of one top bead squared",
                      "standard_error: loads of one top bead squared",
                      "C_H_over_c_thrust_squared: loads of one top bead squared",
                      "standard_error: loads of one top bead squared", "modes: dimensionless"});
      for (const BandOfFluctuations& band : spectrum.bands) {
        const Estimate w = estimate(band.of_w), H = estimate(band.of_H);
        table.add_row({band.k, w.value, w.standard_error, H.value / c_squared, H.standard_error / c_squared,
                       static_cast<double>(band.modes)});
        k.add(band.k);
        power.add(w.value);
        power.add(H.value / c_squared);
      }
      CsvTable line({"k: 1/bead diameter", "C: loads of one top bead squared"});
      constexpr int steps = 60;
      const double first = spectrum.bands.front().k, last = spectrum.bands.back().k;
      for (int step = 0; step <= steps; ++step) {
        const double at = first * std::pow(last / first, static_cast<double>(step) / steps);
        line.add_row({at, plateau * law.saturation(at, spectrum.z)});
      }
      const std::string file = plot.add_data(fmt::format("layer-{}-mu-{}", spectrum.layer, mu), table),
                        law_file = plot.add_data(fmt::format("law-{}-mu-{}", spectrum.layer, mu), line);
      spectra.add(law_file, "1:2", ink.line(0.9));
      spectra.add(file, "1:2:3", ink.bars(0.7, 0.45));
      spectra.add(file, "1:4:5", Ink{ink.colour, loads_points}.bars(0.7, 0.8));
      layers.push_back(std::to_string(spectrum.layer));
    }
    CsvTable table({"k: 1/bead diameter", "D: bead diameters", "standard_error: bead diameters",
                    "predicted: bead diameters", "predicted_error: bead diameters", "from: bead diameters",
                    "to: bead diameters"});
    for (std::size_t i = 0; i < one.response.bands.size(); ++i) {
      const BandOfModes& band = one.response.bands[i];
      const Estimate& predicted = one.predicted.D_of_bands[i];
      if (!DiffusionOfWaves({band}).known() || !predicted.known()) continue;
      table.add_row({band.k, band.D.value, band.D.standard_error, predicted.value, predicted.standard_error,
                     band.z_from, band.z_to});
      waves.add(band.k);
      diffusion.add(band.D.value);
      diffusion.add(predicted.value);
    }
    const std::string file = plot.add_data("dispersion-mu-" + mu, table);
    dispersion.add(file, "1:4", ink.line(0.9, 2));
    dispersion.add(file, "1:2:3", ink.bars(0.8, 0.5));
    plot.add_key(title_of(one.mu), ink.points(0.6));
    chi2.push_back(fmt::format("{:.0f} at μ = {} ({} bands; with twice D: {:.0f})", one.saturation.chi2,
                               caption_number(one.mu), one.saturation.points, one.saturation.doubled_chi2));
  }
  if (plot.key.entries.empty()) {
    throw InputError(
        "the figure of the spectra has nothing to show: no diffusion coefficient is known of waves of one length; give "
        "the study more piles");
  }
  plot.add_key("from horizontal force", Ink{"black", loads_points}.points(0.8));
  plot.add_key("law", {.width = 0.9});
  plot.add_key("predicted", {.width = 0.9, .dash = 2});
  spectra.x = log_axis("wave number k  (1/bead diameter)", widened_by_factor(k, 1.2));
  spectra.y = log_axis("C_w(k), C_H(k)/c²", widened_by_factor(power, 1.5));
  dispersion.x = log_axis(spectra.x.label, widened_by_factor(waves, 1.2));
  dispersion.y = log_axis("D(k)  (bead diameters)", widened_by_factor(diffusion, 1.4));
  plot.panels = {spectra, dispersion};
  return plot_figure(
      plot, {"studies/spectra_of_fields.captions", {{"layers", enumeration(layers)}, {"chi2", enumeration(chi2)}}},
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
  CsvTable shapes({"x: widths", "gaussian: dimensionless", "kpz: dimensionless"});
  const auto entries = static_cast<std::ptrdiff_t>(kpz_peak().density.size());
  for (std::ptrdiff_t i = 1 - entries; i < entries; ++i) {
    const double x = KpzPeak::step * static_cast<double>(i) / root;
    if (std::abs(x) > 4) continue;
    shapes.add_row({x, std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi),
                    root * kpz_peak().density[static_cast<std::size_t>(std::abs(i))]});
  }
  const std::string theory = plot.add_data("theory", shapes);
  const Style gaussian{.width = 0.9, .dash = 2}, kpz{.width = 0.9, .dash = 3},
      coupled{.colour = "vermilion", .width = 1.3};
  Panel heights = left_panel(), excess = right_panel();
  heights.add(theory, "1:2", gaussian);
  heights.add(theory, "1:3", kpz);
  excess.add(theory, "1:(0)", gaussian);
  excess.add(theory, "1:($3-$2)", kpz);
  std::vector<std::string> words;
  Range difference;
  for (std::size_t i = 0; i < shown->peaks.size(); ++i) {
    const ScaledPeak& peak = shown->peaks[i];
    CsvTable table(
        {"x: widths", "height: dimensionless", "standard_error: dimensionless", "above_gaussian: dimensionless"});
    double next = -100;
    for (std::size_t j = 0; j < peak.x.size(); ++j) {
      const double x = peak.x[j];
      if (x < next) continue;
      next = x + 0.16;
      const double above = peak.height[j].value - std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
      table.add_row({x, peak.height[j].value, peak.height[j].standard_error, above});
      difference.add(above, peak.height[j].standard_error);
    }
    const std::string file = plot.add_data(std::to_string(i + 1), table);
    const Ink ink = ink_of_series(i);
    heights.add(file, "1:2", ink.points(0.4));
    excess.add(file, "1:4:3", ink.bars(0.7, 0.4));
    plot.add_key(fmt::format("z = {:.0f}", peak.z), ink.points(0.6));
    const PeakShapeTest& test = shown->shapes[i];
    words.push_back(
        fmt::format("{:.0f}, {:.0f} and {:.0f} at z = {:.0f}", test.gaussian, test.kpz, test.coupled, test.z));
  }
  for (std::ptrdiff_t i = 0; i < entries; ++i) {
    const double x = KpzPeak::step * static_cast<double>(i) / root;
    difference.add(root * kpz_peak().density[static_cast<std::size_t>(i)] -
                   std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi));
  }
  CsvTable predicted({"x: widths", "height: dimensionless", "above_gaussian: dimensionless"});
  for (std::size_t i = 0; i < shown->predicted_peak.x.size(); ++i) {
    const double x = shown->predicted_peak.x[i], height = shown->predicted_peak.height[i].value;
    const double above = height - std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
    predicted.add_row({x, height, above});
    difference.add(above);
  }
  const std::string file = plot.add_data("predicted", predicted);
  heights.add(file, "1:2", coupled);
  excess.add(file, "1:3", coupled);
  plot.add_key(fmt::format("predicted, z = {:.0f}", shown->predicted_peak.z), coupled);
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
