#pragma once
#include <array>
#include <string>
#include <vector>

#include "render/palette.h"
#include "render/value_scale.h"

namespace granuscope {

/// Colours of the strengths of a scale on the page. One-signed: the page itself at 0, darker and darker up to 1; a map
/// that is known from dark to light is turned around, and one that does not start at the colour of the page gets the
/// page as a first anchor; so nothing shows nothing, and darkness is monotone. Both signs: a map from -1 to 1 whose
/// middle is the page.
class ColourScale {
 public:
  /// Throws InputError unless `map` is one of the palette's maps for this kind: grey, viridis, cividis, or diverging.
  ColourScale(const Palette& palette, const std::string& map, Sign sign = Sign::one);

  Rgb page() const { return page_; }
  /// Colour of strength 0 .. 1 or -1 .. 1 (beyond: the end), where a share `ink` (0 .. 1) of the page is covered by it.
  Rgb at(double strength, double ink = 1) const;

 private:
  Rgb page_;
  Sign sign_;
  std::vector<std::array<double, 3>> anchors_;
};

}  // namespace granuscope
