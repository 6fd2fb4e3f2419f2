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
#include "plot/plot_script.h"
#include "studies/mode_coupling/theory.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

std::string joined(const std::vector<std::string>& curves) {
  return fmt::format("{}", fmt::join(curves, ", \\\n    "));
}

std::string colour_of(const std::string& style) { return style.substr(style.find("linecolor")); }

std::string title_of(double mu, const std::string& style) {
  return fmt::format("keyentry with points pointsize 0.6 {} title {}", style,
                     gnuplot_string("μ = " + caption_number(mu)));
}

std::string line_title(const char* style, const char* title) {
  return fmt::format("keyentry with lines {} linecolor rgb '{}' title '{}'", style, plot_colours().at("black"), title);
}

/// Point types of checks: open squares and circles.
constexpr int wide_points = 4, loads_points = 6;

std::string in_words(const Estimate& number) {
  return number.known() ? value_with_error(number.value, number.standard_error) : "unknown";
}

}  // namespace

Figure plot_predicted_width(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "predicted-width";
  plan.script = "studies/predicted_width";
  plan.height = 3.6;
  std::vector<std::string> curves, titles, ratios, words;
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
    const std::string file = fmt::format("{}-mu-{}.csv", plan.id, exact(one.mu)), style = series_style(titles.size());
    plan.data[file] = table.text();
    curves.push_back(fmt::format("'{}' using 1:4 with lines linewidth 1.2 {} notitle", file, colour_of(style)));
    curves.push_back(
        fmt::format("'{}' using 1:6 with lines linewidth 0.8 dashtype 2 {} notitle", file, colour_of(style)));
    curves.push_back(
        fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.9 pointsize 0.6 {} notitle", file, style));
    titles.push_back(title_of(one.mu, style));
    for (const CheckedSpreading& check : one.checks) {
      const bool wide = check.response.by == DeepMeasurement::wide;
      CsvTable points({"z: bead diameters", "measured: bead diameters", "standard_error: bead diameters"});
      for (const LagResponse& lag : check.response.lags) {
        if (!lag.width_squared.known()) continue;
        points.add_row({lag.z, lag.width_squared.value / lag.z, lag.width_squared.standard_error / lag.z});
        spreading.add(lag.width_squared.value / lag.z);
      }
      const std::string name = fmt::format("{}-{}-mu-{}.csv", plan.id, wide ? "wide" : "loads", exact(one.mu));
      if (!wide && !check.predicted.width_squared.empty()) {
        CsvTable line({"z: bead diameters", "predicted: bead diameters"});
        for (std::size_t i = 0; i < check.response.lags.size(); ++i) {
          const double at = check.response.lags[i].z;
          line.add_row({at, check.predicted.width_squared[i] / at});
          spreading.add(check.predicted.width_squared[i] / at);
        }
        const std::string of_loads = fmt::format("{}-loads-predicted-mu-{}.csv", plan.id, exact(one.mu));
        plan.data[of_loads] = line.text();
        curves.push_back(
            fmt::format("'{}' using 1:2 with lines linewidth 1.2 dashtype 3 {} notitle", of_loads, colour_of(style)));
        loads_predicted = true;
      }
      plan.data[name] = points.text();
      curves.push_back(
          fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.7 pointsize 1.1 pointtype {} {} notitle", name,
                      wide ? wide_points : loads_points, colour_of(style)));
      checked[wide ? "twice the columns" : "by loads (multiplexed)"] = wide ? wide_points : loads_points;
      words.push_back(fmt::format("{:.1f} at μ = {} {}", check.predicted.chi2, caption_number(one.mu),
                                  wide ? "in piles twice as wide" : "by loads"));
    }
    if (one.fit.strength.known())
      ratios.push_back(fmt::format("{} at μ = {}", in_words(one.fit.strength), caption_number(one.mu)));
  }
  if (titles.empty()) {
    throw InputError(
        "the figure of the predicted widths has nothing to show: the response is not known at every lag of any "
        "friction coefficient; give the study more piles");
  }
  plan.curves = static_cast<int>(curves.size());
  for (const auto& [title, points] : checked) {
    titles.push_back(fmt::format("keyentry with points pointsize 1.1 pointtype {} linecolor rgb '{}' title '{}'",
                                 points, plot_colours().at("black"), title));
  }
  titles.push_back(line_title("linewidth 1.2", "predicted"));
  titles.push_back(line_title("linewidth 0.8 dashtype 2", "without torque"));
  if (loads_predicted) titles.push_back(line_title("linewidth 1.2 dashtype 3", "predicted, by loads"));
  const Range axis = widened_by_factor(z, 1.4), widths = widened_by_factor(spreading, 1.3);
  return plot_figure(plan,
                     {{"curves", joined(curves)},
                      {"titles", joined(titles)},
                      {"left", exact(axis.low)},
                      {"right", exact(axis.high)},
                      {"z_ticks", log_ticks(axis)},
                      {"low", exact(widths.low)},
                      {"high", exact(widths.high)},
                      {"ticks", log_ticks(widths)}},
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
  PlotPlan plan;
  plan.id = "coupling-of-fields";
  plan.script = "studies/coupling_of_fields";
  plan.height = 3;
  std::vector<std::string> thrust, spectra, titles;
  Range square, change, k, power;
  change.add(0);
  square.add(0);
  for (const CoupledSpreading& one : measured) {
    const std::string style = series_style(titles.size()), mu = exact(one.mu);
    const auto add_thrust = [&](const std::vector<LoadedPiles>& loaded, double LoadLine::*x, const char* name,
                                const char* dashes) {
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
      const std::string file = fmt::format("{}-{}-mu-{}.csv", plan.id, name, mu);
      plan.data[file] = table.text();
      thrust.push_back(fmt::format("'{}' using 1:2:3 with yerrorlines linewidth 0.9{} pointsize 0.55 {} notitle", file,
                                   dashes, style));
    };
    add_thrust(one.leaning, &LoadLine::slope, "slope", "");
    add_thrust(one.turned, &LoadLine::offset, "offset", " dashtype 2");
    titles.push_back(title_of(one.mu, style));
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
      const std::string spectrum_file = fmt::format("{}-layer-{}-mu-{}.csv", plan.id, at.layer, mu);
      plan.data[spectrum_file] = spectrum.text();
      spectra.push_back(fmt::format("'{}' using 1:2 with lines linewidth 0.9 dashtype {} {} notitle", spectrum_file,
                                    one.layers.size() - layer, colour_of(style)));
    }
  }
  titles.push_back(line_title("linewidth 0.9", "slope"));
  titles.push_back(line_title("linewidth 0.9 dashtype 2", "offset"));
  plan.curves = static_cast<int>(thrust.size() + spectra.size());
  std::vector<std::string> depths;
  const auto& layers = measured.front().layers;
  for (std::size_t layer = layers.size(); layer-- > 0;) {
    titles.push_back(line_title(fmt::format("linewidth 0.9 dashtype {}", layers.size() - layer).c_str(),
                                fmt::format("layer {}", layers[layer].layer).c_str()));
    depths.push_back(std::to_string(layers[layer].layer));
  }
  const Range k_axis = widened_by_factor(k, 1.2), power_axis = widened_by_factor(power, 1.4);
  const double room = 0.06 * change.size();
  return plot_figure(plan,
                     {{"thrust", joined(thrust)},
                      {"spectra", joined(spectra)},
                      {"titles", joined(titles)},
                      {"square_high", exact(1.05 * square.high)},
                      {"square_ticks", linear_ticks(square, 4)},
                      {"low", exact(change.low - room)},
                      {"high", exact(change.high + room)},
                      {"ticks", linear_ticks(change, 6)},
                      {"k_low", exact(k_axis.low)},
                      {"k_high", exact(k_axis.high)},
                      {"k_ticks", log_ticks(k_axis)},
                      {"C_low", exact(power_axis.low)},
                      {"C_high", exact(power_axis.high)},
                      {"C_ticks", log_ticks(power_axis)}},
                     {"studies/coupling_of_fields.captions",
                      {{"piles", std::to_string(measured.front().leaning.front().spec.response.samples)},
                       {"layers", enumeration({depths.rbegin(), depths.rend()})},
                       {"columns", std::to_string(measured.front().response.spec.lattice.columns)}}},
                     run_folder);
}

Figure plot_spectra(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "spectra-of-fields";
  plan.script = "studies/spectra_of_fields";
  plan.height = 3.6;
  std::vector<std::string> spectra, dispersion, titles, layers, chi2;
  Range k, power, waves, diffusion;
  for (const CoupledSpreading& one : measured) {
    const DiffusionOfWaves law(one.response.bands);
    if (one.predicted.D_of_bands.empty() || !law.known()) continue;
    const std::string style = series_style(titles.size()), mu = exact(one.mu);
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
      const std::string file = fmt::format("{}-layer-{}-mu-{}.csv", plan.id, spectrum.layer, mu),
                        law_file = fmt::format("{}-law-{}-mu-{}.csv", plan.id, spectrum.layer, mu);
      plan.data[file] = table.text();
      plan.data[law_file] = line.text();
      spectra.push_back(fmt::format("'{}' using 1:2 with lines linewidth 0.9 {} notitle", law_file, colour_of(style)));
      spectra.push_back(
          fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.7 pointsize 0.45 {} notitle", file, style));
      spectra.push_back(
          fmt::format("'{}' using 1:4:5 with yerrorbars linewidth 0.7 pointsize 0.8 pointtype {} {} notitle", file,
                      loads_points, colour_of(style)));
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
    const std::string file = fmt::format("{}-dispersion-mu-{}.csv", plan.id, mu);
    plan.data[file] = table.text();
    dispersion.push_back(
        fmt::format("'{}' using 1:4 with lines linewidth 0.9 dashtype 2 {} notitle", file, colour_of(style)));
    dispersion.push_back(
        fmt::format("'{}' using 1:2:3 with yerrorbars linewidth 0.8 pointsize 0.5 {} notitle", file, style));
    titles.push_back(title_of(one.mu, style));
    chi2.push_back(fmt::format("{:.0f} at μ = {} ({} bands; with twice D: {:.0f})", one.saturation.chi2,
                               caption_number(one.mu), one.saturation.points, one.saturation.doubled_chi2));
  }
  if (titles.empty()) {
    throw InputError(
        "the figure of the spectra has nothing to show: no diffusion coefficient is known of waves of one length; give "
        "the study more piles");
  }
  plan.curves = static_cast<int>(spectra.size() + dispersion.size());
  titles.push_back(
      fmt::format("keyentry with points pointsize 0.8 pointtype {} linecolor rgb '{}' title 'from horizontal force'",
                  loads_points, plot_colours().at("black")));
  titles.push_back(line_title("linewidth 0.9", "law"));
  titles.push_back(line_title("linewidth 0.9 dashtype 2", "predicted"));
  const Range k_axis = widened_by_factor(k, 1.2), power_axis = widened_by_factor(power, 1.5),
              wave_axis = widened_by_factor(waves, 1.2), D_axis = widened_by_factor(diffusion, 1.4);
  return plot_figure(
      plan,
      {{"spectra", joined(spectra)},
       {"dispersion", joined(dispersion)},
       {"titles", joined(titles)},
       {"k_low", exact(k_axis.low)},
       {"k_high", exact(k_axis.high)},
       {"k_ticks", log_ticks(k_axis)},
       {"C_low", exact(power_axis.low)},
       {"C_high", exact(power_axis.high)},
       {"C_ticks", log_ticks(power_axis)},
       {"wave_low", exact(wave_axis.low)},
       {"wave_high", exact(wave_axis.high)},
       {"wave_ticks", log_ticks(wave_axis)},
       {"D_low", exact(D_axis.low)},
       {"D_high", exact(D_axis.high)},
       {"D_ticks", log_ticks(D_axis)}},
      {"studies/spectra_of_fields.captions", {{"layers", enumeration(layers)}, {"chi2", enumeration(chi2)}}},
      run_folder);
}

Figure plot_peak_shape(const std::vector<CoupledSpreading>& measured, const std::filesystem::path& run_folder) {
  PlotPlan plan;
  plan.id = "peak-shape";
  plan.script = "studies/peak_shape";
  plan.height = 3;
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
  plan.data["peak-shape-theory.csv"] = shapes.text();
  std::vector<std::string> heights, excess, titles, words;
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
      difference.add(above - peak.height[j].standard_error);
      difference.add(above + peak.height[j].standard_error);
    }
    const std::string file = fmt::format("peak-shape-{}.csv", i + 1), style = series_style(i);
    plan.data[file] = table.text();
    heights.push_back(fmt::format("'{}' using 1:2 with points pointsize 0.4 {} notitle", file, style));
    excess.push_back(
        fmt::format("'{}' using 1:4:3 with yerrorbars linewidth 0.7 pointsize 0.4 {} notitle", file, style));
    titles.push_back(fmt::format("keyentry with points pointsize 0.6 {} title 'z = {:.0f}'", style, peak.z));
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
  plan.data["peak-shape-predicted.csv"] = predicted.text();
  titles.push_back(fmt::format("keyentry with lines linewidth 1.3 linecolor rgb '{}' title 'predicted, z = {:.0f}'",
                               plot_colours().at("vermilion"), shown->predicted_peak.z));
  titles.push_back(line_title("linewidth 0.9 dashtype 2", "Gaussian"));
  titles.push_back(line_title("linewidth 0.9 dashtype 3", "f_{KPZ}"));
  plan.curves = static_cast<int>(heights.size() + excess.size()) + 6;
  const double room = 0.06 * difference.size();
  return plot_figure(plan,
                     {{"heights", joined(heights)},
                      {"excess", joined(excess)},
                      {"titles", joined(titles)},
                      {"low", exact(difference.low - room)},
                      {"high", exact(difference.high + room)},
                      {"ticks", linear_ticks(difference, 6)}},
                     {"studies/peak_shape.captions",
                      {{"mu", caption_number(shown->mu)},
                       {"chi2", enumeration(words)},
                       {"degrees", std::to_string(shown->shapes.back().degrees_of_freedom)}}},
                     run_folder);
}

}  // namespace granuscope
