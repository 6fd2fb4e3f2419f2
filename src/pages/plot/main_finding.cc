#include "plot/main_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/claims.h"
#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot.h"
#include "plot/plot_texts.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr double height_inches = 72 / 25.4;

bool has_slopes(const Transport& result) { return !result.exact && result.c.known() && result.D.known(); }

/// c_0 - c of a reading against mu, or against D, as far as logarithmic axes show it.
std::vector<PowerLawPoint> points_of(const OtherReading& reading, bool against_D) {
  std::vector<PowerLawPoint> points;
  for (const OtherReading::Point& one : reading.points) {
    const PowerLawPoint point{one.mu, against_D ? one.D.value : one.mu, against_D ? one.D.standard_error : 0,
                              reading.c0 - one.c.value, one.c.standard_error};
    if (one.c.known() && one.D.known() && fits_log_axes(point)) points.push_back(point);
  }
  return points;
}

/// Friction coefficients of which the slopes have no point, with the reason.
std::vector<LeftOut> left_out_of(const Analysis& analysis) {
  std::vector<LeftOut> left_out;
  for (const Transport& result : analysis.results) {
    if (result.exact) continue;
    const char* const why = !has_slopes(result)             ? "c or D unknown"
                            : result.c.value >= result.c0() ? "c₀ − c of slopes not above 0"
                            : result.D.value <= 0           ? "D not above 0"
                                                            : nullptr;
    if (why != nullptr) left_out.push_back({fmt::format("μ = {}", caption_number(result.scanned())), why});
  }
  return left_out;
}

/// A panel as it is being filled.
class FindingPanel {
 public:
  /// `room_above`: share of the height that stays free for a name as long as the panel.
  FindingPanel(Plot& plot, const std::string& x_label, const std::string& x_unit,
               const std::vector<std::vector<PowerLawPoint>>& series, double room_above)
      : plot_(plot), x_unit_(x_unit) {
    for (const auto& points : series) {
      for (const PowerLawPoint& point : points) {
        x_.add(std::max(point.x - point.x_error, point.x / 2));
        x_.add(point.x + point.x_error);
        y_.add(std::max(point.y - point.y_error, point.y / 2));
        y_.add(point.y + point.y_error);
      }
    }
    x_ = widened_by_factor(x_, 1.35);
    y_ = widened_by_factor(y_, 1.35);
    y_.low /= 1.5;  // room for the names of the curves
    y_.high *= std::pow(y_.high / y_.low, room_above / (1 - room_above));
    panel_.x = log_axis(x_label, x_);
    panel_.y = log_axis("c₀ − c", y_);
    panel_.top = 0.24;
    panel_.bottom = 0.46;
    panel_.name_above = true;
  }

  /// Filled where mu lies in the window of the fit, else open.
  void add_points(const std::string& name, const std::vector<PowerLawPoint>& points,
                  const std::array<double, 2>& window, const Ink& ink, double size) {
    for (const bool inside : {true, false}) {
      CsvTable table(power_law_columns(x_unit_, "dimensionless"));
      for (const PowerLawPoint& point : points) {
        if (in_window(point.mu, window) != inside) continue;
        table.add_row({point.mu, point.x, point.y, std::max(point.x - point.x_error, x_.low), point.x + point.x_error,
                       std::max(point.y - point.y_error, y_.low), point.y + point.y_error});
      }
      if (table.empty()) continue;
      const Ink of_these{ink.colour, inside ? ink.marker : ink.marker - 1};
      panel_.add(plot_.add_data(inside ? name : name + "-outside", table), "2:3:4:5:6:7",
                 of_these.both_bars(0.8, size));
    }
  }

  /// A power law through the middle of the points, as far as it lies inside the axes.
  void add_guide(const WindowMiddle& middle, double exponent, const Style& style) {
    if (middle.extent.empty) return;
    const auto reaches = [&](double y) { return middle.x * std::pow(y / middle.y, 1 / exponent); };
    panel_.add_function(fmt::format("{} * ($1 / {})**{}", exact(middle.y), exact(middle.x), exact(exponent)),
                        std::max(x_.low, reaches(y_.low)), std::min(x_.high, reaches(y_.high)), style);
  }

  /// Whether there is a law.
  bool add_law(const ScalingFit& fit, const WindowMiddle& middle, const std::string& colour) {
    if (!fit.exponent.known() || !fit.intercept.known() || !(middle.extent.size() > 0)) return false;
    panel_.add_function(fmt::format("exp({}) * $1**{}", exact(fit.intercept.value), exact(fit.exponent.value)),
                        middle.extent.low, middle.extent.high, {.colour = colour, .width = 1.6});
    return true;
  }

  void add_text(const std::string& text, double x, double y, const std::string& colour) {
    panel_.texts.push_back({text, x, y, x < 0.5 ? "left" : "right", colour});
  }

  void place(double left, double right, double name) {
    panel_.left = left;
    panel_.right = right;
    panel_.name = name;
    plot_.panels.push_back(panel_);
  }

 private:
  Plot& plot_;
  std::string x_unit_;
  Panel panel_;
  Range x_, y_;
};

}  // namespace

bool has_exponents(const Analysis& analysis) {
  const auto any = [](const ScalingFits& fits) {
    return fits.beta.exponent.known() || fits.gamma.exponent.known() || fits.alpha.exponent.known();
  };
  return any(analysis.scaling) ||
         std::ranges::any_of(analysis.readings, [&](const OtherReading& one) { return any(one.fits); });
}

bool has_main_finding(const Analysis& analysis) {
  return has_exponents(analysis) && points_of(slopes_of(analysis), false).size() > 1;
}

Figure plot_main_finding(const Analysis& analysis, const std::filesystem::path& run_folder) {
  if (!has_main_finding(analysis)) {
    throw InputError(
        "the figure of c0 - c has nothing to show, because fewer than two friction coefficients have a c below c0; use "
        "more samples or deeper layers");
  }
  // Reading at one depth lies above the slopes, small friction below them.
  std::vector<std::pair<OtherReading, Ink>> readings{{slopes_of(analysis), {"blue", 7}}};
  for (const OtherReading& one : analysis.readings) {
    if (points_of(one, true).size() < 2 || !one.fits.gamma.exponent.known() || !one.fits.alpha.exponent.known())
      continue;
    if (one.id == "at_one_depth") {
      readings.insert(readings.begin(), {one, {"vermilion", 13}});
    } else {
      readings.push_back({one, {"bluish_green", 9}});
    }
  }
  const bool as_paper = readings.front().first.id == "at_one_depth";
  Plot plot;
  plot.id = main_finding_id;
  plot.height = height_inches;
  const Style dotted{.width = 1.4, .dash = 3}, dashed{.width = 1, .dash = 2};
  const auto add_panel = [&](bool against_D, double edge) {
    std::vector<std::vector<PowerLawPoint>> series;
    series.reserve(readings.size());
    for (const auto& [reading, ink] : readings) series.push_back(points_of(reading, against_D));
    FindingPanel panel(plot, against_D ? "diffusion coefficient D (bead diameters)" : "friction coefficient μ",
                       against_D ? "bead diameters" : "dimensionless", series, as_paper ? 0.1 : 0);
    const auto fit_of = [&](const OtherReading& one) -> const ScalingFit& {
      return against_D ? one.fits.alpha : one.fits.gamma;
    };
    const auto middle_of = [&](std::size_t i) { return middle_of_window(series[i], fit_of(readings[i].first).window); };
    const char* const symbol = against_D ? "α" : "γ";
    panel.add_guide(middle_of(0), against_D ? paper_alpha.value : paper_gamma.value, dotted);
    if (against_D) panel.add_guide(middle_of(readings.size() - 1), linear_in_D.value, dashed);
    // The names of the curves stand in the corners that rising curves leave free.
    double above = 0.94, below = 0.07;
    for (std::size_t i = readings.size(); i-- > 0;) {
      const auto& [reading, ink] = readings[i];
      panel.add_law(fit_of(reading), middle_of(i), ink.colour);
      panel.add_points((against_D ? "alpha-" : "gamma-") + reading.id, series[i], fit_of(reading).window, ink,
                       ink.marker == 7 ? 0.5 : 0.65);
      const std::string name = fmt::format("{}: {} = {}", reading.label, symbol, exponent_text(fit_of(reading)));
      if (as_paper && i == 0) {
        panel.add_text(name, 0.03, above, ink.colour);
        above -= 0.09;
      } else {
        panel.add_text(name, 0.98, below, ink.colour);
        below += 0.09;
      }
    }
    if (!middle_of(0).extent.empty) {
      panel.add_text(against_D ? "dotted, the paper: α = 0.4" : "dotted, the paper: γ = 1", 0.03, above, "black");
    }
    if (against_D && !middle_of(readings.size() - 1).extent.empty) {
      panel.add_text("dashed, stochastic theory: α = 1", 0.98, below, "black");
    }
    panel.place(0.075 + edge, 0.485 + edge, 0.012 + edge);
  };
  add_panel(false, 0);
  add_panel(true, 0.5);

  TemplateVariables variables{{"left_out", with_reasons(left_out_of(analysis))}};
  for (const char* symbol : {"gamma", "alpha"}) {
    for (const std::string id : {"at_one_depth", "limit"}) variables[id + "_" + symbol] = "";
  }
  for (const char* name : {"at_one_depth_label", "limit_low", "limit_high"}) {
    variables[name] = "";
  }
  for (const auto& [reading, ink] : readings) {
    const bool slopes = reading.id == "slopes", one_depth = reading.id == "at_one_depth";
    const std::string name = slopes || one_depth ? reading.id + "_" : "limit_";  // of small friction
    if (one_depth) variables[name + "label"] = reading.label;
    for (const auto& [symbol, fit] :
         {std::pair("gamma", &reading.fits.gamma), std::pair("alpha", &reading.fits.alpha)}) {
      variables[name + symbol] = fit->exponent.known() ? exponent_text(*fit) : "";
      if (slopes) variables[name + symbol + "_reason"] = fit->exponent.reason;
    }
    if (one_depth) continue;
    variables[name + "low"] = caption_number(reading.fits.gamma.window[0]);
    variables[name + "high"] = caption_number(reading.fits.gamma.window[1]);
  }
  return plot_figure(plot, {"plot/main_finding.captions", variables, terms_of(*analysis.scan, analysis.angle())},
                     run_folder);
}

}  // namespace granuscope
