#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "render/font.h"
#include "render/layout.h"
#include "render/palette.h"
#include "render/scene.h"

namespace granuscope {
/// Everything of a layout that is not the plot area: frame, ticks, labels, arrow, scale bar and colour scale. It is
/// made once and painted into as many bands of the picture as there are.
class Decorations {
 public:
  Decorations(const Scene& scene, const Layout& layout, const Palette& palette, const ColourScale& scale,
              const Font& font);

  /// Paints what lies in these rows, the first of which is row `top` of the picture.
  void paint(Image& rows, int top) const;

 private:
  /// Colours mixed in by the coverage of a mask, or wholly where there is none.
  struct Piece {
    Box box;
    std::vector<std::uint8_t> coverage;
    std::vector<Rgb> colours;  ///< one for all, or one for each column
  };
  void add(const CoverageMask& mask, int left, int top, std::vector<Rgb> colours);
  void add_colour_scale(const Scene& scene, const Box& box, const ColourScale& scale, const Font& font);
  void add_arrow(const Layout& layout, Rgb colour, const Font& font);

  std::vector<Piece> pieces_;  ///< in the order they are painted
};

/// What templates/pictures/labels.txt has under that name: the wording of axes, scale bar, arrow and colour scales.
/// Throws std::logic_error if it has nothing: names of labels come from the program, not from the user.
std::string label(std::string_view name);

/// From now on it has the wording of this language, as name_in_language finds it.
void use_language_of_pictures(const std::string& language);

}  // namespace granuscope
