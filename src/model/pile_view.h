#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "model/pile.h"

namespace granuscope {

/// Some layers and beads of a lattice: layers first_layer .. first_layer + layers - 1, and in each the beads
/// first_bead, first_bead + 1, ... around the ring, at most all of them once.
struct PileRange {
  int first_layer = 0, layers = 0;
  int first_bead = 0, beads = 0;
  bool horizontal = true;  ///< false: of their forces only the vertical parts; H_R and H_L are empty

  std::size_t size() const { return static_cast<std::size_t>(layers) * static_cast<std::size_t>(beads); }
};

inline PileRange whole_range(const Lattice& lattice) { return {0, lattice.layers(), 0, lattice.columns()}; }

/// A pile, or a part of one, to look at; it owns nothing. The arrays are those of Pile, of shape [range.layers,
/// range.beads].
struct PileView {
  Lattice lattice;  ///< of the whole pile
  PileRange range;
  std::span<const double> V_R, V_L, H_R, H_L;
  std::span<const double> load;  ///< of all columns
  LoadLine load_line;
  double bead_weight = 0;

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, sample = 0;

  /// Place of bead `bead` (0 .. columns - 1) of a layer, both inside the range.
  std::size_t index(int layer, int bead) const {
    const int place = bead >= range.first_bead ? bead - range.first_bead : bead - range.first_bead + lattice.columns();
    return static_cast<std::size_t>(layer - range.first_layer) * static_cast<std::size_t>(range.beads) +
           static_cast<std::size_t>(place);
  }
};

inline PileView view_of(const Pile& pile) {
  return {pile.lattice,   whole_range(pile.lattice), pile.V_R, pile.V_L, pile.H_R,  pile.H_L,   pile.load,
          pile.load_line, pile.bead_weight,          pile.mu,  pile.law, pile.seed, pile.sample};
}

/// A part of a pile that owns its forces.
struct PilePart {
  explicit PilePart(Lattice lattice_) : lattice(lattice_) {}

  Lattice lattice;  ///< of the whole pile
  PileRange range;
  std::vector<double> V_R, V_L, H_R, H_L;
  std::vector<double> load;  ///< of all columns
  LoadLine load_line;
  double bead_weight = 0;

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, sample = 0;
};

inline PileView view_of(const PilePart& part) {
  return {part.lattice,   part.range,       part.V_R, part.V_L, part.H_R,  part.H_L,   part.load,
          part.load_line, part.bead_weight, part.mu,  part.law, part.seed, part.sample};
}

}  // namespace granuscope
