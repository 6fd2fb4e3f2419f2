#include "render/furniture.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace granuscope {
namespace {

/// Mixes `colour_at(column)` into the image by the mask's coverage, in sRGB as the plot area does.
template <typename ColourAt>
void blend(const CoverageMask& mask, int left, int top, Image& image, ColourAt&& colour_at) {
  for (int y = std::max(0, -top); y < std::min(mask.height, image.height - top); ++y) {
    for (int x = std::max(0, -left); x < std::min(mask.width, image.width - left); ++x) {
      const int cover = mask.coverage[static_cast<std::size_t>(y) * static_cast<std::size_t>(mask.width) +
                                      static_cast<std::size_t>(x)];
      if (cover == 0) continue;
      const Rgb colour = colour_at(x);
      std::uint8_t* pixel = &image.rgba[image.offset(left + x, top + y)];
      if (pixel[3] == 255) {
        const auto mix = [cover](int below, int above) {
          return static_cast<std::uint8_t>((below * (255 - cover) + above * cover + 127) / 255);
        };
        pixel[0] = mix(pixel[0], colour.r);
        pixel[1] = mix(pixel[1], colour.g);
        pixel[2] = mix(pixel[2], colour.b);
        continue;
      }
      // Over a background that is seen through: what lies below counts by its own share, in 1/255 of 1/255.
      const int below = pixel[3] * (255 - cover), above = 255 * cover, sum = below + above;
      const auto mix = [=](int under, int over) {
        return static_cast<std::uint8_t>((under * below + over * above + sum / 2) / sum);
      };
      pixel[0] = mix(pixel[0], colour.r);
      pixel[1] = mix(pixel[1], colour.g);
      pixel[2] = mix(pixel[2], colour.b);
      pixel[3] = static_cast<std::uint8_t>((sum + 127) / 255);
    }
  }
}

CoverageMask whole(int width, int height) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 255)};
}

void draw_arrow(const Layout& layout, Rgb colour, const Font& font, Image& image) {
  if (layout.arrow.empty()) return;
  const auto [left, right] = std::minmax_element(layout.arrow.begin(), layout.arrow.end(),
                                                 [](const Corner& a, const Corner& b) { return a.x < b.x; });
  const auto [top, bottom] = std::minmax_element(layout.arrow.begin(), layout.arrow.end(),
                                                 [](const Corner& a, const Corner& b) { return a.y < b.y; });
  const double x = std::floor(left->x), y = std::floor(top->y);
  std::vector<Corner> corners;
  for (const Corner& corner : layout.arrow) corners.push_back({corner.x - x, corner.y - y});
  const CoverageMask mask =
      font.fill(corners, static_cast<int>(std::ceil(right->x - x)), static_cast<int>(std::ceil(bottom->y - y)));
  blend(mask, static_cast<int>(x), static_cast<int>(y), image, [colour](int) { return colour; });
}

/// Where widths follow the force, a wedge on a base line: as thick and as dark as a bar of that force is, up to one
/// common factor of the thickness. Otherwise a bar of the colours.
void draw_colour_scale(const Scene& scene, const Box& box, const ColourScale& scale, const Font& font, Image& image) {
  const double w = box.width, h = box.height;
  const bool wedge = scene.glyph == Glyph::force_bar;
  const CoverageMask mask =
      wedge ? font.fill({{0, h}, {w, h}, {w, 0}}, box.width, box.height) : whole(box.width, box.height);
  blend(mask, box.left, box.top, image, [&](int column) {
    const double share = (column + 0.5) / w;
    return scale.at(scene.values.sign == Sign::both ? 2 * share - 1 : share);
  });
}

}  // namespace

void draw_furniture(const Scene& scene, const Layout& layout, const Palette& palette, const ColourScale& scale,
                    const Font& font, Image& image) {
  const Rgb ink = palette.colour("ink");
  draw_colour_scale(scene, layout.legend, scale, font, image);
  for (const Rule& rule : layout.rules) {
    const Rgb colour = palette.colour(rule.colour);
    blend(whole(rule.box.width, rule.box.height), rule.box.left, rule.box.top, image, [colour](int) { return colour; });
  }
  draw_arrow(layout, ink, font, image);
  for (const Label& label : layout.labels) {
    const CoverageMask mask = font.draw(label.text);
    blend(label.reading == Reading::upwards ? turned_upwards(mask) : mask, label.box.left, label.box.top, image,
          [ink](int) { return ink; });
  }
}

}  // namespace granuscope
