#include "render/field_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "model/lattice.h"
#include "render/colour_scale.h"
#include "render/layout.h"
#include "render/level_table.h"
#include "support/error.h"

namespace granuscope {
namespace {

constexpr double line_points = 1.0;
constexpr double dash_points = 5.0, dash_gap_points = 3.0;

/// The strongest of a response stand in few cells, at its source.
constexpr double field_quantile = 0.995;

struct Edges {
  double top, bottom;
};

/// How far rows may reach up or down: where far fewer layers were recorded than elsewhere, page tells so better than
/// one row painted over all of them. 1.5 times half the usual distance.
double longest_reach(const Field& field) {
  std::vector<double> gaps;
  for (std::size_t k = 1; k < field.rows.size(); ++k) gaps.push_back(field.rows[k].z - field.rows[k - 1].z);
  if (gaps.empty()) return 0.5;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return 0.75 * *middle;
}

Edges edges_of(const Field& field, std::size_t row, double longest) {
  const auto& rows = field.rows;
  const double z = rows[row].z;
  const bool first = row == 0, last = row + 1 == rows.size();
  // A gap that is too long is nobody's: both rows beside it are as high as they usually are.
  const auto reach = [&](double gap) { return 0.5 * gap <= longest ? 0.5 * gap : longest / 1.5; };
  const double above = first ? 0 : reach(z - rows[row - 1].z), below = last ? 0 : reach(rows[row + 1].z - z);
  if (first && last) return {z - 0.5, z + 0.5};
  return {z - (first ? below : above), z + (last ? above : below)};
}

void require_rows(const Field& field) {
  if (field.rows.empty()) throw InputError("the field has no rows, so there is nothing to render; record some layers");
  for (std::size_t k = 0; k < field.rows.size(); ++k) {
    if (field.rows[k].values.empty() || (k > 0 && field.rows[k].z <= field.rows[k - 1].z)) {
      throw InputError("the rows of the field are empty or not in the order of their depths; sort them");
    }
  }
}

Extent field_extent(const Field& field, const SceneSpec& spec) {
  if (spec.window) {
    const auto& window = *spec.window;
    const bool finite = std::all_of(window.begin(), window.end(), [](double value) { return std::isfinite(value); });
    if (!finite || window[1] - window[0] < 1 || window[2] > window[3] || window[2] < 0 || window[3] > 1e9) {
      throw InputError("the window of the field is empty; it needs X0 < X1, a bead diameter apart, and N0 <= N1");
    }
    return {window[0], window[1], Lattice::depth(static_cast<int>(window[2])) - 0.5,
            Lattice::depth(static_cast<int>(window[3])) + 0.5};
  }
  Extent extent{field.rows[0].x0, field.rows[0].x0, 0,
                edges_of(field, field.rows.size() - 1, longest_reach(field)).bottom};
  for (const FieldRow& row : field.rows) {
    extent.x0 = std::min(extent.x0, row.x0);
    extent.x1 = std::max(extent.x1, row.x0 + static_cast<double>(row.values.size()));
  }
  return extent;
}

/// Pieces of a line, as bars with round ends.
void add_line(const OverlayLine& line, double point, std::vector<Element>& elements) {
  const double width = line_points * point, dash = dash_points * point, gap = dash_gap_points * point;
  double along = 0;  // of the line so far
  for (std::size_t k = 1; k < line.points.size(); ++k) {
    const auto &from = line.points[k - 1], &to = line.points[k];
    const double length = std::hypot(to[0] - from[0], to[1] - from[1]);
    const auto add = [&](double start, double end) {
      const auto at = [&](double share, std::size_t axis) { return from[axis] + share * (to[axis] - from[axis]); };
      const double a = start / length, b = end / length;
      elements.push_back({at(a, 0), at(a, 1), at(b, 0), at(b, 1), width,
                          line.dashed ? dashed_line_level : solid_line_level, Outline::bar});
    };
    if (!(length > 0) || !std::isfinite(length)) continue;
    if (!line.dashed) {
      add(0, length);
    } else {
      const double start = -std::fmod(along, dash + gap);
      const int dashes = static_cast<int>(std::ceil((length - start) / (dash + gap)));
      for (int k_dash = 0; k_dash < dashes; ++k_dash) {
        const double first = start + k_dash * (dash + gap);
        if (first + dash > 0 && first < length) add(std::max(first, 0.0), std::min(first + dash, length));
      }
    }
    along += length;
  }
}

}  // namespace

Scene build_field_scene(const Field& field, const SceneSpec& spec) {
  require_rows(field);
  Scene scene;
  scene.name = "field";
  scene.glyph = Glyph::cell;
  scene.key_title = field.key_title;
  scene.colour_map = spec.colour_map.empty() ? "grey" : spec.colour_map;
  const ColourScale colours(Palette::builtin(), scene.colour_map);
  scene.extent = field_extent(field, spec);
  const PlotSize size = plot_size(spec, scene.extent, scene.key_title);
  scene.plot_width_px = size.width_px;
  scene.plot_height_px = size.height_px;
  scene.pixels_per_diameter = size.pixels_per_diameter;

  MagnitudeHistogram seen;
  scene.value_min = std::numeric_limits<double>::infinity();
  scene.value_max = -std::numeric_limits<double>::infinity();
  std::vector<Element> elements;
  std::vector<double> values;
  const double longest = longest_reach(field);
  for (std::size_t row = 0; row < field.rows.size(); ++row) {
    const Edges edges = edges_of(field, row, longest);
    for (std::size_t k = 0; k < field.rows[row].values.size(); ++k) {
      const double value = field.rows[row].values[k], x = field.rows[row].x0 + static_cast<double>(k);
      if (!std::isfinite(value)) throw InputError("the field holds numbers that are not finite; measure it again");
      if (x >= scene.extent.x1 || x + 1 <= scene.extent.x0 || edges.top >= scene.extent.z1 ||
          edges.bottom <= scene.extent.z0) {
        ++scene.counts.outside;
        continue;
      }
      scene.value_min = std::min(scene.value_min, value);
      scene.value_max = std::max(scene.value_max, value);
      seen.add(std::abs(value));
      elements.push_back({x, edges.top, x + 1, edges.bottom, 1, 0, Outline::box});
      values.push_back(value);
    }
  }
  if (values.empty()) throw InputError("the window shows no cell of the field; choose a larger one");
  const double top = seen.quantile(field_quantile);
  std::array<double, 2> ends{0, top > 0 ? round_up(top) : 1};
  if (spec.range) ends = checked_range(*spec.range, Sign::one);
  scene.values = {ends[0], ends[1], Sign::one, levels_below_lines};
  for (std::size_t k = 0; k < values.size(); ++k) elements[k].level = scene.values.level(values[k]);

  if (spec.skip_invisible) {
    const double samples_per_diameter = scene.pixels_per_diameter * samples_per_axis(scene.pixels_per_diameter);
    const LevelTable table = make_level_table(colours, scene.values, scene.glyph, samples_per_diameter);
    scene.counts.too_faint = std::erase_if(elements, [&](const Element& cell) { return !table.visible[cell.level]; });
  }
  scene.counts.drawn = elements.size();
  const double point = spec.dpi / 72 / scene.pixels_per_diameter;
  for (const OverlayLine& line : field.lines) add_line(line, point, elements);

  scene.elements = [elements = std::move(elements)](const Extent& region, const Scene::Visit& visit) {
    for (const Element& element : elements) {
      const double reach = element.outline == Outline::bar ? 0.5 * element.width : 0;
      if (std::max(element.x0, element.x1) + reach < region.x0 || std::min(element.x0, element.x1) - reach > region.x1)
        continue;
      if (std::max(element.z0, element.z1) + reach < region.z0 || std::min(element.z0, element.z1) - reach > region.z1)
        continue;
      visit(element);
    }
  };
  return scene;
}

}  // namespace granuscope
