#include "render/level_table.h"

#include <algorithm>
#include <cmath>

namespace granuscope {

double width_of(Glyph glyph, double strength) {
  switch (glyph) {
    case Glyph::force_bar:
      return widest_bar * std::abs(strength);
    case Glyph::even_bar:
      return even_bar_width;
    case Glyph::bead:
    case Glyph::cell:
      return 1;
  }
  return 0;
}

int samples_per_axis(double pixels_per_diameter) {
  constexpr double fewest = 4, most = 64;
  constexpr double per_diameter = 8;
  return static_cast<int>(std::clamp(std::ceil(per_diameter / pixels_per_diameter), fewest, most));
}

LevelTable make_level_table(const ColourScale& scale, const ValueScale& values, Glyph glyph,
                            double samples_per_diameter) {
  LevelTable table;
  for (std::size_t level = 0; level < 256; ++level) {
    if (static_cast<int>(level) > values.most_levels) {
      const Rgb line = Palette::builtin().colour(level == solid_line_level ? "ray" : "envelope");
      table.colour[level] = table.full_colour[level] = line;
      table.ink[level] = 255;
      table.visible[level] = true;
      continue;
    }
    const double strength = values.strength(static_cast<std::uint8_t>(level));
    const double ink = std::min(width_of(glyph, strength) * samples_per_diameter, 1.0);
    table.full_colour[level] = scale.at(strength);
    table.colour[level] = scale.at(strength, ink);
    table.visible[level] = table.colour[level] != scale.page();
    table.ink[level] = table.visible[level] ? static_cast<std::uint8_t>(std::lround(255 * ink)) : 0;
  }
  if (values.sign == Sign::both) {
    // Both signs of a step are seen or neither, so that none that is not seen hides one that is.
    for (std::size_t level = 2; level + 1 <= static_cast<std::size_t>(values.most_levels); level += 2) {
      table.visible[level] = table.visible[level + 1] = table.visible[level] || table.visible[level + 1];
    }
  }
  return table;
}

}  // namespace granuscope
