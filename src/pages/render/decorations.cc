#include "render/decorations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>

#include "support/templates.h"

namespace granuscope {
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
