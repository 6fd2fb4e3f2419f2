#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/pile.h"
#include "render/scene.h"

namespace granuscope {
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
