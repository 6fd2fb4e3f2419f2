#include "render/colour_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/error.h"

namespace granuscope {
namespace {

/// Luminance of ITU-R BT.709 on the sRGB values as they are: only the order of two colours matters here.
double lightness(Rgb colour) { return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b; }

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

std::vector<Rgb> anchors_of(const Palette& palette, const std::string& map, Sign sign, Rgb page) {
  const bool one_signed = map == "grey" || map == "viridis" || map == "cividis";
  if (sign == Sign::one && !one_signed) {
    throw InputError(fmt::format(
        "'{}' is not a colour map for a quantity of one sign, as this scene shows; choose grey, viridis or cividis",
        map));
  }
  if (sign == Sign::both && map != "diverging") {
    throw InputError(fmt::format(
        "'{}' is not a colour map for a quantity of both signs, as this scene shows; choose diverging", map));
  }
  std::vector<Rgb> colours = palette.colours(map);
  if (sign == Sign::both) {
    if (colours.size() % 2 == 0 || colours[colours.size() / 2] != page) {
      throw std::logic_error("palette.txt: the middle of the diverging map is not the page");
    }
    return colours;
  }
  if (lightness(colours.front()) < lightness(colours.back())) std::reverse(colours.begin(), colours.end());
  if (colours.front() != page) colours.insert(colours.begin(), page);
  return colours;
}

}  // namespace

ColourScale::ColourScale(const Palette& palette, const std::string& map, Sign sign)
    : page_(palette.colour("page")), sign_(sign) {
  for (const Rgb colour : anchors_of(palette, map, sign, page_)) {
    anchors_.push_back({static_cast<double>(colour.r), static_cast<double>(colour.g), static_cast<double>(colour.b)});
  }
}

Rgb ColourScale::at(double strength, double ink) const {
  const double place = sign_ == Sign::one ? strength : 0.5 * (strength + 1);
  const double position = std::clamp(place, 0.0, 1.0) * static_cast<double>(anchors_.size() - 1);
  const std::size_t lower = std::min(static_cast<std::size_t>(position), anchors_.size() - 2);
  const double share = position - static_cast<double>(lower);
  const std::array<double, 3> page{static_cast<double>(page_.r), static_cast<double>(page_.g),
                                   static_cast<double>(page_.b)};
  std::array<double, 3> value{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double full = anchors_[lower][c] + share * (anchors_[lower + 1][c] - anchors_[lower][c]);
    value[c] = page[c] + std::clamp(ink, 0.0, 1.0) * (full - page[c]);
  }
  return {to_byte(value[0]), to_byte(value[1]), to_byte(value[2])};
}

}  // namespace granuscope
