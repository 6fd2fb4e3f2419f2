#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "model/pile.h"
#include "render/font.h"
#include "render/palette.h"
#include "render/scene.h"

namespace granuscope {
/// Pixels left .. left + width - 1, top .. top + height - 1.
struct Box {
  int left = 0, top = 0, width = 0, height = 0;
  int right() const { return left + width; }
  int bottom() const { return top + height; }
};

enum class Reading { across, upwards };

struct Label {
  std::string text;
  Box box;
  Reading reading = Reading::across;
};

/// A filled box of one of the palette's colours: ticks, axis lines, the scale bar.
struct Rule {
  Box box;
  std::string colour;
};

/// Where everything of a picture is, in final pixels. Distances come from millimetres and points, so that they follow
/// the dpi; the plot area takes what is left.
struct Layout {
  int width = 0, height = 0;
  Box plot;  ///< the plot area; its frame lies around it
  std::vector<Label> labels;
  std::vector<Rule> rules;
  std::vector<Corner> arrow;  ///< of the overload; empty if there is none in the window
  Box legend;                 ///< the colour scale, its low end on the left
};

/// Pixels per inch that a picture can have.
inline constexpr double least_dpi = 10;
inline constexpr double most_dpi = 4800;
inline bool is_resolution(double dpi) { return dpi >= least_dpi && dpi <= most_dpi; }

/// Size of the plot area for an image of this specification: width and height in pixels, and pixels per bead diameter.
/// `key_titles`: of the colour scales of all pictures of this size. Throws InputError if the width or dpi is out of
/// range, if the text leaves too little room (naming the smallest width), or if the picture would be too high.
struct PlotSize {
  int width_px = 0, height_px = 0;
  double pixels_per_diameter = 0;
};
PlotSize plot_size(const SceneSpec& spec, const Extent& extent, const std::vector<std::string>& key_titles);

/// Places axes, ticks, labels, scale bar and legend around the plot area of `scene`. Throws InputError as plot_size().
Layout lay_out(const SceneSpec& spec, const Scene& scene, const Font& font);

/// The font of the labels, at the final pixel size for this dpi. Throws InputError if dpi or size is out of range.
Font font_of(const SceneSpec& spec);
double text_pixels(const SceneSpec& spec);  ///< its size

/// The part of the plane that a specification asks for: whole beads, from the top of the first layer to the bottom of
/// the last one. Throws InputError if the window is empty, holds no layer or leaves the pile.
Extent extent_of(const Lattice& lattice, const SceneSpec& spec);

/// The layers and beads whose contacts may reach into the window, and which of their forces the scene is about; all of
/// them if nothing is to be skipped.
PileRange range_needed(const Lattice& lattice, const SceneSpec& spec);

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
