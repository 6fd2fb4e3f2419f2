#include "plot/main_finding.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/lattice.h"
#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot_script.h"
#include "plot/power_law_panel.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr double height_inches = 72 / 25.4;
constexpr double paper_gamma = 1, paper_alpha = 0.4, theory_alpha = 1;

/// The points of a curve, and which friction coefficients have none, with the reason.
struct Curve {
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
Curve slopes_against_friction(const Analysis& analysis) {
  Curve curve;
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
Curve ratios_against_friction(const Analysis& analysis, const RatioScaling& ratio, double below_surface) {
  Curve curve;
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
Curve slopes_against_diffusion(const Analysis& analysis) {
  Curve curve;
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

/// A power law through a point, as far as it lies inside the axes.
struct Guide {
  double x, y, exponent;
  /// Where it meets the upper or the right end of the axes.
  double right_end(const Range& x_axis, const Range& y_axis) const {
    return std::min(x_axis.high, x * std::pow(y_axis.high / y, 1 / exponent));
  }
};

/// One panel's variables, under a prefix.
class Panel {
 public:
  Panel(PlotPlan& plan, TemplateVariables& variables, std::string prefix)
      : plan_(plan), variables_(variables), prefix_(std::move(prefix)) {}

  /// `room_above`: share of the height that stays free for a name as long as the panel.
  void set_axes(const std::vector<std::vector<PowerLawPoint>>& series, double room_above) {
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
    set("x_low", exact(x_.low));
    set("x_high", exact(x_.high));
    set("y_low", exact(y_.low));
    set("y_high", exact(y_.high));
    set("x_ticks", log_ticks(x_));
    set("y_ticks", log_ticks(y_));
  }

  void add_points(const std::string& name, const std::vector<PowerLawPoint>& points) {
    set(name, points.empty() ? "" : "yes");
    if (points.empty()) return;
    CsvTable table(power_law_columns(prefix_ == "mu_" ? "dimensionless" : "bead diameters", "dimensionless"));
    for (const PowerLawPoint& point : points) {
      table.add_row({point.mu, point.x, point.y, std::max(point.x - point.x_error, x_.low), point.x + point.x_error,
                     std::max(point.y - point.y_error, y_.low), point.y + point.y_error});
    }
    plan_.data[fmt::format("{}-{}.csv", plan_.id, name)] = table.text();
    ++plan_.curves;
  }

  void add_guide(const std::string& name, const WindowMiddle& middle, double exponent) {
    set(name, middle.extent.empty ? "" : "yes");
    for (const char* part : {"_x", "_y", "_exponent", "_end"}) set(name + part, "");
    if (middle.extent.empty) return;
    const Guide guide{middle.x, middle.y, exponent};
    set(name + "_x", exact(guide.x));
    set(name + "_y", exact(guide.y));
    set(name + "_exponent", exact(exponent));
    set(name + "_end", exact(guide.right_end(x_, y_)));
    ++plan_.curves;
  }

  void add_law(const std::string& name, const ScalingFit& fit, const WindowMiddle& middle) {
    const bool known = fit.exponent.known() && fit.intercept.known() && middle.extent.size() > 0;
    set(name, known ? "yes" : "");
    for (const char* part : {"_intercept", "_exponent", "_low", "_high"}) set(name + part, "");
    if (!known) return;
    set(name + "_intercept", exact(fit.intercept.value));
    set(name + "_exponent", exact(fit.exponent.value));
    set(name + "_low", exact(middle.extent.low));
    set(name + "_high", exact(middle.extent.high));
    ++plan_.curves;
  }

  void set(const std::string& name, const std::string& text) { variables_[prefix_ + name] = text; }
  void set_label(const std::string& name, const std::string& text) { set(name, gnuplot_string(text)); }

 private:
  PlotPlan& plan_;
  TemplateVariables& variables_;
  std::string prefix_;
  Range x_, y_;
};

}  // namespace

bool has_main_finding(const Analysis& analysis) { return slopes_against_friction(analysis).points.size() > 1; }

Figure plot_main_finding(const Analysis& analysis, const std::filesystem::path& run_folder) {
  if (!has_main_finding(analysis)) {
    throw InputError(
        "the figure of c0 - c has nothing to show, because fewer than two friction coefficients have a c below c0; use "
        "more samples or deeper layers");
  }
  const RatioScaling* ratio = analysis.by_ratio.empty() ? nullptr : &analysis.by_ratio.front();
  const ScalingFits& scaling = analysis.scaling;
  const Curve of_mu = slopes_against_friction(analysis), against_D = slopes_against_diffusion(analysis);
  const Curve by_surface = ratio == nullptr ? Curve{} : ratios_against_friction(analysis, *ratio, 0);
  const Curve by_load =
      ratio == nullptr ? Curve{} : ratios_against_friction(analysis, *ratio, analysis.results.front().rows().depth(0));
  const auto &slopes = of_mu.points, &of_D = against_D.points, &ratios = by_surface.points, &from_load = by_load.points;
  std::vector<LeftOut> left_out;
  for (const Curve& curve : {of_mu, by_surface, by_load, against_D}) {
    left_out.insert(left_out.end(), curve.left_out.begin(), curve.left_out.end());
  }
  PlotPlan plan;
  plan.id = main_finding_id;
  plan.script = "plot/main_finding";
  plan.height = height_inches;
  TemplateVariables variables;
  const auto& window = scaling.gamma.window;

  Panel left(plan, variables, "mu_");
  left.set_axes({slopes, ratios, from_load}, ratios.empty() ? 0 : 0.1);
  left.add_points("slopes", slopes);
  left.add_points("ratios", ratios);
  left.add_points("from_load", from_load);
  left.add_guide("paper", middle_of_window(ratios.empty() ? slopes : ratios, window), paper_gamma);
  left.add_law("law", scaling.gamma, middle_of_window(slopes, window));
  left.set_label("slopes_label", "slopes: γ = " + exponent_text(scaling.gamma));
  const ScalingFit none;
  const ScalingFit &by_ratio = ratio == nullptr ? none : ratio->fits.gamma,
                   &shifted = ratio == nullptr ? none : ratio->from_load.gamma;
  left.set_label("ratios_label",
                 fmt::format("xₚ/z at z = {:.1f}: γ = {}", ratio == nullptr ? 0 : ratio->z, exponent_text(by_ratio)));
  left.set_label("from_load_label", "xₚ/(z − ½): γ = " + exponent_text(shifted));

  Panel right(plan, variables, "D_");
  right.set_axes({of_D}, 0);
  right.add_points("points", of_D);
  const WindowMiddle middle = middle_of_window(of_D, scaling.alpha.window);
  right.add_guide("paper", middle, paper_alpha);
  right.add_guide("theory", middle, theory_alpha);
  right.add_law("law", scaling.alpha, middle);
  right.set_label("law_label", "slopes: α = " + exponent_text(scaling.alpha));

  const auto known = [](const ScalingFit& fit) { return fit.exponent.known() ? exponent_text(fit) : ""; };
  return plot_figure(plan, variables,
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
