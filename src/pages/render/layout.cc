#include "render/layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include "support/error.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
namespace {

constexpr double mm_per_inch = 25.4;
constexpr double points_per_inch = 72;

// Distances of the decorations, in millimetres on paper.
constexpr double margin_mm = 1.0;        ///< between the outermost thing and the edge of the image
constexpr double tick_mm = 1.0;          ///< length of a tick
constexpr double gap_mm = 0.8;           ///< between things that belong together
constexpr double block_gap_mm = 2.4;     ///< between things that do not
constexpr double bar_mm = 2.0;           ///< height of the colour scale
constexpr double scale_length_mm = 40;   ///< length of the colour scale, if there is room
constexpr double scale_minimum_mm = 12;  ///< its shortest length
constexpr double tick_gap_mm = 4;        ///< between neighbouring numbers of an axis, at least
constexpr double arrow_mm = 5.0;         ///< length of the overload's arrow
constexpr double arrow_head_mm = 1.9;    ///< length of its head
constexpr double arrow_half_mm = 0.75;   ///< half the width of its head
constexpr double shaft_half_mm = 0.2;    ///< half the width of its shaft
constexpr double smallest_plot_mm = 12;  ///< plot areas narrower than this show nothing
constexpr double most_ticks = 16;        ///< of an axis, however large the paper
constexpr double line_points = 0.5;      ///< frame and ticks

/// Names of labels.
struct Words {
  const char* x_title;
  std::array<const char*, 3> z_titles;
  const char *one_diameter, *diameters;
};
constexpr Words words_of_pile = {
    "x axis", {"z axis", "z axis, short", "z axis, shortest"}, "one diameter", "diameters"};
constexpr Words words_of_packing = {
    "x axis of a packing", {"y axis", "y axis", "y axis, short"}, "one mean diameter", "mean diameters"};

const Words& words_of(const SceneSpec& spec) {
  return spec.coordinates == Coordinates::pile ? words_of_pile : words_of_packing;
}

/// Lengths on paper as pixels of this image.
class Paper {
 public:
  explicit Paper(double dpi) : dpi_(dpi) {}
  double exact_mm(double length) const { return length * dpi_ / mm_per_inch; }
  /// At least one pixel.
  int mm(double length) const { return std::max(1, static_cast<int>(std::lround(exact_mm(length)))); }
  int points(double length) const {
    return std::max(1, static_cast<int>(std::lround(length * dpi_ / points_per_inch)));
  }

 private:
  double dpi_;
};

/// A number on an axis: no trailing zeros, typographic minus, the decimal point of the language.
std::string number(double value) {
  std::string text = fmt::format("{:g}", std::abs(value));
  if (const std::size_t point = text.find('.'); point != std::string::npos)
    text.replace(point, 1, label("decimal point"));
  return value < 0 && text != "0" ? "\u2212" + text : text;
}

/// Ranges shorter than this, in bead diameters, may have numbers with a decimal.
constexpr double short_range = 8;

/// Room that the numbers of the axes need, whatever steps are chosen later: the steps depend on the size of the plot
/// area, which depends on this.
struct AxisRoom {
  int z_width = 0;  ///< of the widest number on the z axis
  int x_width = 0;
};

AxisRoom axis_room(const SceneSpec& spec, const Extent& extent, const Font& font) {
  const auto widest = [&](double largest, double range, bool negative) {
    std::string text = negative ? "\u2212" : "";
    text += std::string(fmt::format("{:.0f}", std::floor(largest)).size(), '0');  // digits have one width
    if (range < short_range) text += ".0";                                        // as axis_ticks() allows
    return font.width(text);
  };
  const bool upwards = spec.coordinates == Coordinates::packing;  // y = -z
  return {widest(std::max({std::abs(extent.z0), std::abs(extent.z1), spec.deepest_z}), extent.height(),
                 upwards && extent.z1 > 0),
          widest(std::max(std::abs(extent.x0), std::abs(extent.x1)), extent.width(), extent.x0 < 0)};
}

struct Margins {
  int left = 0, right = 0;
};

Margins side_margins(const SceneSpec& spec, const Extent& extent, const Font& font, const Paper& paper) {
  const AxisRoom room = axis_room(spec, extent, font);
  const int frame = paper.points(line_points);
  const int title = font.ascent() + font.descent();
  const int left =
      paper.mm(margin_mm) + title + paper.mm(gap_mm) + room.z_width + paper.mm(gap_mm) + paper.mm(tick_mm) + frame;
  // The last number of the x axis may hang over by half its width.
  const int right = paper.mm(margin_mm) + std::max(frame, room.x_width / 2 + 1);
  return {left, right};
}

/// Multiples of a round step from `low` to `high`, at least `room` pixels and a gap apart; at least one if there is any
/// number of the allowed digits in the range.
std::vector<double> axis_ticks(double low, double high, double pixels_per_diameter, int room, const Paper& paper) {
  const int lowest_power = high - low < short_range ? -1 : 0;
  const double roomy = (room + paper.mm(tick_gap_mm)) / pixels_per_diameter;
  RoundStep step = round_step_at_least(std::max(roomy, (high - low) / most_ticks), lowest_power);
  std::vector<double> values = multiples_within(low, high, step);
  if (values.size() < 2) {
    const double tight = (room + paper.mm(gap_mm)) / pixels_per_diameter;
    step = round_step_at_least(tight, lowest_power, {1, 2, 3, 5});
    values = multiples_within(low, high, step);
  }
  const double finest = std::pow(10.0, lowest_power);
  while (values.empty() && step.size() > finest) {
    // A low window deep in the pile, between two numbers of that step: one finer number has room.
    step = round_step_at_least(0.4 * step.size(), lowest_power);
    values = multiples_within(low, high, step);
    if (values.size() > 1) values = {values[values.size() / 2]};
  }
  return values;
}

void require_size(const SceneSpec& spec) {
  if (spec.width_px > max_image_px)
    throw InputError("an image cannot be {} pixels wide; choose at most {}", spec.width_px, max_image_px);
  if (!is_resolution(spec.dpi)) {
    throw InputError("{} dpi is no resolution to render at; choose {} to {}", spec.dpi, least_dpi, most_dpi);
  }
  if (!(spec.text_points >= 4 && spec.text_points <= 40)) {
    throw InputError("text of {:g} pt cannot be read or fills the picture; give 4 to 40", spec.text_points);
  }
}

/// The scale bar: a length of 1, 2, 5, 10, ... bead diameters, 10 where that reads well.
struct ScaleBar {
  double diameters = 0;
  int length_px = 0;
  std::string text;
};

ScaleBar scale_bar(const SceneSpec& spec, const Scene& scene, const Paper& paper) {
  const double shortest = std::max(paper.exact_mm(3) / scene.pixels_per_diameter, scene.extent.width() / 20);
  const double longest = scene.extent.width() / 3;
  double length = 10;
  if (length > longest) length = round_step_at_least(0.4 * longest, -1).size();  // 1, 2, 5: at most 2.5 apart
  if (length < shortest) length = round_step_at_least(std::min(shortest, longest), -1).size();
  ScaleBar bar;
  bar.diameters = length;
  bar.length_px = std::max(1, static_cast<int>(std::lround(length * scene.pixels_per_diameter)));
  bar.text =
      fmt::format("{} {}", number(length), label(length == 1 ? words_of(spec).one_diameter : words_of(spec).diameters));
  return bar;
}

/// Narrowest width of the colour scale: its title, or its numbers.
int narrowest_scale(const std::vector<std::string>& key_titles, const Font& font, const Paper& paper) {
  int width = paper.mm(scale_minimum_mm);
  for (const std::string& title : key_titles) width = std::max(width, font.width(title));
  return width;
}

/// What the texts need in width, whatever stands below or beside them.
int smallest_width(const SceneSpec& spec, const Extent& extent, const std::vector<std::string>& key_titles,
                   const Font& font, const Paper& paper) {
  const Margins margins = side_margins(spec, extent, font, paper);
  // The scale bar is shorter than the window, and so has no more digits.
  const std::string digits(fmt::format("{:.0f}", extent.width()).size(), '0');
  const int title = font.width(fmt::format("{} {}", digits, label(words_of(spec).diameters)));
  const int text =
      std::max({title, font.width(label(words_of(spec).x_title)), narrowest_scale(key_titles, font, paper)}) +
      2 * paper.mm(margin_mm);
  return std::max(margins.left + paper.mm(smallest_plot_mm) + margins.right, text);
}

Box box_around(double centre_x, int top, int width, int height) {
  // The last pixel of a text's width is the space after it.
  return {static_cast<int>(std::lround(centre_x - 0.5 * (width - 1))), top, width, height};
}

}  // namespace

double text_pixels(const SceneSpec& spec) {
  require_size(spec);
  return spec.text_points * spec.dpi / points_per_inch;
}

Font font_of(const SceneSpec& spec) { return Font(text_pixels(spec), spec.font_file); }

PlotSize plot_size(const SceneSpec& spec, const Extent& extent, const std::vector<std::string>& key_titles) {
  const Font font = font_of(spec);
  const Paper paper(spec.dpi);
  const int smallest = smallest_width(spec, extent, key_titles, font, paper);
  if (spec.width_px < smallest) {
    throw InputError(
        "an image {} pixels wide is too small for labels of {} pt at {} dpi; the smallest width is {} pixels",
        spec.width_px, spec.text_points, spec.dpi, smallest);
  }
  const Margins margins = side_margins(spec, extent, font, paper);
  PlotSize size;
  size.width_px = spec.width_px - margins.left - margins.right;
  size.pixels_per_diameter = size.width_px / extent.width();
  const double height = std::max(1.0, std::round(size.pixels_per_diameter * extent.height()));
  if (height > max_image_px) {
    throw InputError(
        "the picture of this window would be {:.0f} pixels high, and at most {} can be rendered; choose a smaller "
        "width or fewer layers",
        height, max_image_px);
  }
  size.height_px = static_cast<int>(height);
  return size;
}

namespace {

/// Builds a Layout from the top down.
class LayoutMaker {
 public:
  LayoutMaker(const SceneSpec& spec, const Scene& scene, const Font& font)
      : spec_(spec),
        scene_(scene),
        font_(font),
        paper_(spec.dpi),
        margins_(side_margins(spec, scene.extent, font, paper_)) {
    layout_.width = spec.width_px;
  }

  Layout make() {
    const int line = font_.ascent() + font_.descent();
    int top = paper_.mm(margin_mm) + (line + 1) / 2;  // half of a number at the upper end of the z axis
    if (scene_.overload || spec_.deepest_z > 0) top = paper_.mm(margin_mm) + paper_.mm(arrow_mm) + frame();
    layout_.plot = {margins_.left, top, scene_.plot_width_px, scene_.plot_height_px};
    add_frame();
    add_overload();
    add_z_axis();
    add_x_axis();
    add_legend();
    layout_.height = std::max(spec_.height_px, below_ + paper_.mm(margin_mm));
    if (layout_.height > max_image_px) {
      throw InputError(
          "the picture of this window would be {} pixels high, and at most {} can be rendered; choose a smaller width "
          "or fewer layers",
          layout_.height, max_image_px);
    }
    return std::move(layout_);
  }

 private:
  int frame() const { return paper_.points(line_points); }
  int line_height() const { return font_.ascent() + font_.descent(); }
  double pixel_of_x(double x) const { return layout_.plot.left + (x - scene_.extent.x0) * scene_.pixels_per_diameter; }
  double pixel_of_z(double z) const { return layout_.plot.top + (z - scene_.extent.z0) * scene_.pixels_per_diameter; }

  /// A line of the frame's thickness whose middle is at `centre`.
  int line_start(double centre) const { return static_cast<int>(std::lround(centre - 0.5 * frame())); }

  void add_label(std::string text, Box box, Reading reading = Reading::across) {
    layout_.labels.push_back({std::move(text), box, reading});
  }

  void add_frame() {
    const Box& plot = layout_.plot;
    const int t = frame();
    layout_.rules.push_back({{plot.left - t, plot.top - t, plot.width + 2 * t, t}, "frame"});
    layout_.rules.push_back({{plot.left - t, plot.bottom(), plot.width + 2 * t, t}, "frame"});
    layout_.rules.push_back({{plot.left - t, plot.top, t, plot.height}, "frame"});
    layout_.rules.push_back({{plot.right(), plot.top, t, plot.height}, "frame"});
    below_ = plot.bottom() + t;
  }

  void add_overload() {
    if (!scene_.overload) return;
    const double x = pixel_of_x(scene_.overload->x);
    const double tip = layout_.plot.top - frame();
    const double tail = tip - paper_.exact_mm(arrow_mm), neck = tip - paper_.exact_mm(arrow_head_mm);
    const double head = paper_.exact_mm(arrow_half_mm), shaft = std::max(0.5, paper_.exact_mm(shaft_half_mm));
    layout_.arrow = {{x, tip},          {x + head, neck},  {x + shaft, neck}, {x + shaft, tail},
                     {x - shaft, tail}, {x - shaft, neck}, {x - head, neck}};
    const std::string text = scene_.overload->added
                                 ? "+" + number(scene_.overload->load)
                                 : fmt::format("{} {}", label("overload"), number(scene_.overload->load));
    const int width = font_.width(text), gap = paper_.mm(gap_mm);
    const int right_of_it = static_cast<int>(std::ceil(x + head)) + gap;
    const bool fits = right_of_it + width <= layout_.width - paper_.mm(margin_mm);
    const int left = fits ? right_of_it : static_cast<int>(std::floor(x - head)) - gap - width;
    const int top = static_cast<int>(std::lround(0.5 * (tail + tip) - 0.5 * line_height()));
    add_label(text, {left, std::max(top, 0), width, line_height()});
  }

  void add_z_axis() {
    const Box& plot = layout_.plot;
    const int t = frame(), length = paper_.mm(tick_mm);
    const int number_right = plot.left - t - length - paper_.mm(gap_mm);
    for (const double z :
         axis_ticks(scene_.extent.z0, scene_.extent.z1, scene_.pixels_per_diameter, line_height(), paper_)) {
      const double at = pixel_of_z(z);
      layout_.rules.push_back({{plot.left - t - length, line_start(at), length, t}, "frame"});
      const std::string text = number(spec_.coordinates == Coordinates::pile ? z : -z);
      const int width = font_.width(text);
      const int base = static_cast<int>(std::lround(at + 0.5 * font_.digit_height()));
      add_label(text, {number_right - width, base - font_.ascent(), width, line_height()});
    }
    const int title_left = paper_.mm(margin_mm);
    const auto& z_titles = words_of(spec_).z_titles;
    for (const char* name : z_titles) {
      const std::string& title = label(name);
      const int length_px = font_.width(title);
      if (length_px > plot.height && name != z_titles.back()) continue;
      const int top = static_cast<int>(std::lround(plot.top + 0.5 * (plot.height - length_px)));
      add_label(title, {title_left, top, line_height(), length_px}, Reading::upwards);
      break;
    }
  }

  void add_x_axis() {
    const Box& plot = layout_.plot;
    const int t = frame(), length = paper_.mm(tick_mm);
    const int tick_top = plot.bottom() + t;
    const int room = axis_room(spec_, scene_.extent, font_).x_width;
    const int number_top = tick_top + length + paper_.mm(gap_mm);  // clear of the last number of the z axis
    for (const double x : axis_ticks(scene_.extent.x0, scene_.extent.x1, scene_.pixels_per_diameter, room, paper_)) {
      const double at = pixel_of_x(x);
      layout_.rules.push_back({{line_start(at), tick_top, t, length}, "frame"});
      const std::string text = number(x);
      add_label(text, box_around(at, number_top, font_.width(text), line_height()));
    }
    const int title_top = number_top + line_height() + paper_.mm(gap_mm) / 2;
    const std::string& words = label(words_of(spec_).x_title);
    Box title = box_around(plot.left + 0.5 * plot.width, title_top, font_.width(words), line_height());
    title.left = std::min(title.left, layout_.width - paper_.mm(margin_mm) - title.width);
    add_label(words, title);
    below_ = title.bottom();
  }

  /// Scale bar on the left, colour scale on the right, each a title above a bar. Where the image is too narrow for both
  /// at full length the axes alone say how long a diameter is.
  void add_legend() {
    const ScaleBar bar = scale_bar(spec_, scene_, paper_);
    const int bar_width = std::max(bar.length_px, font_.width(bar.text));
    const int left = layout_.plot.left, right = layout_.plot.right();
    const int narrowest = narrowest_scale({scene_.key_title}, font_, paper_), widest = paper_.mm(scale_length_mm);
    const int beside = right - left - bar_width - 2 * paper_.mm(block_gap_mm);
    const bool one_row = beside >= widest;

    const int top = below_ + paper_.mm(block_gap_mm);
    if (one_row) add_scale_bar(bar, bar_width, left, top);
    const int room = one_row ? beside : layout_.width - 2 * paper_.mm(margin_mm);
    const int length = std::clamp(room, narrowest, std::max(narrowest, widest));  // as long as its title
    // Numbers at its ends hang over by half their width, which the block gap or the margin takes.
    const int start = one_row ? right - length : std::min(left, layout_.width - paper_.mm(margin_mm) - length);
    add_colour_scale(length, start, top);
  }

  void add_scale_bar(const ScaleBar& bar, int width, int left, int top) {
    add_label(bar.text, {left + (width - font_.width(bar.text)) / 2, top, font_.width(bar.text), line_height()});
    const int thick = 2 * frame(), cap = paper_.mm(bar_mm) / 2;
    const int start = left + (width - bar.length_px) / 2;
    const int middle = top + line_height() + paper_.mm(bar_mm) / 2;
    layout_.rules.push_back({{start, middle - thick / 2, bar.length_px, thick}, "ink"});
    for (const int end : {start, start + bar.length_px - thick}) {
      layout_.rules.push_back({{end, middle - cap, thick, 2 * cap}, "ink"});
    }
    below_ = top + line_height() + paper_.mm(bar_mm);
  }

  /// Number at tick k of the colour scale; its ends tell when what lies beyond looks like what lies there.
  std::string scale_number(int k, int parts) const {
    const ValueScale& values = scene_.values;
    const bool below = k == 0 && scene_.value_min < values.low, above = k == parts && scene_.value_max > values.high;
    const double value = k == parts ? values.high : values.low + (values.high - values.low) * k / parts;
    const double rounding = 1e-12 * (values.high - values.low);
    return (below ? "\u2264 " : above ? "\u2265 " : "") + number(std::abs(value) < rounding ? 0 : value);
  }

  /// The numbers of a colour scale that begins at pixel `left`, as equal steps.
  std::vector<Label> scale_labels(int parts, int left, int length, int top) const {
    std::vector<Label> labels;
    const int edge = layout_.width - paper_.mm(margin_mm);
    for (int k = 0; k <= parts; ++k) {
      const std::string text = scale_number(k, parts);
      Box box = box_around(left + static_cast<double>(k) / parts * length, top, font_.width(text), line_height());
      box.left = std::clamp(box.left, paper_.mm(margin_mm), edge - box.width);
      labels.push_back({text, box});
    }
    return labels;
  }

  /// The largest number of equal steps that has room: of 1, 2 or 5 if possible, of at most two digits otherwise; and
  /// with 0 between them if it has both signs.
  int scale_parts(int left, int length) const {
    const double range = scene_.values.high - scene_.values.low;
    const double unit = std::pow(10.0, std::floor(std::log10(range) + 1e-9) - 1);
    const auto near = [](double value, double other) { return std::abs(value - other) < 1e-6; };
    for (const bool round_only : {true, false}) {
      for (const int parts : {5, 4, 3, 2}) {
        if (scene_.values.sign == Sign::both && parts % 2 == 1) continue;
        const double step = range / parts / unit;
        const bool round = near(step, 2) || near(step, 5) || near(step, 10) || near(step, 20) || near(step, 50);
        if (!near(step, std::round(step)) || (round_only && !round)) continue;
        const auto labels = scale_labels(parts, left, length, 0);
        bool room = true;
        for (std::size_t k = 1; k < labels.size(); ++k) {
          room = room && labels[k - 1].box.right() + paper_.mm(2 * gap_mm) <= labels[k].box.left;
        }
        if (room) return parts;
      }
    }
    return 1;
  }

  void add_colour_scale(int length, int left, int top) {
    add_label(scene_.key_title, {left, top, font_.width(scene_.key_title), line_height()});
    // Descenders stay clear of the colours.
    layout_.legend = {left, top + line_height() + paper_.mm(gap_mm) / 2, length, paper_.mm(bar_mm)};
    const int tick_top = layout_.legend.bottom(), t = frame(), tick = paper_.mm(tick_mm);
    const int number_top = tick_top + tick + paper_.mm(gap_mm) / 2;
    const int parts = scale_parts(left, length);
    for (int k = 0; k <= parts; ++k) {
      layout_.rules.push_back(
          {{line_start(left + static_cast<double>(k) / parts * length), tick_top, t, tick}, "frame"});
    }
    for (const Label& label : scale_labels(parts, left, length, number_top)) layout_.labels.push_back(label);
    below_ = std::max(below_, number_top + line_height());
  }

  const SceneSpec& spec_;
  const Scene& scene_;
  const Font& font_;
  Paper paper_;
  Margins margins_;
  Layout layout_;
  int below_ = 0;  ///< first free row
};

}  // namespace

Layout lay_out(const SceneSpec& spec, const Scene& scene, const Font& font) {
  return LayoutMaker(spec, scene, font).make();
}

Extent extent_of(const Lattice& lattice, const SceneSpec& spec) {
  const double half = lattice.half_width();
  double x0 = -half, x1 = half, n0 = 0, n1 = lattice.layers() - 1;
  if (spec.window) {
    const auto& window = *spec.window;
    const std::string given = fmt::format("the window {},{},{},{}", window[0], window[1], window[2], window[3]);
    if (!std::ranges::all_of(window, [](double value) { return std::isfinite(value); })) {
      throw InputError(given + " is not made of numbers; give X0,X1 in bead diameters and N0,N1 as layers");
    }
    x0 = window[0];
    x1 = window[1];
    n0 = window[2];
    n1 = window[3];
    if (x0 >= x1 || n0 > n1) {
      throw InputError(given + " is empty, so there is nothing to render; it needs X0 < X1 and N0 <= N1");
    }
    if (x1 - x0 < 1) {
      throw InputError(given + " is narrower than a bead, too narrow for an axis; X1 - X0 must be at least 1");
    }
    if (n0 != std::floor(n0) || n1 != std::floor(n1)) {
      throw InputError(given + " cuts through a layer; N0 and N1 are whole numbers, counted from 0 at the top");
    }
    if (n0 < 0 || n1 >= lattice.layers()) {
      throw InputError("{} asks for layers that the pile does not have; it has the layers 0 to {}", given,
                       lattice.layers() - 1);
    }
    if (x0 < -half || x1 > half) {
      throw InputError(
          "{} reaches around the ring of {} columns and would show beads twice; keep X0 and X1 between {} and {}",
          given, lattice.columns(), -half, half);
    }
  }
  // Whole beads: from the top of the first layer to the bottom of the last one.
  return {x0, x1, lattice.z(static_cast<int>(n0)) - 0.5, lattice.z(static_cast<int>(n1)) + 0.5};
}

PileRange range_needed(const Lattice& lattice, const SceneSpec& spec) {
  const Extent extent = extent_of(lattice, spec);
  if (!spec.skip_invisible) return whole_range(lattice);
  PileRange range = whole_range(lattice);
  range.horizontal = needs_horizontal_forces(spec.scene);
  if (spec.window) {
    // A layer further up or down, a bar is a diameter long and a bead's half wide: no more than one reaches in.
    range.first_layer = std::max(static_cast<int>((*spec.window)[2]) - 1, 0);
    range.layers = std::min(static_cast<int>((*spec.window)[3]) + 2, lattice.layers()) - range.first_layer;
  }
  const int left = static_cast<int>(std::floor(extent.x0 / lattice.pitch())) - 1;
  const int right = static_cast<int>(std::ceil(extent.x1 / lattice.pitch())) + 1;
  if (right - left + 1 < lattice.columns()) {
    range.beads = right - left + 1;
    range.first_bead = ((left + lattice.middle()) % lattice.columns() + lattice.columns()) % lattice.columns();
  }
  return range;
}

namespace {

/// Mixes `colour` into a pixel by its coverage, in sRGB as the plot area does.
void mix(std::uint8_t* pixel, Rgb colour, int cover) {
  if (pixel[3] == 255) {
    const auto mixed = [cover](int below, int above) {
      return static_cast<std::uint8_t>((below * (255 - cover) + above * cover + 127) / 255);
    };
    pixel[0] = mixed(pixel[0], colour.r);
    pixel[1] = mixed(pixel[1], colour.g);
    pixel[2] = mixed(pixel[2], colour.b);
    return;
  }
  // Over a background that is seen through: what lies below counts by its own share, in 1/255 of 1/255.
  const int below = pixel[3] * (255 - cover), above = 255 * cover, sum = below + above;
  const auto mixed = [=](int under, int over) {
    return static_cast<std::uint8_t>((under * below + over * above + sum / 2) / sum);
  };
  pixel[0] = mixed(pixel[0], colour.r);
  pixel[1] = mixed(pixel[1], colour.g);
  pixel[2] = mixed(pixel[2], colour.b);
  pixel[3] = static_cast<std::uint8_t>((sum + 127) / 255);
}

}  // namespace

Decorations::Decorations(const Scene& scene, const Layout& layout, const Palette& palette, const ColourScale& scale,
                         const Font& font) {
  const Rgb ink = palette.colour("ink");
  add_colour_scale(scene, layout.legend, scale, font);
  for (const Rule& rule : layout.rules) pieces_.push_back({rule.box, {}, {palette.colour(rule.colour)}});
  add_arrow(layout, ink, font);
  for (const Label& label : layout.labels) {
    const CoverageMask mask = font.paint(label.text);
    add(label.reading == Reading::upwards ? turned_upwards(mask) : mask, label.box.left, label.box.top, {ink});
  }
}

void Decorations::add(const CoverageMask& mask, int left, int top, std::vector<Rgb> colours) {
  pieces_.push_back({{left, top, mask.width, mask.height}, mask.coverage, std::move(colours)});
}

/// Where widths follow the force, a wedge on a base line: as thick and as dark as a bar of that force is, up to one
/// common factor of the thickness. Otherwise a bar of the colours.
void Decorations::add_colour_scale(const Scene& scene, const Box& box, const ColourScale& scale, const Font& font) {
  const double w = box.width, h = box.height;
  std::vector<Rgb> colours;
  for (int column = 0; column < box.width; ++column) {
    const double share = (column + 0.5) / w;
    colours.push_back(scale.at(scene.values.sign == Sign::both ? 2 * share - 1 : share));
  }
  if (scene.glyph == Glyph::force_bar) {
    add(font.fill({{0, h}, {w, h}, {w, 0}}, box.width, box.height), box.left, box.top, std::move(colours));
  } else {
    pieces_.push_back({box, {}, std::move(colours)});
  }
}

void Decorations::add_arrow(const Layout& layout, Rgb colour, const Font& font) {
  if (layout.arrow.empty()) return;
  const auto [left, right] =
      std::ranges::minmax_element(layout.arrow, [](const Corner& a, const Corner& b) { return a.x < b.x; });
  const auto [top, bottom] =
      std::ranges::minmax_element(layout.arrow, [](const Corner& a, const Corner& b) { return a.y < b.y; });
  const double x = std::floor(left->x), y = std::floor(top->y);
  std::vector<Corner> corners;
  for (const Corner& corner : layout.arrow) corners.push_back({corner.x - x, corner.y - y});
  add(font.fill(corners, static_cast<int>(std::ceil(right->x - x)), static_cast<int>(std::ceil(bottom->y - y))),
      static_cast<int>(x), static_cast<int>(y), {colour});
}

void Decorations::paint(Image& rows, int top) const {
  for (const Piece& piece : pieces_) {
    const Box& box = piece.box;
    for (int y = std::max(0, top - box.top); y < std::min(box.height, rows.height + top - box.top); ++y) {
      for (int x = std::max(0, -box.left); x < std::min(box.width, rows.width - box.left); ++x) {
        const auto column = static_cast<std::size_t>(x);
        const int cover =
            piece.coverage.empty()
                ? 255
                : piece.coverage[static_cast<std::size_t>(y) * static_cast<std::size_t>(box.width) + column];
        if (cover == 0) continue;
        mix(&rows.rgba[rows.offset(box.left + x, box.top + y - top)],
            piece.colours.size() == 1 ? piece.colours.front() : piece.colours[column], cover);
      }
    }
  }
}

namespace {

std::string& language() {
  static std::string name = "en";
  return name;
}

constexpr const char* file_name = "pictures/labels.txt";
constexpr std::string_view separator = " = ";

std::map<std::string, std::string, std::less<>> parse(std::string_view text) {
  std::map<std::string, std::string, std::less<>> labels;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty() || line.front() == '#') continue;
    const auto between = line.find(separator);
    if (between == std::string_view::npos) {
      throw std::logic_error(fmt::format("templates/{}: '{}' does not read `name = text`", file_name, line));
    }
    labels.emplace(line.substr(0, between), line.substr(between + separator.size()));
  }
  return labels;
}

}  // namespace

std::string label(std::string_view name) {
  const auto labels = parse(template_file(name_in_language(file_name, language())));
  const auto found = labels.find(name);
  if (found != labels.end()) return found->second;
  if (name == "decimal point") return ".";  // of templates from before there was one
  throw std::logic_error(fmt::format("templates/{} has no label '{}'", file_name, name));
}

void use_language_of_pictures(const std::string& name) { language() = name; }

}  // namespace granuscope
