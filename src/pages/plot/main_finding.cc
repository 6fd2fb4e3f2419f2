#include "plot/main_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

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
constexpr double paper_gamma = 1, paper_alpha = 0.4, theory_alpha = 1;

/// The points of a reading, and which friction coefficients have none, with the reason.
struct PointsRead {
  std::vector<PowerLawPoint> points;
  std::vector<LeftOut> left_out;

  void add(const PowerLawPoint& point, const std::string& reading) {
    if (fits_log_axes(point)) {
      points.push_back(point);
    } else {
      leave_out(point.mu, reading, "not above 0");
    }
  }
  void leave_out(double mu, const std::string& reading, const std::string& why) {
    left_out.push_back({fmt::format("μ = {}", caption_number(mu)), reading + why});
  }
};

bool has_slopes(const Transport& result) { return !result.exact && result.c.known() && result.D.known(); }

/// c_0 - c as the slope of the peak position.
PointsRead slopes_against_friction(const Analysis& analysis) {
  PointsRead curve;
  for (const Transport& result : analysis.results) {
    if (has_slopes(result)) {
      curve.add({result.scanned(), result.scanned(), 0, tan30 - result.c.value, result.c.standard_error},
                "c₀ − c of slopes ");
    } else if (!result.exact) {
      curve.leave_out(result.scanned(), "", "c or D unknown");
    }
  }
  return curve;
}

/// c_0 - c as the ratio of peak position to depth in one layer; depth counts from `below_surface`.
PointsRead ratios_against_friction(const Analysis& analysis, const RatioScaling& ratio, double below_surface) {
  PointsRead curve;
  const std::string reading = below_surface > 0 ? "c₀ − xₚ/(z − ½) " : "c₀ − xₚ/z ";
  for (const Transport& result : analysis.results) {
    if (!has_slopes(result)) continue;
    const auto depth = std::find_if(result.depths.begin(), result.depths.end(),
                                    [&](const DepthFit& fit) { return fit.layer == ratio.layer; });
    if (depth == result.depths.end() || !depth->identifiable) {
      if (below_surface == 0) {
        curve.leave_out(result.scanned(), "", fmt::format("no peaks identified at z = {:.1f}, for ratios", ratio.z));
      }
      continue;
    }
    const double z = depth->z - below_surface;
    curve.add({result.scanned(), result.scanned(), 0, tan30 - depth->peak_position.value / z,
               depth->peak_position.standard_error / z},
              reading);
  }
  return curve;
}

/// The slopes again, against D.
PointsRead slopes_against_diffusion(const Analysis& analysis) {
  PointsRead curve;
  for (const Transport& result : analysis.results) {
    if (!has_slopes(result)) continue;
    const PowerLawPoint point{result.scanned(), result.D.value, result.D.standard_error, tan30 - result.c.value,
                              result.c.standard_error};
    if (!(point.x > 0)) {
      curve.leave_out(point.mu, "D ", "not above 0");
    } else if (fits_log_axes(point)) {
      curve.points.push_back(point);  // else named with the slopes against friction
    }
  }
  return curve;
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

  void add_points(const std::string& name, const std::vector<PowerLawPoint>& points, const Ink& ink, double size) {
    if (points.empty()) return;
    CsvTable table(power_law_columns(x_unit_, "dimensionless"));
    for (const PowerLawPoint& point : points) {
      table.add_row({point.mu, point.x, point.y, std::max(point.x - point.x_error, x_.low), point.x + point.x_error,
                     std::max(point.y - point.y_error, y_.low), point.y + point.y_error});
    }
    panel_.add(plot_.add_data(name, table), "2:3:4:5:6:7", ink.both_bars(0.8, size));
  }

  /// A power law through the middle of the points, as far as it lies inside the axes.
  void add_guide(const WindowMiddle& middle, double exponent, const Style& style) {
    if (middle.extent.empty) return;
    const auto reaches = [&](double y) { return middle.x * std::pow(y / middle.y, 1 / exponent); };
    panel_.add_function(fmt::format("{} * ($1 / {})**{}", exact(middle.y), exact(middle.x), exact(exponent)),
                        std::max(x_.low, reaches(y_.low)), std::min(x_.high, reaches(y_.high)), style);
  }

  /// Whether there is a law.
  bool add_law(const ScalingFit& fit, const WindowMiddle& middle) {
    if (!fit.exponent.known() || !fit.intercept.known() || !(middle.extent.size() > 0)) return false;
    panel_.add_function(fmt::format("exp({}) * $1**{}", exact(fit.intercept.value), exact(fit.exponent.value)),
                        middle.extent.low, middle.extent.high, {.colour = "blue", .width = 1.6});
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
         std::ranges::any_of(analysis.by_ratio, [&](const RatioScaling& one) { return any(one.fits); });
}

bool has_main_finding(const Analysis& analysis) {
  return has_exponents(analysis) && slopes_against_friction(analysis).points.size() > 1;
}

Figure plot_main_finding(const Analysis& analysis, const std::filesystem::path& run_folder) {
  if (!has_main_finding(analysis)) {
    throw InputError(
        "the figure of c0 - c has nothing to show, because fewer than two friction coefficients have a c below c0; use "
        "more samples or deeper layers");
  }
  const RatioScaling* ratio = analysis.by_ratio.empty() ? nullptr : &analysis.by_ratio.front();
  const ScalingFits& scaling = analysis.scaling;
  const PointsRead of_mu = slopes_against_friction(analysis), against_D = slopes_against_diffusion(analysis);
  const PointsRead by_surface = ratio == nullptr ? PointsRead{} : ratios_against_friction(analysis, *ratio, 0);
  const PointsRead by_load = ratio == nullptr
                                 ? PointsRead{}
                                 : ratios_against_friction(analysis, *ratio, analysis.results.front().rows().depth(0));
  const auto &slopes = of_mu.points, &of_D = against_D.points, &ratios = by_surface.points, &from_load = by_load.points;
  std::vector<LeftOut> left_out;
  for (const PointsRead& curve : {of_mu, by_surface, by_load, against_D}) {
    left_out.insert(left_out.end(), curve.left_out.begin(), curve.left_out.end());
  }
  Plot plot;
  plot.id = main_finding_id;
  plot.height = height_inches;
  const auto& window = scaling.gamma.window;
  const ScalingFit none;
  const ScalingFit &by_ratio = ratio == nullptr ? none : ratio->fits.gamma,
                   &shifted = ratio == nullptr ? none : ratio->from_load.gamma;
  const Style dotted{.width = 1.4, .dash = 3}, dashed{.width = 1, .dash = 2};

  // The names of the curves stand in the corners that rising curves leave free.
  FindingPanel left(plot, "friction coefficient μ", "dimensionless", {slopes, ratios, from_load},
                    ratios.empty() ? 0 : 0.1);
  const WindowMiddle of_paper = middle_of_window(ratios.empty() ? slopes : ratios, window);
  left.add_guide(of_paper, paper_gamma, dotted);
  left.add_law(scaling.gamma, middle_of_window(slopes, window));
  left.add_points("ratios", ratios, {"vermilion", 13}, 0.65);
  left.add_points("slopes", slopes, {"blue", 7}, 0.5);
  left.add_points("from_load", from_load, {"bluish_green", 6}, 0.8);
  if (!ratios.empty()) {
    left.add_text(fmt::format("xₚ/z at z = {:.1f}: γ = {}", ratio->z, exponent_text(by_ratio)), 0.03, 0.94,
                  "vermilion");
  }
  left.add_text("slopes: γ = " + exponent_text(scaling.gamma), 0.98, 0.16, "blue");
  if (!from_load.empty()) left.add_text("xₚ/(z − ½): γ = " + exponent_text(shifted), 0.98, 0.07, "bluish_green");
  if (!of_paper.extent.empty) {
    left.add_text("dotted, the paper: γ = 1", 0.03, ratios.empty() ? 0.94 : 0.85, "black");
  }
  left.place(0.075, 0.485, 0.012);

  FindingPanel right(plot, "diffusion coefficient D (bead diameters)", "bead diameters", {of_D}, 0);
  const WindowMiddle middle = middle_of_window(of_D, scaling.alpha.window);
  right.add_guide(middle, paper_alpha, dotted);
  right.add_guide(middle, theory_alpha, dashed);
  if (right.add_law(scaling.alpha, middle)) {
    right.add_text("slopes: α = " + exponent_text(scaling.alpha), 0.98, 0.07, "blue");
  }
  right.add_points("points", of_D, {"blue", 7}, 0.5);
  if (!middle.extent.empty) {
    right.add_text("dotted, the paper: α = 0.4", 0.98, 0.16, "black");
    right.add_text("dashed, stochastic theory: α = 1", 0.98, 0.25, "black");
  }
  right.place(0.575, 0.985, 0.512);

  const auto known = [](const ScalingFit& fit) { return fit.exponent.known() ? exponent_text(fit) : ""; };
  return plot_figure(plot,
                     {"plot/main_finding.captions",
                      {{"gamma", known(scaling.gamma)},
                       {"gamma_reason", scaling.gamma.exponent.known() ? "" : scaling.gamma.exponent.reason},
                       {"ratio_gamma", ratios.empty() ? "" : known(by_ratio)},
                       {"from_load_gamma", from_load.empty() ? "" : known(shifted)},
                       {"alpha", known(scaling.alpha)},
                       {"alpha_reason", scaling.alpha.exponent.known() ? "" : scaling.alpha.exponent.reason},
                       {"low", caption_number(window[0])},
                       {"high", caption_number(window[1])},
                       {"left_out", with_reasons(left_out)}},
                      terms_of(*analysis.scan)},
                     run_folder);
}

}  // namespace granuscope
