#pragma once
#include <array>
#include <string>
#include <vector>

#include "render/palette.h"

namespace granuscope {

/// Colour of a one-signed quantity drawn on the page: the page itself at 0, darker and darker up to 1. A map that
/// is known from dark to light is turned around, and one that does not start at the colour of the page gets the page as
/// a first anchor; so nothing shows nothing, and darkness is monotone.
class ColourScale {
 public:
  /// Throws InputError unless `map` is one of the one-signed maps grey, viridis, cividis.
  ColourScale(const Palette& palette, const std::string& map);

  Rgb page() const { return page_; }
  /// Colour of strength 0 .. 1 (beyond: the end), where a share `ink` (0 .. 1) of the page is covered by it.
  Rgb at(double strength, double ink = 1) const;

 private:
  Rgb page_;
  std::vector<std::array<double, 3>> anchors_;
};

/// A bar as it meets the pixels.
struct Stroke {
  double width_px = 0;
  Rgb colour;
};

/// The stroke of a bar of this strength and width. A bar thinner than one sample would be hit or missed by chance; it
/// is drawn one sample wide instead, its colour thinned out by the same factor. Where that colour rounds to the page's
/// the bar cannot be seen: width and colour map together decide, at the 8 bits of the image.
Stroke stroke_of(const ColourScale& scale, double strength, double width_diameters, double pixels_per_diameter);

}  // namespace granuscope
