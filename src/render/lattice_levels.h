#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "model/pile_layers.h"
#include "render/scene.h"

namespace granuscope {

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

}  // namespace granuscope
