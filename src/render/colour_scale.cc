#include "render/colour_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/scene.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Luminance of ITU-R BT.709 on the sRGB values as they are: only the order of two colours matters here.
double lightness(Rgb colour) { return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b; }

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

}  // namespace

ColourScale::ColourScale(const Palette& palette, const std::string& map) : page_(palette.colour("page")) {
  if (map != "grey" && map != "viridis" && map != "cividis") {
    throw InputError(
        fmt::format("'{}' is not a colour map for forces, which have one sign; choose grey, viridis or cividis", map));
  }
  std::vector<Rgb> colours = palette.colours(map);
  if (lightness(colours.front()) < lightness(colours.back())) std::reverse(colours.begin(), colours.end());
  if (colours.front() != page_) colours.insert(colours.begin(), page_);
  for (const Rgb colour : colours) {
    anchors_.push_back({static_cast<double>(colour.r), static_cast<double>(colour.g), static_cast<double>(colour.b)});
  }
}

Rgb ColourScale::at(double strength, double ink) const {
  const double position = std::clamp(strength, 0.0, 1.0) * static_cast<double>(anchors_.size() - 1);
  const std::size_t lower = std::min(static_cast<std::size_t>(position), anchors_.size() - 2);
  const double share = position - static_cast<double>(lower);
  std::array<double, 3> value{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double full = anchors_[lower][c] + share * (anchors_[lower + 1][c] - anchors_[lower][c]);
    value[c] = anchors_[0][c] + std::clamp(ink, 0.0, 1.0) * (full - anchors_[0][c]);
  }
  return {to_byte(value[0]), to_byte(value[1]), to_byte(value[2])};
}

Stroke stroke_of(const ColourScale& scale, double strength, double width_diameters, double pixels_per_diameter) {
  const double samples = width_diameters * pixels_per_diameter * samples_per_axis;
  return {std::max(samples, 1.0) / samples_per_axis, scale.at(strength, std::min(samples, 1.0))};
}

}  // namespace granuscope
