#include "plot/power_law_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "plot/gnuplot.h"
#include "plot/plot_script.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Points farther from their law than this are arrows at the edge of the narrow panel: they would flatten all others.
constexpr double lowest_ratio = 0.4, highest_ratio = 1.8;

/// A line of the notes, as a share of the panel.
constexpr double note_height = 0.09;
/// Room for the name of a point, likewise.
constexpr double name_height = 0.08;

struct Law {
  bool known = false;
  double exponent = 0, intercept = 0;
  double at(double x) const { return std::exp(intercept) * std::pow(x, exponent); }
};

Law law_of(const PowerLawSeries& series) {
  if (!series.fit.exponent.known() || !series.fit.intercept.known()) return {};
  return {true, series.fit.exponent.value, series.fit.intercept.value};
}

/// A point over its law, with the error of ln y - k ln x.
struct Ratio {
  double value = 0, error = 0;
  bool shown = false;
};

Ratio over_law(const PowerLawPoint& point, const Law& law) {
  if (!law.known) return {};
  const double value = point.y / law.at(point.x);
  const double error = value * std::hypot(point.y_error / point.y, law.exponent * point.x_error / point.x);
  return {value, error, value > lowest_ratio && value < highest_ratio};
}

struct Axes {
  Range x, y, ratio;
};

Axes axes_of(const PowerLawPanel& panel) {
  Axes axes;
  axes.ratio.add(0.95);
  axes.ratio.add(1.05);
  for (const PowerLawSeries& series : panel.series) {
    const Law law = law_of(series);
    for (const PowerLawPoint& point : series.points) {
      if (!fits_log_axes(point)) continue;
      axes.x.add(point.x);
      axes.x.add(point.x + point.x_error);
      axes.y.add(point.y);
      axes.y.add(point.y + point.y_error);
      const Ratio ratio = over_law(point, law);
      if (!ratio.shown) continue;
      axes.ratio.add(std::max(ratio.value - ratio.error, lowest_ratio));
      axes.ratio.add(std::min(ratio.value + ratio.error, highest_ratio));
    }
  }
  if (axes.x.empty) return axes;
  // A single point stands in a panel of at least a factor of 4.
  axes.x = widened_by_factor(axes.x, axes.x.high / axes.x.low < 1.5 ? 2 : 1.35);
  axes.y = widened_by_factor(axes.y, axes.y.high / axes.y.low < 1.5 ? 2 : 1.5);
  // The notes stand above all points.
  const double room = note_height * static_cast<double>(panel.notes.size());
  axes.y.high *= std::pow(axes.y.high / axes.y.low, room / (1 - room));
  if (panel.labels) axes.y.low /= std::pow(axes.y.high / axes.y.low, name_height);  // below the lowest its name
  const double margin = 0.08 * axes.ratio.size();
  axes.ratio.low -= margin;
  axes.ratio.high += margin;
  return axes;
}

/// Data files of one series, and what plots them.
struct SeriesShown {
  bool inside = false, outside = false;
  bool ratio_inside = false, ratio_outside = false;
};

/// An arrow at the edge of the narrow panel, where a point lies beyond it.
std::string arrow_beyond(double x, bool up, const std::string& colour) {
  return fmt::format(
      "set arrow from first {0}, graph {1} to first {0}, graph {2} size graph 0.02, 25 filled linecolor rgb "
      "'{3}'\n  ",
      exact(x), up ? 0.7 : 0.3, up ? 0.98 : 0.02, colour);
}

SeriesShown add_data(PlotPlan& plan, const PowerLawPanel& panel, const PowerLawSeries& series, const Axes& axes,
                     const std::string& colour, PowerLawPanelScript& script, std::string& arrows) {
  const Law law = law_of(series);
  SeriesShown shown;
  for (const bool inside : {true, false}) {
    CsvTable points(power_law_columns(panel.x_unit, panel.y_unit));
    CsvTable ratios({"mu: dimensionless", "x: " + panel.x_unit, "y_over_law: dimensionless", "low: dimensionless",
                     "high: dimensionless"});
    for (const PowerLawPoint& point : series.points) {
      if (!fits_log_axes(point) || in_window(point.mu, series.fit.window) != inside) continue;
      // A bar that reaches zero or below ends at the axis.
      points.add_row({point.mu, point.x, point.y, std::max(point.x - point.x_error, axes.x.low),
                      point.x + point.x_error, std::max(point.y - point.y_error, axes.y.low), point.y + point.y_error});
      const Ratio ratio = over_law(point, law);
      if (ratio.shown) {
        ratios.add_row({point.mu, point.x, ratio.value, std::max(ratio.value - ratio.error, axes.ratio.low),
                        std::min(ratio.value + ratio.error, axes.ratio.high)});
      } else if (law.known) {
        script.off_scale.emplace_back(series.name, point.mu);
        arrows += arrow_beyond(point.x, ratio.value > 1, colour);
      }
    }
    const std::string stem = fmt::format("{}-{}-{}-{}", plan.id, panel.id, series.name, inside ? "inside" : "outside");
    if (!points.empty()) plan.data[stem + ".csv"] = points.text();
    if (!ratios.empty()) plan.data[stem + "-over-law.csv"] = ratios.text();
    (inside ? shown.inside : shown.outside) = !points.empty();
    (inside ? shown.ratio_inside : shown.ratio_outside) = !ratios.empty();
  }
  for (const bool one : {shown.inside, shown.outside, shown.ratio_inside, shown.ratio_outside}) plan.curves += one;
  return shown;
}

std::string yes(bool shown) { return shown ? "yes" : ""; }

/// Where a law was fitted: its window, or the reach of the window's points.
Range fitted_range(const PowerLawPanel& panel, const PowerLawSeries& series, const WindowMiddle& middle,
                   const Axes& axes) {
  return panel.against_mu ? window_on_axis(series.fit.window, axes.x) : middle.extent;
}

void add_series(TemplateVariables& variables, PlotPlan& plan, const PowerLawPanel& panel, std::size_t index,
                const Axes& axes, PowerLawPanelScript& script) {
  const std::string prefix = index == 0 ? "first" : "second";
  const PowerLawSeries series = index < panel.series.size() ? panel.series[index] : PowerLawSeries{};
  const std::string colour = plot_colours().at(index == 0 ? "blue" : "vermilion");
  const SeriesShown shown = add_data(plan, panel, series, axes, colour, script, variables["arrows"]);
  const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
  const Law law = law_of(series);
  const bool with_law = law.known && !middle.extent.empty;
  const Range fitted = fitted_range(panel, series, middle, axes);
  variables[prefix + "_name"] = series.name;
  variables[prefix + "_inside"] = yes(shown.inside);
  variables[prefix + "_outside"] = yes(shown.outside);
  variables[prefix + "_ratio_inside"] = yes(shown.ratio_inside);
  variables[prefix + "_ratio_outside"] = yes(shown.ratio_outside);
  variables[prefix + "_law"] = yes(with_law);
  variables[prefix + "_exponent"] = exact(law.exponent);
  variables[prefix + "_intercept"] = exact(law.intercept);
  variables[prefix + "_low"] = exact(fitted.low);
  variables[prefix + "_high"] = exact(fitted.high);
  if (with_law) plan.curves += index == 0 ? 2 : 1;  // the first also beyond its window
  if (index == 0) {
    const bool guide = !middle.extent.empty && !panel.paper_exponent.empty();
    variables["guide"] = yes(guide);
    variables["guide_x"] = exact(middle.x);
    variables["guide_y"] = exact(middle.y);
    variables["guide_exponent"] = panel.paper_exponent;
    if (guide) ++plan.curves;
    script.law = with_law;
  } else {
    script.second = shown.inside || shown.outside;
  }
  script.outside = script.outside || shown.outside;
}

/// mu beside each point of the first series, off the law and the guide.
std::string labels_beside(const PowerLawPanel& panel, const Axes& axes) {
  if (!panel.labels || panel.series.empty()) return "";
  const PowerLawSeries& series = panel.series[0];
  const auto share = [](double value, const Range& axis) {
    return std::log(value / axis.low) / std::log(axis.high / axis.low);
  };
  const auto bar = [&share](double value, double error, const Range& axis) {
    Range reach;
    reach.add(std::max(share(std::max(value - error, axis.low), axis), 0.0));
    reach.add(share(value + error, axis));
    return reach;
  };
  LabelledPanel area{(panel.right - panel.left) * plot_width_inches, panel.height, {}, {}};
  const auto add_power = [&](double x, double y, double exponent) {
    area.lines.push_back({{0, share(y * std::pow(axes.x.low / x, exponent), axes.y)},
                          {1, share(y * std::pow(axes.x.high / x, exponent), axes.y)}});
  };
  const Law law = law_of(series);
  if (law.known) add_power(1, law.at(1), law.exponent);
  const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
  if (!middle.extent.empty && !panel.paper_exponent.empty()) {
    add_power(middle.x, middle.y, std::stod(panel.paper_exponent));
  }
  Range notes;
  notes.add(1 - note_height * static_cast<double>(panel.notes.size()));
  notes.add(1);
  area.notes_y.push_back(notes);
  std::vector<NamedPoint> points;
  for (const PowerLawPoint& point : series.points) {
    if (!fits_log_axes(point)) continue;
    points.push_back({{share(point.x, axes.x), share(point.y, axes.y)},
                      bar(point.x, point.x_error, axes.x),
                      bar(point.y, point.y_error, axes.y),
                      caption_number(point.mu)});
  }
  return label_commands(points, area);
}

}  // namespace

std::string off_scale_in_words(const PowerLawPanelScript& panel, const std::string& what) {
  std::vector<std::string> series, places;
  for (const auto& [name, mu] : panel.off_scale) {
    if (std::find(series.begin(), series.end(), name) == series.end()) series.push_back(name);
  }
  for (const std::string& one : series) {
    std::vector<std::string> all;
    for (const auto& [name, mu] : panel.off_scale) {
      if (name == one) all.push_back(caption_number(mu));
    }
    const std::string of = what.empty() ? "" : fmt::format("{} ({}) at ", what, one);
    places.push_back(fmt::format("{}μ = {}", of, enumeration(all)));
  }
  return enumeration(places);
}

PowerLawPanelScript add_power_law_panel(PlotPlan& plan, const PowerLawPanel& wanted) {
  PowerLawPanelScript script;
  const Axes axes = axes_of(wanted);
  if (axes.x.empty) return script;
  const std::string y_ticks = log_ticks(axes.y), ratio_ticks = linear_ticks(axes.ratio, 4);
  PowerLawPanel panel = wanted;
  panel.left += room_for_labels({y_ticks, ratio_ticks});
  script.shown = true;
  TemplateVariables variables = {{"stem", plan.id + "-" + panel.id},
                                 {"left", exact(panel.left)},
                                 {"right", exact(panel.right)},
                                 {"label_at", exact(wanted.left - 0.092)},
                                 {"x_label", panel.x_label},
                                 {"y_label", panel.y_label},
                                 {"x_low", exact(axes.x.low)},
                                 {"x_high", exact(axes.x.high)},
                                 {"y_low", exact(axes.y.low)},
                                 {"y_high", exact(axes.y.high)},
                                 {"ratio_low", exact(axes.ratio.low)},
                                 {"ratio_high", exact(axes.ratio.high)},
                                 {"x_ticks", log_ticks(axes.x)},
                                 {"x_marks", without_labels(log_ticks(axes.x))},
                                 {"y_ticks", y_ticks},
                                 {"ratio_ticks", ratio_ticks},
                                 {"labels", labels_beside(panel, axes)}};
  for (const std::size_t index : {0, 1}) add_series(variables, plan, panel, index, axes, script);
  for (const std::size_t line : {0, 1, 2}) {
    const std::string name = fmt::format("note_{}", line + 1);
    const std::string note = line < panel.notes.size() ? panel.notes[line] : "";
    variables[name] = note.empty() ? "" : gnuplot_string(note);
  }
  const bool any_ratio = !variables["first_ratio_inside"].empty() || !variables["first_ratio_outside"].empty() ||
                         !variables["second_ratio_inside"].empty() || !variables["second_ratio_outside"].empty();
  variables["ratios"] = yes(any_ratio);
  variables["no_ratios"] = yes(!any_ratio);
  if (any_ratio) ++plan.curves;  // the line at 1
  script.text = plan.add_part({"plot/power_law_panel", variables});
  return script;
}

const Transport* nearest_result(const std::vector<Transport>& results, double mu,
                                const std::function<bool(const Transport&)>& usable) {
  const Transport* nearest = nullptr;
  for (const Transport& result : results) {
    if (!usable(result)) continue;
    if (nearest == nullptr || std::abs(result.scanned() - mu) < std::abs(nearest->scanned() - mu)) nearest = &result;
  }
  return nearest;
}

bool in_window(double mu, const std::array<double, 2>& window) {
  constexpr double rounding = 1e-9;
  return mu >= window[0] - rounding && mu <= window[1] + rounding;
}

Analysis without_imprecise_points(const Analysis& analysis) {
  // Half of D still is a point on logarithmic axes; c is known to parts in a thousand wherever it means something.
  constexpr double imprecise_D = 0.5, imprecise_c = 0.05;
  const auto drop_if_imprecise = [](Estimate& estimate, double share) {
    if (!estimate.known()) estimate.reason = "why stands under the table of c and D";
    if (!estimate.known() || estimate.standard_error <= share * std::abs(estimate.value)) return;
    estimate.reason =
        fmt::format("too uncertain for a point: {}", value_with_error(estimate.value, estimate.standard_error));
    estimate.value = estimate.standard_error = std::numeric_limits<double>::quiet_NaN();
  };
  Analysis clear = analysis;
  for (Transport& result : clear.results) {
    drop_if_imprecise(result.c, imprecise_c);
    drop_if_imprecise(result.D, imprecise_D);
  }
  return clear;
}

std::vector<std::string> power_law_columns(const std::string& x_unit, const std::string& y_unit) {
  return {"mu: dimensionless", "x: " + x_unit,     "y: " + y_unit,     "x_low: " + x_unit,
          "x_high: " + x_unit, "y_low: " + y_unit, "y_high: " + y_unit};
}

bool fits_log_axes(const PowerLawPoint& point) { return point.x > 0 && point.y > 0; }

WindowMiddle middle_of_window(const std::vector<PowerLawPoint>& points, const std::array<double, 2>& window) {
  WindowMiddle middle;
  double log_x = 0, log_y = 0, count = 0;
  for (const PowerLawPoint& point : points) {
    if (!fits_log_axes(point) || !in_window(point.mu, window)) continue;
    log_x += std::log(point.x);
    log_y += std::log(point.y);
    middle.extent.add(point.x);
    ++count;
  }
  if (count == 0) return middle;
  middle.x = std::exp(log_x / count);
  middle.y = std::exp(log_y / count);
  return middle;
}

Range window_on_axis(const std::array<double, 2>& window, const Range& axis) {
  Range part;
  part.add(std::clamp(window[0], axis.low, axis.high));
  part.add(std::clamp(window[1], axis.low, axis.high));
  return part;
}

std::string exponent_text(const ScalingFit& fit) {
  if (!fit.exponent.known()) return "unknown";
  if (!fit.misses_the_points()) return value_with_error(fit.exponent.value, fit.exponent.standard_error);
  return fmt::format("{} (χ² = {} on {})", significant(fit.exponent.value, 3), significant(fit.scatter.chi2, 2),
                     fit.scatter.degrees_of_freedom);
}

}  // namespace granuscope
