#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/pile.h"
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

/// The largest width of an image, and its largest height.
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

/// Share of the window's elements that the scale covers. A few contacts are far stronger than the rest (at large
/// friction a hundred times, and most so in the lowest layer, which carries nothing below it); a scale up to the very
/// strongest would leave the page white.
inline constexpr double scale_quantile = 0.97;

/// Below this many pixels per bead diameter even the widest bar is thinner than a pixel, and the level of detail takes
/// over: one pixel over the width of the widest bar.
inline constexpr double detail_pixels_per_diameter = 1 / widest_bar;

/// Names of the scenes of a pile, as --scene takes them.
std::vector<std::string> pile_scenes();
/// Whether a scene shows the difference of two piles. Throws InputError if there is no such scene.
bool needs_two_piles(const std::string& scene);
/// Whether it needs H as well as V. Throws InputError if there is no such scene.
bool needs_horizontal_forces(const std::string& scene);
/// The title of its colour scale. Throws InputError if there is no such scene.
std::string key_title_of(const std::string& scene);

/// What can be said against a picture before there is a pile: throws InputError for an unknown scene or colour map, a
/// window that is empty or leaves the lattice, a size that cannot be, a range that is none, or the friction of a pile
/// without any.
void check_drawable(const Lattice& lattice, double mu, const SceneSpec& spec);

/// What is shown of a pile:
/// - "forces" (right part of Fig. 1 of the paper): each contact is a bar between the centres of the two beads it
///   connects, whose width and darkness follow the magnitude sqrt(V² + H²) of its force;
/// - "weight": each bead is a disc, darker the more weight V_R + V_L it passes on;
/// - "friction": each contact is a bar whose colour is the mobilisation |T| / (mu N) of its friction, 0 to 1;
/// - "response": each bead is a disc coloured by how its weight differs from that in the pile `minus`.
/// Contacts that leave the lowest layer are painted up to the contact point; those that cross the seam of the ring
/// appear on both sides. What lies beside the window, and what has a colour that rounds to the page's at this width and
/// dpi, is left out and counted; with spec.skip_invisible = false everything is painted, and the picture is the same.
/// Where a bead is smaller than two pixels the level of detail is used, unless nothing is to be skipped.
///
/// The piles' range must be range_needed() (render/layout.h); they are gone through layer by layer, here and when the
/// scene is painted. Throws InputError: unknown scene or colour map; a force that is not finite; piles that do not
/// belong together; a range or window that is empty or leaves the pile; an image size that cannot be (see layout.h).
Scene build_scene(const std::shared_ptr<PileLayers>& pile, const std::shared_ptr<PileLayers>& minus,
                  const SceneSpec& spec);
/// The same of piles in memory, whose arrays must outlive the scene.
Scene build_scene(const PileView& pile, const PileView* minus, const SceneSpec& spec);

/// What a scene shows of a pile.
enum class Quantity {
  force,         ///< sqrt(V² + H²) of a contact
  mobilisation,  ///< |T| / (mu N) of a contact, 0 .. 1; 0 where N = 0
  weight,        ///< V_R + V_L of a bead
  response       ///< the weight, minus that of the same bead of another pile
};

inline bool shows_contacts(Quantity quantity) {
  return quantity == Quantity::force || quantity == Quantity::mobilisation;
}

/// Places of a layer, counted without end to both sides: bead i stands at place i - middle, and again a turn of the
/// ring further. x = place + ½ (layer mod 2).
struct Places {
  int first = 0, last = -1;
  int count() const { return last < first ? 0 : last - first + 1; }
};

/// The values of a pile's contacts or beads, layer by layer, by place, and which of them a window shows.
class LatticeValues {
 public:
  /// `minus`: the other pile of a response, of the same range; null otherwise.
  LatticeValues(std::shared_ptr<PileLayers> pile, std::shared_ptr<PileLayers> minus, Quantity quantity);

  const Lattice& lattice() const { return pile_->about().lattice; }
  Quantity quantity() const { return quantity_; }
  /// Values that a layer has at each bead: 2 (the contacts to the lower left and right), or 1.
  int sides() const { return shows_contacts(quantity_) ? 2 : 1; }
  /// Brings the layers first .. last, unless they are more than a band, so that going through them again and again
  /// reads nothing twice.
  void hold(int first, int last) const;
  /// Values of `count` places of a layer, at side 0 (left, or the bead) or 1. The places must be in the pile's range.
  void values(int layer, int side, int first_place, std::span<double> values) const;

  /// Half the width and height of the region around a bead's centre that its element on this side may reach.
  Extent reach(int layer, int side) const;
  /// Places of a layer whose element on this side reaches into a region; none if the whole layer does not.
  Places places(int layer, int side, const Extent& region) const;
  /// Layers that may reach into a region, from the first to the last (first > last if none does).
  std::array<int, 2> layers(const Extent& region) const;
  int bead_at(int place) const;

 private:
  std::shared_ptr<PileLayers> pile_, minus_;
  Quantity quantity_;
  double half_width_;  ///< of a bar, or of a bead
};

/// The same as levels of a scale; and the places that can be painted.
class LatticeLevels {
 public:
  /// Elements whose places lie outside `extent` are left out if `inside_only`.
  LatticeLevels(LatticeValues values, const ValueScale& scale, const Extent& extent, bool inside_only);

  const LatticeValues& values() const { return values_; }
  /// As LatticeValues::values(), as levels.
  void levels(int layer, int side, int first_place, std::span<std::uint8_t> levels) const;
  /// As LatticeValues::places(), without those that are not painted.
  Places places(int layer, int side, const Extent& region) const;
  std::array<int, 2> layers(const Extent& region) const;

 private:
  LatticeValues values_;
  ValueScale scale_;
  Extent extent_;
  bool inside_only_;
};

/// Values on cells side by side at one depth.
struct FieldRow {
  double z = 0;   ///< of the cells' middle
  double x0 = 0;  ///< left edge of the first cell
  std::vector<double> values;
  double cell = 1;  ///< width of each

  double left_of(std::size_t k) const { return x0 + static_cast<double>(k) * cell; }
};

/// A quantity over the plane, such as the mean response P(x, z) of an ensemble, and lines over it.
struct Field {
  std::vector<FieldRow> rows;  ///< z ascending; each reaches half way to the next, but not into a gap between them
  std::string key_title;       ///< of the colour scale
  std::vector<OverlayLine> lines;
};

/// Scene "field": each cell in the colour of its value (negative ones, the noise around 0, as the page), and the lines
/// over it. Layers of spec.window count as in a pile. Throws InputError: no or misshapen rows; a value that is not
/// finite; a window, range, colour map or size that cannot be.
Scene build_field_scene(const Field& field, const SceneSpec& spec);

}  // namespace granuscope
