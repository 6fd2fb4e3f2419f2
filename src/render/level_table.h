#pragma once
#include <array>
#include <cstdint>

#include "render/colour_scale.h"
#include "render/scene.h"

namespace granuscope {

/// How each level of a scene meets the samples of the picture.
struct LevelTable {
  std::array<Rgb, 256> colour{};        ///< on the page
  std::array<Rgb, 256> full_colour{};   ///< as on paper, whatever the size of a sample
  std::array<std::uint8_t, 256> ink{};  ///< share of the sample that is covered, of 255: for a transparent background
  std::array<bool, 256> visible{};      ///< false where the colour rounds to the page's
};

/// A bar thinner than one sample would be hit or missed by chance; it is painted one sample wide instead, its colour
/// thinned out by the same factor. Where that colour rounds to the page's, at the 8 bits of the image, the bar cannot
/// be seen: width and colour map together decide.
LevelTable make_level_table(const ColourScale& scale, const ValueScale& values, Glyph glyph,
                            double samples_per_diameter);

/// Levels of the lines over a picture, above those of its values.
inline constexpr std::uint8_t solid_line_level = 255;
inline constexpr std::uint8_t dashed_line_level = 254;
inline constexpr int levels_below_lines = 253;

}  // namespace granuscope
