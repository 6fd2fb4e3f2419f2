#include "plot/power_law_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "plot/axes.h"
#include "plot/figure_captions.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Points farther from their law than this are arrows at the edge of the narrow panel: they would flatten all others.
constexpr double lowest_ratio = 0.4, highest_ratio = 1.8;

/// A line of the notes, as a share of the panel.
constexpr double note_height = 0.09;
/// Room for the name of a point, likewise.
constexpr double name_height = 0.08;

struct FittedPower {
  bool known = false;
  double exponent = 0, intercept = 0;
  double at(double x) const { return std::exp(intercept) * std::pow(x, exponent); }
};

FittedPower law_of(const PowerLawSeries& series) {
  if (!series.fit.exponent.known() || !series.fit.intercept.known()) return {};
  return {true, series.fit.exponent.value, series.fit.intercept.value};
}

/// A point over its law, with the error of ln y - k ln x.
struct Ratio {
  double value = 0, error = 0;
  bool shown = false;
};

Ratio over_law(const PowerLawPoint& point, const FittedPower& law) {
  if (!law.known) return {};
  const double value = point.y / law.at(point.x);
  const double error = value * std::hypot(point.y_error / point.y, law.exponent * point.x_error / point.x);
  return {value, error, value > lowest_ratio && value < highest_ratio};
}

struct PowerLawAxes {
  Range x, y, ratio;
};

PowerLawAxes axes_of(const PowerLawPanel& panel) {
  PowerLawAxes axes;
  axes.ratio.add(0.95);
  axes.ratio.add(1.05);
  for (const PowerLawSeries& series : panel.series) {
    const FittedPower law = law_of(series);
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

/// Points of one series inside or outside of its window, in the panel and below it over their law.
struct Points {
  CsvTable points, ratios;
};

Points points_of(const PowerLawPanel& panel, const PowerLawSeries& series, const PowerLawAxes& axes, bool inside,
                 const std::string& colour, PowerLawShown& shown, Panel& below) {
  const FittedPower law = law_of(series);
  Points of{CsvTable(power_law_columns(panel.x_unit, panel.y_unit)),
            CsvTable({"mu: dimensionless", "x: " + panel.x_unit, "y_over_law: dimensionless", "low: dimensionless",
                      "high: dimensionless"})};
  for (const PowerLawPoint& point : series.points) {
    if (!fits_log_axes(point) || in_window(point.mu, series.fit.window) != inside) continue;
    // A bar that reaches zero or below ends at the axis.
    of.points.add_row({point.mu, point.x, point.y, std::max(point.x - point.x_error, axes.x.low),
                       point.x + point.x_error, std::max(point.y - point.y_error, axes.y.low),
                       point.y + point.y_error});
    const Ratio ratio = over_law(point, law);
    if (ratio.shown) {
      of.ratios.add_row({point.mu, point.x, ratio.value, std::max(ratio.value - ratio.error, axes.ratio.low),
                         std::min(ratio.value + ratio.error, axes.ratio.high)});
    } else if (law.known) {
      // An arrow at the edge of the narrow panel, where a point lies beyond it.
      const bool up = ratio.value > 1;
      shown.off_scale.emplace_back(series.name, point.mu);
      below.arrows.push_back({point.x, up ? 0.7 : 0.3, point.x, up ? 0.98 : 0.02, "first", true, {.colour = colour}});
    }
  }
  return of;
}

/// Adds a series and its law; the last series added hides the others.
void add_series(Plot& plot, const PowerLawPanel& panel, std::size_t index, const PowerLawAxes& axes,
                PowerLawShown& shown, Panel& upper, Panel& lower) {
  const PowerLawSeries& series = panel.series[index];
  const bool first = index == 0;
  const std::string colour = first ? "blue" : "vermilion";
  const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
  const FittedPower law = law_of(series);
  const bool with_law = law.known && !middle.extent.empty;
  if (with_law) {
    // Where a law was fitted: its window, or the reach of the window's points.
    const Range fitted = panel.against_mu ? window_on_axis(series.fit.window, axes.x) : middle.extent;
    const std::string function = fmt::format("exp({}) * $1**{}", exact(law.intercept), exact(law.exponent));
    // The first also beyond its window.
    if (first) upper.add_function(function, axes.x.low, axes.x.high, {.colour = colour, .width = 0.8, .dash = 2});
    upper.add_function(function, fitted.low, fitted.high, {.colour = colour, .width = first ? 1.8 : 1.4});
  }
  for (const bool inside : {false, true}) {
    const Points of = points_of(panel, series, axes, inside, colour, shown, lower);
    const int marker = first ? (inside ? 7 : 6) : inside ? 13 : 12;
    const Ink ink{colour, marker};
    const double size = first ? 0.5 : 0.6;
    const std::string name = fmt::format("{}-{}-{}", panel.id, series.name, inside ? "inside" : "outside");
    if (!of.points.empty()) upper.add(plot.add_data(name, of.points), "2:3:4:5:6:7", ink.both_bars(0.8, size));
    if (!of.ratios.empty()) lower.add(plot.add_data(name + "-over-law", of.ratios), "2:3:4:5", ink.bars(0.8, size));
    if (!inside) shown.outside = shown.outside || !of.points.empty();
    if (!first) shown.second = shown.second || !of.points.empty();
  }
  if (first) shown.law = with_law;
}

/// mu beside each point of the first series, off the law and the guide.
void name_points(Panel& upper, const PowerLawPanel& panel, const PowerLawAxes& axes) {
  if (!panel.labels || panel.series.empty()) return;
  const PowerLawSeries& series = panel.series[0];
  const auto share = [](double value, const Range& axis) {
    return std::log(value / axis.low) / std::log(axis.high / axis.low);
  };
  const auto bar = [&share](double value, double error, const Range& axis) {
    return range_of(std::max(share(std::max(value - error, axis.low), axis), 0.0), share(value + error, axis));
  };
  LabelledPanel area{(panel.right - panel.left) * plot_width_inches, panel.height, {}, {}};
  const auto add_power = [&](double x, double y, double exponent) {
    area.lines.push_back({{0, share(y * std::pow(axes.x.low / x, exponent), axes.y)},
                          {1, share(y * std::pow(axes.x.high / x, exponent), axes.y)}});
  };
  const FittedPower law = law_of(series);
  if (law.known) add_power(1, law.at(1), law.exponent);
  const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
  if (!middle.extent.empty && !panel.paper_exponent.empty()) {
    add_power(middle.x, middle.y, std::stod(panel.paper_exponent));
  }
  area.notes_y.push_back(range_of(1 - note_height * static_cast<double>(panel.notes.size()), 1));
  std::vector<NamedPoint> points;
  for (const PowerLawPoint& point : series.points) {
    if (!fits_log_axes(point)) continue;
    points.push_back({{share(point.x, axes.x), share(point.y, axes.y)},
                      bar(point.x, point.x_error, axes.x),
                      bar(point.y, point.y_error, axes.y),
                      caption_number(point.mu)});
  }
  add_names(upper, points, area);
}

}  // namespace

std::string off_scale_in_words(const PowerLawShown& panel, const std::string& what) {
  std::vector<std::string> series, places;
  for (const auto& [name, mu] : panel.off_scale) {
    if (std::ranges::find(series, name) == series.end()) series.push_back(name);
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

void add_names(Panel& shown, const std::vector<NamedPoint>& points, const LabelledPanel& panel) {
  const std::vector<LabelPlace> places = place_labels(points, panel);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LabelPlace& place = places[i];
    if (place.with_line) {
      shown.arrows.push_back({points[i].at.x,
                              points[i].at.y,
                              place.touch.x,
                              place.touch.y,
                              "graph",
                              false,
                              {.colour = "frame", .width = 0.5}});
    }
    shown.texts.push_back({points[i].name, place.left.x, place.left.y});
  }
}

PowerLawShown add_power_law_panel(Plot& plot, const PowerLawPanel& wanted) {
  PowerLawShown shown;
  const PowerLawAxes axes = axes_of(wanted);
  if (axes.x.empty) return shown;
  shown.shown = true;
  Panel upper, lower;
  upper.left = lower.left = wanted.left;
  upper.right = lower.right = wanted.right;
  upper.name = lower.name = wanted.left - 0.092;
  upper.x = lower.x = log_axis(wanted.x_label, axes.x);
  upper.y = log_axis(wanted.y_label, axes.y);
  lower.y = linear_axis("over law", axes.ratio, 4);
  PowerLawPanel panel = wanted;
  for (const Axis* axis : {&upper.y, &lower.y}) {
    panel.left = std::max(panel.left, wanted.left + room_for_labels(axis->ticks, wanted.left - upper.name));
  }
  const double row = plot.height - plot.key.inches;
  if (!wanted.series.empty()) {
    const WindowMiddle middle = middle_of_window(wanted.series[0].points, wanted.series[0].fit.window);
    if (!middle.extent.empty && !wanted.paper_exponent.empty()) {
      upper.add_function(fmt::format("{} * ($1 / {})**{}", exact(middle.y), exact(middle.x), wanted.paper_exponent),
                         axes.x.low, axes.x.high, {.width = 1.4, .dash = 3});
    }
  }
  lower.add_level(1, {.colour = "frame", .width = 0.8});
  for (std::size_t index = std::min<std::size_t>(wanted.series.size(), 2); index-- > 0;) {
    add_series(plot, panel, index, axes, shown, upper, lower);
  }
  name_points(upper, panel, axes);
  constexpr std::array colours = {"blue", "vermilion", "black"};
  double line = 0.94;
  for (std::size_t i = 0; i < wanted.notes.size() && i < colours.size(); ++i) {
    if (wanted.notes[i].empty()) continue;
    upper.texts.push_back({wanted.notes[i], 0.04, line, "left", colours[i]});
    line -= 0.095;
  }
  const bool with_ratios = lower.curves.size() > 1;
  if (with_ratios) {
    upper.bottom = 0.48 + 0.27 * (row - 0.56);
    lower.top = row - upper.bottom + 0.06;
    upper.x = without_words(upper.x);
  }
  plot.panels.push_back(upper);
  if (with_ratios) plot.panels.push_back(lower);
  return shown;
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

OtherReading slopes_of(const Analysis& analysis) {
  OtherReading slopes{"slopes", "slopes", {}, analysis.scaling, analysis.c0()};
  for (const Transport& result : analysis.results) {
    if (!result.exact) slopes.points.push_back({result.scanned(), result.c, result.D});
  }
  return slopes;
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
    estimate.reason = fmt::format("too uncertain for a point: {}", value_with_error(estimate));
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
  return range_of(std::clamp(window[0], axis.low, axis.high), std::clamp(window[1], axis.low, axis.high));
}

std::string exponent_text(const ScalingFit& fit) {
  if (!fit.exponent.known()) return "unknown";
  if (!fit.misses_the_points()) return value_with_error(fit.exponent);
  return fmt::format("{} (χ² {}/{})", significant(fit.exponent.value, 3), significant(fit.scatter.chi2, 2),
                     fit.scatter.degrees_of_freedom);
}

}  // namespace granuscope
