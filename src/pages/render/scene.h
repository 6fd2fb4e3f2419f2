#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/palette.h"

namespace granuscope {
enum class Background { page, transparent };

/// What positions count: x and depth z of a pile in bead diameters, or x and y, upwards, of other particles in mean
/// ones.
enum class Coordinates { pile, packing };

/// What to render, and how large. Windows count from the overloaded bead, as x of a response does.
struct SceneSpec {
  std::string scene = "forces";
  Coordinates coordinates = Coordinates::pile;
  int width_px = 1600;  ///< of the whole image, axes and legend included
  double dpi = 300;     ///< mm = 25.4 px / dpi; text is laid out in points
  double text_points = 8;
  std::string font_file = {};  ///< of the text; empty: DejaVu Sans
  /// x0, x1 in bead diameters from the middle and first, last layer, both inclusive; of a packing x0, x1, y0, y1. None:
  /// all of it.
  std::optional<std::array<double, 4>> window;
  std::optional<std::array<double, 2>> range;  ///< ends of the colour scale; none: from what is shown
  std::string colour_map = "grey";             ///< empty: the scene's own
  std::string backend = "auto";
  bool skip_invisible = true;
  Background background = Background::page;
  // Of the frames of a film (render_pile.h), so that all of them have one size and their axes in one place.
  int height_px = 0;  ///< of the whole image, blank below what it shows; 0: as high as that is
  double deepest_z =
      0;  ///< the z axis leaves room for its number, and there is room for an overload; 0: for what is seen
};

/// What was painted and what was left out, counted: drawn + outside + too_faint + aggregated = elements of the pile
/// (contacts, or beads in scenes that colour beads).
struct SceneCounts {
  std::uint64_t drawn = 0;
  std::uint64_t outside = 0;     ///< beside the window
  std::uint64_t too_faint = 0;   ///< their contribution rounds to nothing at 8 bits
  std::uint64_t aggregated = 0;  ///< painted by the level of detail, as samples that several share
  std::uint64_t pixels = 0;
};

/// Widths an image may have; heights obey the same upper limit.
inline constexpr int min_image_px = 1;
inline constexpr int max_image_px = 32768;

/// The part of the plane that is rendered, in bead diameters: x from the overloaded bead, z down from the surface (the
/// top of layer 0, so that layer n has its centres at Lattice::z(n)).
struct Extent {
  double x0 = 0, x1 = 0, z0 = 0, z1 = 0;
  double width() const { return x1 - x0; }
  double height() const { return z1 - z0; }
};

enum class Outline {
  bar,  ///< with round ends, around the line from (x0, z0) to (x1, z1); a disc if both are one point
  box   ///< from (x0, z0) to (x1, z1), its sides along the axes
};

/// One thing that is painted, in bead diameters. Where several lie over each other the highest level is seen, whatever
/// the order: strong contacts lie on weak ones.
struct Element {
  double x0 = 0, z0 = 0, x1 = 0, z1 = 0;
  double width = 0;  ///< of a bar
  std::uint8_t level = 0;
  Outline outline = Outline::bar;
};

/// How a level looks, beside its colour.
enum class Glyph {
  force_bar,  ///< contacts as bars whose width grows with the level
  even_bar,   ///< contacts as bars of one width
  bead,       ///< beads as discs
  cell        ///< boxes
};

/// Width at strength 1, in bead diameters.
inline constexpr double widest_bar = 0.5;
inline constexpr double even_bar_width = 0.4;

double width_of(Glyph glyph, double strength);

/// The one bead whose load differs from all the others.
struct Overload {
  double x = 0;        ///< bead diameters from the middle
  double load = 0;     ///< units of the load on an ordinary top bead
  bool added = false;  ///< what is added to that load, of which the picture shows the effect
};

/// A line over the picture, of constant thickness on paper.
struct OverlayLine {
  std::vector<std::array<double, 2>> points;  ///< x, z
  bool dashed = false;
};

class LatticeLevels;

/// What is to be rendered, free of how.
struct Scene {
  std::string name;
  Extent extent;
  int plot_width_px = 0;  ///< of the plot area alone
  int plot_height_px = 0;
  double pixels_per_diameter = 0;
  std::string colour_map;
  ValueScale values;
  Glyph glyph = Glyph::force_bar;
  std::string key_title;  ///< of the legend
  double value_min = 0;   ///< in the window; beyond the ends of the scale all look alike
  double value_max = 0;
  std::optional<Overload> overload;
  SceneCounts counts;

  using Visit = std::function<void(const Element&)>;
  /// Calls its second argument for each element that may reach into a region, and perhaps for others; elements that
  /// reach only beyond the extent's edge are met by infinite regions.
  std::function<void(const Extent&, const Visit&)> elements;
  /// Lines over the elements.
  std::vector<OverlayLine> overlay;
  /// Set where the level of detail is to be used: a pile whose widest bars are thinner than a pixel.
  std::shared_ptr<const LatticeLevels> detail;
};

/// Samples along each edge of a pixel. A pixel is the mean of their squares, taken in sRGB space: a grey of the map
/// then stays the share of black that was painted, which linear light would lighten. At least 4; and at least as many
/// as give a bead diameter 8 of them, so that a thumbnail shows what a poster seen from far does.
int samples_per_axis(double pixels_per_diameter);

/// Keyword and text of what an image carries beside its pixels (UTF-8; a keyword has 1 to 79 ASCII characters).
using ImageMetadata = std::vector<std::pair<std::string, std::string>>;

/// How the pixels of a file are stored: as few channels as lose nothing.
enum class Channels { grey, rgb, rgba };

/// Pixels in sRGB, 8 bits a channel, rows from the top, four bytes R G B A a pixel (A not premultiplied).
struct Image {
  Image() = default;
  /// An image of one colour.
  Image(int width_px, int height_px, Rgb colour, std::uint8_t alpha = 255) : width(width_px), height(height_px) {
    fill(colour, alpha);
  }

  /// Gives all pixels, as many as width and height tell, one colour.
  void fill(Rgb colour, std::uint8_t alpha) {
    rgba.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
      rgba[i] = colour.r;
      rgba[i + 1] = colour.g;
      rgba[i + 2] = colour.b;
      rgba[i + 3] = alpha;
    }
  }

  std::size_t offset(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  Rgb at(int x, int y) const { return {rgba[offset(x, y)], rgba[offset(x, y) + 1], rgba[offset(x, y) + 2]}; }

  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

}  // namespace granuscope
