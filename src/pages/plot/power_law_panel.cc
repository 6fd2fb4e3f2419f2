#include "plot/power_law_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "support/plain_text.h"

namespace granuscope {
namespace {

/// Points farther from their law than this are arrows at the edge of the narrow panel: they would flatten all others.
constexpr double lowest_ratio = 0.4, highest_ratio = 1.8;

/// A line of text, as a share of the panel.
constexpr double note_height = 0.095;

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

/// Where an error bar of x ends on a logarithmic axis, though x may be 0 within its error.
double lower_end(const PowerLawPoint& point) { return std::max(point.x - point.x_error, point.x / 3); }

/// A panel as it is being filled.
class LawPanel {
 public:
  LawPanel(Plot& plot, const PowerLawPanel& wanted) : plot_(plot), wanted_(wanted) {
    log_ = !(wanted.level > 0);
    if (!log_) y_.add(wanted.level);
    ratio_.add(0.95);
    ratio_.add(1.05);
    bool above = false;
    for (const PowerLawSeries& series : wanted.series) {
      above = above || stands_above(series);
      for (const PowerLawPoint& point : series.points) {
        if (!has_place(point)) continue;
        x_.add(lower_end(point));
        x_.add(point.x + point.x_error);
        y_.add(log_ ? std::max(point.y - point.y_error, point.y / 2) : wanted.level - point.y + point.y_error);
        y_.add(shown_as(point.y + point.y_error));
        const Ratio ratio = over_law(point, law_of(series));
        if (!ratio.shown) continue;
        ratio_.add(std::max(ratio.value - ratio.error, lowest_ratio));
        ratio_.add(std::min(ratio.value + ratio.error, highest_ratio));
      }
    }
    if (x_.empty) return;
    // A single point stands in a panel of at least a factor of 4.
    x_ = widened_by_factor(x_, x_.high / x_.low < 1.5 ? 2 : 1.35);
    if (log_) {
      y_ = widened_by_factor(y_, y_.high / y_.low < 1.5 ? 2 : 1.35);
      y_.low /= 1.5;                                       // room for the names of the curves
      const double room = above ? 1.05 * note_height : 0;  // for a name as long as the panel
      y_.high *= std::pow(y_.high / y_.low, room / (1 - room));
    } else {
      y_ = widened(range_of(y_.low, std::max(y_.high, y_.low + 0.001)), 0.13);
    }
    ratio_ = widened(ratio_, 0.08);
    const double row = plot.height - plot.key.inches;
    upper_.left = lower_.left = wanted.left;
    upper_.right = lower_.right = wanted.right;
    upper_.name = lower_.name = wanted.left - 0.063 - (wanted.ratios ? 0.03 : 0);
    upper_.name_above = !wanted.ratios;
    with_ratios_ =
        wanted.ratios && std::ranges::any_of(wanted.series, [](const auto& one) { return law_of(one).known; });
    upper_.top = wanted.ratios ? 0.08 : 0.24;
    upper_.bottom = with_ratios_ ? 0.48 + 0.27 * (row - 0.56) : 0.46;
    lower_.top = row - upper_.bottom + 0.06;
    upper_.x = lower_.x = log_axis(wanted.x_label, x_);
    upper_.y = log_ ? log_axis(wanted.y_label, y_) : linear_axis(wanted.y_label, y_, 7);
    lower_.y = linear_axis("data / fit", ratio_, 4);
    if (with_ratios_) upper_.x = without_words(upper_.x);
    lower_.add_level(1, {.colour = "frame", .width = 0.8});
    const double room = upper_.name_above ? 0 : room_for_labels(upper_.y.ticks, wanted.left - upper_.name);
    area_.width = (wanted.right - wanted.left - room) * plot_width_inches;
    if (plot.half_width) area_.width -= plot_width_inches - half_plot_width_inches * 9 / 8;  // text of 8 pt, not 9
    area_.height = row - upper_.top - upper_.bottom;
  }

  PowerLawShown fill() {
    if (x_.empty) return shown_;
    shown_.shown = true;
    if (!log_) {
      area_.lines.push_back({{0, up(wanted_.level)}, {1, up(wanted_.level)}});
      upper_.add_level(wanted_.level, {.colour = "frame", .width = 0.8});
      add_note(wanted_.level_note, 0.97, up(wanted_.level) + 0.05, "frame");
    }
    if (wanted_.guide_exponent > 0 && !wanted_.series.empty()) add_guide(wanted_.series.back());
    double above = 0.94, below = 0.07;
    for (std::size_t i = wanted_.series.size(); i-- > 0;) {
      const PowerLawSeries& series = wanted_.series[i];
      add_law(series);
      add_points(series);
      if (series.note.empty()) continue;
      double& place = stands_above(series) ? above : below;
      add_note(series.note, stands_above(series) || !log_ ? 0.03 : 0.98, place, series.ink.colour);
      place += stands_above(series) ? -note_height : note_height;
    }
    if (guided_) add_note(wanted_.guide_note, 0.98, below, "black");
    if (!log_) name_points();
    if (wanted_.paper_exponent > 0) add_slope_triangle();
    std::vector<std::string> off_scale;
    for (const double mu : off_scale_) off_scale.push_back(caption_number(mu));
    if (!off_scale.empty()) shown_.off_scale = "μ = " + enumeration(off_scale);
    plot_.panels.push_back(upper_);
    if (with_ratios_) plot_.panels.push_back(lower_);
    return shown_;
  }

 private:
  /// Read at one depth c0 - c lies above the slopes.
  static bool stands_above(const PowerLawSeries& series) { return series.name == "at_one_depth"; }

  bool has_place(const PowerLawPoint& point) const { return point.x > 0 && (point.y > 0 || !log_); }
  double shown_as(double y) const { return log_ ? y : wanted_.level - y; }
  double across(double x) const { return std::log(x / x_.low) / std::log(x_.high / x_.low); }
  double up(double y) const {
    return log_ ? std::log(y / y_.low) / std::log(y_.high / y_.low) : (y - y_.low) / y_.size();
  }

  void add_note(const std::string& text, double x, double y, const std::string& colour) {
    upper_.texts.push_back({text, x, y, x < 0.5 ? "left" : "right", colour});
    area_.add_text(text, x, y);
  }

  void add_law(const PowerLawSeries& series) {
    const FittedPower law = law_of(series);
    const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
    if (!law.known || !(middle.extent.size() > 0)) return;
    const std::string power = fmt::format("exp({}) * $1**{}", exact(law.intercept), exact(law.exponent));
    upper_.add_function(log_ ? power : fmt::format("{} - {}", exact(wanted_.level), power), middle.extent.low,
                        middle.extent.high, {.width = 1.2});
    shown_.law = true;
    add_line(middle.extent, [&](double x) { return shown_as(law.at(x)); });
  }

  /// A power law through the middle of the points, as far as it lies inside the axes.
  void add_guide(const PowerLawSeries& series) {
    const WindowMiddle middle = middle_of_window(series.points, series.fit.window);
    if (middle.extent.empty) return;
    const double k = wanted_.guide_exponent;
    const auto reaches = [&](double y) { return middle.x * std::pow(y / middle.y, 1 / k); };
    const Range reach = range_of(std::max(x_.low, reaches(y_.low)), std::min(x_.high, reaches(y_.high)));
    upper_.add_function(fmt::format("{} * ($1 / {})**{}", exact(middle.y), exact(middle.x), exact(k)), reach.low,
                        reach.high, {.width = 1, .dash = 2});
    add_line(reach, [&](double x) { return middle.y * std::pow(x / middle.x, k); });
    guided_ = true;
  }

  void add_line(const Range& reach, const std::function<double(double)>& y) {
    constexpr int pieces = 16;
    PanelPlace before{across(reach.low), up(y(reach.low))};
    for (int k = 1; k <= pieces; ++k) {
      const double x = reach.low * std::pow(reach.high / reach.low, static_cast<double>(k) / pieces);
      const PanelPlace here{across(x), up(y(x))};
      area_.lines.push_back({before, here});
      before = here;
    }
  }

  /// Filled where mu lies in the window of the fit, else open.
  void add_points(const PowerLawSeries& series) {
    const FittedPower law = law_of(series);
    for (const bool inside : {false, true}) {
      CsvTable points(power_law_columns(wanted_.x_unit, wanted_.y_unit));
      CsvTable ratios({"mu: dimensionless", "x: " + wanted_.x_unit, "y_over_law: dimensionless", "low: dimensionless",
                       "high: dimensionless"});
      for (const PowerLawPoint& point : series.points) {
        if (!has_place(point) || in_window(point.mu, series.fit.window) != inside) continue;
        // A bar that reaches zero or below ends at the axis.
        const double y = shown_as(point.y), left = std::max(point.x - point.x_error, x_.low);
        const double bottom = std::max(y - point.y_error, y_.low);
        points.add_row({point.mu, point.x, y, left, point.x + point.x_error, bottom, y + point.y_error});
        named_.push_back({{across(point.x), up(y)},
                          range_of(across(left), across(point.x + point.x_error)),
                          range_of(up(bottom), up(y + point.y_error)),
                          caption_number(point.mu)});
        if (with_ratios_) add_ratio(series, point, over_law(point, law), ratios);
      }
      const Ink ink{series.ink.colour, inside ? series.ink.marker : series.ink.marker - 1};
      const double size = series.ink.marker == 7 ? 0.5 : 0.65;
      const std::string name = fmt::format("{}-{}{}", wanted_.id, series.name, inside ? "" : "-outside");
      if (!points.empty())
        upper_.add(plot_.add_data(name, points), "2:3:4:5:6:7", ink.both_bars(0.8, size), series.note);
      if (!ratios.empty())
        lower_.add(plot_.add_data(name + "-over-law", ratios), "2:3:4:5", ink.bars(0.8, size), series.note);
    }
  }

  void add_ratio(const PowerLawSeries& series, const PowerLawPoint& point, const Ratio& ratio, CsvTable& ratios) {
    if (ratio.shown) {
      ratios.add_row({point.mu, point.x, ratio.value, std::max(ratio.value - ratio.error, ratio_.low),
                      std::min(ratio.value + ratio.error, ratio_.high)});
    } else if (law_of(series).known) {
      // An arrow at the edge of the narrow panel, where a point lies beyond it.
      const bool rises = ratio.value > 1;
      off_scale_.insert(point.mu);
      lower_.arrows.push_back(
          {point.x, rises ? 0.7 : 0.3, point.x, rises ? 0.98 : 0.02, "first", true, {.colour = series.ink.colour}});
    }
  }

  /// mu beside each point, with a thin line to it where it stands far from it.
  void name_points() {
    const std::vector<LabelPlace> places = place_labels(named_, area_);
    for (std::size_t i = 0; i < named_.size(); ++i) {
      const auto& [left, touch, with_line] = places[i];
      if (with_line) {
        upper_.arrows.push_back(
            {named_[i].at.x, named_[i].at.y, touch.x, touch.y, "graph", false, {.colour = "frame", .width = 0.5}});
      }
      upper_.texts.push_back({named_[i].name, left.x, left.y});
    }
  }

  /// What the paper has is a slope, and no height: a dotted triangle where nothing else stands, with its exponent.
  void add_slope_triangle() {
    for (const NamedPoint& point : named_) {
      area_.lines.push_back({{point.bar_x.low, point.at.y}, {point.bar_x.high, point.at.y}});
      area_.lines.push_back({{point.at.x, point.bar_y.low}, {point.at.x, point.bar_y.high}});
    }
    const double slope = wanted_.paper_exponent * std::log(x_.high / x_.low) / std::log(y_.high / y_.low);
    const SlopeTriangle triangle = place_slope_triangle(slope, wanted_.paper_note, area_);
    const auto side = [&](const PanelPlace& from, const PanelPlace& to, double width) {
      upper_.arrows.push_back({from.x, from.y, to.x, to.y, "graph", false, {.width = width, .dash = 3}});
    };
    side(triangle.low, triangle.high, 1.6);
    side(triangle.low, triangle.corner, 0.8);
    side(triangle.corner, triangle.high, 0.8);
    upper_.texts.push_back({wanted_.paper_note, triangle.text.x, triangle.text.y, triangle.align});
  }

  Plot& plot_;
  const PowerLawPanel& wanted_;
  bool log_ = true, guided_ = false, with_ratios_ = false;
  Range x_, y_, ratio_;
  Panel upper_, lower_;
  LabelledPanel area_;
  std::vector<NamedPoint> named_;
  std::set<double> off_scale_;
  PowerLawShown shown_;
};

}  // namespace

PowerLawShown add_power_law_panel(Plot& plot, const PowerLawPanel& panel) { return LawPanel(plot, panel).fill(); }

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

std::string exponent_text(const ScalingFit& fit) {
  if (!fit.exponent.known()) return "unknown";
  if (!fit.misses_the_points()) return value_with_error(fit.exponent);
  return fmt::format("{} (χ² {}/{})", significant(fit.exponent.value, 3), significant(fit.scatter.chi2, 2),
                     fit.scatter.degrees_of_freedom);
}

}  // namespace granuscope
