#include "plot/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "support/plain_text.h"

namespace granuscope {
void Range::add(double number) {
  if (!std::isfinite(number)) return;
  low = empty ? number : std::min(low, number);
  high = empty ? number : std::max(high, number);
  empty = false;
}

std::vector<Tick> linear_marks(const Range& range, int most) {
  if (!(range.size() > 0)) return {{fmt::format("{:.6g}", range.low), range.low}};
  const RoundStep step = round_step_with_at_most(most, range.low, range.high);
  std::vector<Tick> marks;
  for (const double mark : multiples_within(range.low, range.high, step)) {
    std::string label = fmt::format("{:.{}f}", std::abs(mark), std::max(0, -step.exponent));
    if (mark < 0) label.insert(0, "−");
    marks.push_back({label, mark});
  }
  return marks;
}

namespace {

/// "0.002", or "2 × 10⁻³": in plain letters, since WeasyPrint misplaces raised ones.
std::string log_label(const LogMark& mark, bool as_power) {
  if (!as_power) return fmt::format("{:.6g}", mark.value());
  return (mark.digit == 1 ? "" : fmt::format("{} × ", mark.digit)) + power_of_ten(mark.exponent);
}

}  // namespace

std::vector<Tick> log_marks(const Range& range) {
  std::vector<Tick> marks;
  int labels = 0;
  constexpr double smallest_plain = 1e-3, largest_plain = 9e4;
  const bool as_powers = range.low < smallest_plain * (1 - 1e-9) || range.high > largest_plain;
  const bool decades_only = std::floor(std::log10(range.high)) - std::ceil(std::log10(range.low)) >= 1;
  for (const LogMark& mark : log_marks_within(range.low, range.high)) {
    const bool labelled = mark.digit == 1 || (!decades_only && (mark.digit == 2 || mark.digit == 5));
    if (labelled) ++labels;
    marks.push_back({labelled ? log_label(mark, as_powers) : "", mark.value(), !labelled});
  }
  // So short an axis reads better with even steps.
  return labels < 2 ? linear_marks(range, 4) : marks;
}

Axis linear_axis(std::string label, const Range& shown, int most, const Range& marked) {
  return {std::move(label), shown.low, shown.high, false, linear_marks(marked, most)};
}

Axis linear_axis(std::string label, const Range& shown, int most) {
  return linear_axis(std::move(label), shown, most, shown);
}

Axis log_axis(std::string label, const Range& shown) {
  return {std::move(label), shown.low, shown.high, true, log_marks(shown)};
}

Axis without_words(Axis axis) {
  axis.silent = true;
  for (Tick& tick : axis.ticks) tick.label.clear();
  return axis;
}

Range widened(const Range& range, double share) {
  Range wider = range;
  wider.low -= share * range.size();
  wider.high += share * range.size();
  return wider;
}

std::vector<Tick> three_marks(double reach) {
  const double power = std::pow(10, std::floor(std::log10(reach)));
  const double mark = power * (reach >= 5 * power ? 5 : reach >= 2 * power ? 2 : 1);
  const std::string label = fmt::format("{:.6g}", mark);
  return {{"−" + label, -mark}, {"0", 0}, {label, mark}};
}

namespace {

/// Width of a label in units of the font's size, in DejaVu Sans.
double width_in_ems(const std::string& label) {
  double width = 0;
  for (std::size_t i = 0; i < label.size(); ++i) {
    const auto byte = static_cast<unsigned char>(label[i]);
    if ((byte & 0xC0U) == 0x80U) continue;  // a later byte of a letter
    const bool sign = label.compare(i, 3, "−") == 0 || label.compare(i, 2, "×") == 0;
    width += byte == '.' || byte == ' ' ? 0.32 : sign ? 0.84 : byte < 0x80U ? 0.64 : 0.43;
  }
  return width;
}

}  // namespace

double room_for_labels(const std::vector<Tick>& ticks, double from_name) {
  constexpr double font_points = 9, plot_points = 6.69 * 72;
  constexpr double of_name = 0.029;
  double widest = 0;
  for (const Tick& tick : ticks) widest = std::max(widest, width_in_ems(tick.label));
  return std::max(0.0, widest * font_points / plot_points - (from_name - of_name));
}

Range widened_by_factor(const Range& range, double factor) {
  Range wider = range;
  wider.low /= factor;
  wider.high *= factor;
  return wider;
}

namespace {

/// Of the small font of insets, 8 pt DejaVu Sans, in inches: a digit, a line of text, half the mark of a point.
constexpr double character_width = 0.068, line_height = 0.125, half_mark = 0.035;
/// Room that two names leave between them if they can, inches.
constexpr double air = 0.05;
/// Beyond this gap between point and name, in inches, a line joins them.
constexpr double longest_gap_without_line = 0.09;

/// A rectangle in inches from the panel's lower left corner.
struct LabelBox {
  double left = 0, right = 0, bottom = 0, top = 0;
};

struct Point {
  double x = 0, y = 0;
};

double distance(const LabelBox& box, const Point& point) {
  return std::hypot(std::max({box.left - point.x, point.x - box.right, 0.0}),
                    std::max({box.bottom - point.y, point.y - box.top, 0.0}));
}

double overlap(const LabelBox& a, const LabelBox& b) {
  const double width = std::min(a.right, b.right) - std::max(a.left, b.left);
  const double height = std::min(a.top, b.top) - std::max(a.bottom, b.bottom);
  return width > 0 && height > 0 ? width * height : 0;
}

struct Segment {
  Point from, to;
};

/// Length of the part of `segment` inside `box`, in inches (Liang and Barsky's clipping).
double length_inside(const Segment& segment, const LabelBox& box) {
  const double dx = segment.to.x - segment.from.x, dy = segment.to.y - segment.from.y;
  double enter = 0, leave = 1;
  const double limits[4][2] = {{-dx, segment.from.x - box.left},
                               {dx, box.right - segment.from.x},
                               {-dy, segment.from.y - box.bottom},
                               {dy, box.top - segment.from.y}};
  for (const auto& [rate, room] : limits) {
    if (rate == 0) {
      if (room < 0) return 0;
      continue;
    }
    if (rate < 0) {
      enter = std::max(enter, room / rate);
    } else {
      leave = std::min(leave, room / rate);
    }
  }
  return leave > enter ? (leave - enter) * std::hypot(dx, dy) : 0;
}

bool cross(const Segment& a, const Segment& b) {
  const auto side = [](const Point& p, const Point& q, const Point& r) {
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  };
  return side(a.from, a.to, b.from) * side(a.from, a.to, b.to) < 0 &&
         side(b.from, b.to, a.from) * side(b.from, b.to, a.to) < 0;
}

struct Placed {
  LabelBox box;
  Segment line;
  double gap = 0;  ///< between point and box, inches
  bool with_line() const { return gap > longest_gap_without_line; }
};

double text_width(const std::string& text) {
  // UTF-8: bytes that go on with a character do not widen the text.
  const auto characters =
      std::ranges::count_if(text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0) != 0x80; });
  return character_width * static_cast<double>(characters);
}

std::vector<LabelBox> boxes_taken(const LabelledPanel& panel) {
  std::vector<LabelBox> boxes;
  for (const auto& [from, to] : panel.taken) {
    boxes.push_back({from.x * panel.width, to.x * panel.width, from.y * panel.height, to.y * panel.height});
  }
  return boxes;
}

/// What a place costs: weights chosen so that two names never share a place while there is another one.
class Placement {
 public:
  Placement(const std::vector<NamedPoint>& points, const LabelledPanel& panel) : panel_(panel) {
    for (const PanelLine& line : panel.lines) curves_.push_back({inches(line.from), inches(line.to)});
    for (const NamedPoint& point : points) {
      const Point at = inches(point.at);
      points_.push_back(at);
      marks_.push_back({at.x - half_mark, at.x + half_mark, at.y - half_mark, at.y + half_mark});
      sizes_.push_back(text_width(point.name));
      if (!point.bar_x.empty) {
        bars_.push_back({{point.bar_x.low * panel.width, at.y}, {point.bar_x.high * panel.width, at.y}});
      }
      if (!point.bar_y.empty) {
        bars_.push_back({{at.x, point.bar_y.low * panel.height}, {at.x, point.bar_y.high * panel.height}});
      }
    }
    notes_ = boxes_taken(panel);
  }

  std::vector<Placed> find() const {
    std::vector<Placed> placed(points_.size());
    std::vector<bool> known(points_.size(), false);
    // Each sweep lets every name answer to the places that the others have taken.
    for (int sweep = 0; sweep < 4; ++sweep) {
      for (std::size_t i = 0; i < points_.size(); ++i) {
        known[i] = false;
        placed[i] = best(i, placed, known);
        known[i] = true;
      }
    }
    return placed;
  }

 private:
  Point inches(const PanelPlace& place) const { return {place.x * panel_.width, place.y * panel_.height}; }

  Placed candidate(std::size_t i, double angle, double gap) const {
    const double half_width = sizes_[i] / 2, half_height = line_height / 2;
    // The box's middle in that direction, its nearest edge `gap` from the point.
    const double c = std::cos(angle), s = std::sin(angle);
    const double reach =
        std::min(half_width / std::max(std::abs(c), 1e-9), half_height / std::max(std::abs(s), 1e-9)) + gap;
    const Point middle{points_[i].x + reach * c, points_[i].y + reach * s};
    const LabelBox box{middle.x - half_width, middle.x + half_width, middle.y - half_height, middle.y + half_height};
    const Point touch{std::clamp(points_[i].x, box.left, box.right), std::clamp(middle.y, box.bottom, box.top)};
    return {box, {points_[i], touch}, gap};
  }

  double cost(std::size_t i, const Placed& place, const std::vector<Placed>& others,
              const std::vector<bool>& known) const {
    const LabelBox& box = place.box;
    double sum = 2 * place.gap;
    const double own = distance(box, points_[i]);
    const double outside = std::max(
        {0.0, 0.03 - box.left, box.right - panel_.width + 0.03, 0.03 - box.bottom, box.top - panel_.height + 0.03});
    sum += 1000 * outside;
    for (const LabelBox& note : notes_) sum += 2000 * overlap(box, note);
    for (const Segment& bar : bars_) sum += 5 * length_inside(bar, box);
    for (const Segment& curve : curves_) sum += 1.5 * length_inside(curve, box);
    for (std::size_t j = 0; j < points_.size(); ++j) {
      sum += 500 * overlap(box, marks_[j]);
      if (j == i) continue;
      // Beside another point it would read as that one's name, unless a line leads to its own.
      if (!place.with_line() && distance(box, points_[j]) < own + air) sum += 3;
      if (place.with_line()) sum += 20 * length_inside(place.line, marks_[j]);
      if (!known[j]) continue;
      sum += 2000 * overlap(box, others[j].box);
      // Names that nearly touch read as one.
      sum += 40 * overlap({box.left - air, box.right + air, box.bottom - air, box.top + air}, others[j].box);
      if (place.with_line()) sum += 10 * length_inside(place.line, others[j].box);
      if (others[j].with_line()) sum += 10 * length_inside(others[j].line, box);
      if (place.with_line() && others[j].with_line() && cross(place.line, others[j].line)) sum += 2;
    }
    return sum;
  }

  Placed best(std::size_t i, const std::vector<Placed>& others, const std::vector<bool>& known) const {
    Placed chosen;
    double least = 0;
    bool first = true;
    for (const double gap : {0.05, 0.08, 0.15, 0.22, 0.3, 0.4, 0.5, 0.6}) {
      // To the right first: where two places cost the same the earlier one is taken.
      for (int step = 0; step < 24; ++step) {
        const int turn = step % 2 == 0 ? step / 2 : -(step + 1) / 2;
        const Placed place = candidate(i, turn * std::numbers::pi / 12, gap);
        const double price = cost(i, place, others, known);
        if (!first && price >= least - 1e-9) continue;
        first = false;
        least = price;
        chosen = place;
      }
    }
    return chosen;
  }

  const LabelledPanel& panel_;
  std::vector<Point> points_;
  std::vector<LabelBox> marks_, notes_;
  std::vector<double> sizes_;
  std::vector<Segment> bars_, curves_;
};

}  // namespace

std::vector<LabelPlace> place_labels(const std::vector<NamedPoint>& points, const LabelledPanel& panel) {
  std::vector<LabelPlace> places;
  for (const Placed& placed : Placement(points, panel).find()) {
    const auto share = [&panel](double x, double y) { return PanelPlace{x / panel.width, y / panel.height}; };
    places.push_back({share(placed.box.left, (placed.box.bottom + placed.box.top) / 2),
                      share(placed.line.to.x, placed.line.to.y), placed.with_line()});
  }
  return places;
}

void LabelledPanel::add_text(const std::string& text, double x, double y) {
  // Other languages take more room.
  const double wide = 1.2 * text_width(text) / width, half = 0.5 * line_height / height;
  taken.push_back({{x < 0.5 ? x : x - wide, y - half}, {x < 0.5 ? x + wide : x, y + half}});
}

SlopeTriangle place_slope_triangle(double slope, const std::string& text, const LabelledPanel& panel) {
  // Inches: its longest side, what is to stay free around it, steps of the search.
  constexpr double hypotenuse = 0.7, free = 0.09, step = 0.03;
  const double rise = slope * panel.height / panel.width, across = hypotenuse / std::hypot(1, rise), up = rise * across;
  const double width = std::max(across, 1.2 * text_width(text)), height = up + 1.4 * line_height;
  const std::vector<LabelBox> notes = boxes_taken(panel);
  const auto air_around = [&](const LabelBox& box) {
    double least = std::min({box.left, box.bottom, panel.width - box.right, panel.height - box.top});
    for (const LabelBox& note : notes) {
      const double x = std::max(note.left - box.right, box.left - note.right);
      least = std::min(least, std::max(x, std::max(note.bottom - box.top, box.bottom - note.top)));
    }
    constexpr int pieces = 20;
    for (const auto& [from, to] : panel.lines) {
      for (int k = 0; k <= pieces; ++k) {
        const double share = static_cast<double>(k) / pieces;
        least = std::min(least, distance(box, {(from.x + share * (to.x - from.x)) * panel.width,
                                               (from.y + share * (to.y - from.y)) * panel.height}));
      }
    }
    return least;
  };
  double best = -1e9;
  SlopeTriangle chosen;
  for (double left = 0.02; left + width < panel.width; left += step) {
    for (double bottom = 0.02; bottom + height < panel.height; bottom += step) {
      // In the upper left it stands on its tip below its text, else on its side above it.
      const bool tip = bottom / panel.height > left / panel.width;
      const double x = tip ? left : left + width - across, y = tip ? bottom : bottom + height - up;
      const double line = tip ? bottom + height - line_height : bottom;
      const double clear =
          std::min(air_around({x, x + across, y, y + up}), air_around({left, left + width, line, line + line_height}));
      const double merit = std::min(clear, free) - 0.001 * std::max(clear - free, 0.0);
      if (merit <= best) continue;
      best = merit;
      const auto share = [&](double along, double high) {
        return PanelPlace{along / panel.width, high / panel.height};
      };
      chosen = {share(x, y), share(x + across, y + up), tip ? share(x, y + up) : share(x + across, y),
                share(tip ? left : left + width, line + 0.5 * line_height), tip ? "left" : "right"};
    }
  }
  return chosen;
}

}  // namespace granuscope
