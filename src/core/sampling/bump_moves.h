#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/random_key.h"

namespace granuscope {
/// The null move of bead o: the change of 12 contacts by t that keeps every balance. l, r: its lower-left and
/// lower-right neighbour, products compose; what would lie below the last layer is left out:
///
///   H_R: +t of o, -t of l, -t of lr, +t of llr          H_L: -t of o, +t of r, +t of lr, -t of lrr
///   V_R: cot t (+ of r, - of l, - of lr, + of ll)       V_L: cot t (- of r, + of l, + of rr, - of lr)
struct NullMove {
  NullMove(const Lattice& lattice, int layer, int bead);

  std::size_t o, l, r, ll, lr, rr, llr, lrr;  ///< as indices; beads below the last layer stand for none
  int layers_below;                           ///< 0 to 3 of the three below the bead

  /// Adds the move to these forces; shift = cot(angle) t.
  void add_to(Pile& forces, double t, double shift) const;
};

/// Moves of the chain at lambda = 0 along bumps of all sizes.
///
/// A bump of radius r (a whole number) is the sum of the null moves by (r - d) t of all beads o nearer than r to its
/// centre, d being how many steps from neighbour to neighbour lead to o: the amounts form a pyramid on a hexagon. Null
/// moves by amounts that are linear in the place of o add up to nothing, so that only the contacts along the edges
/// change, some 24 r of them. Balances hold since those of null moves do. t is drawn uniformly on the whole interval
/// that the cones of the changed contacts allow, which leaves the flat measure as it is. A bump may stand at the bottom
/// with only its upper part in the pile, and no bead of it lies above the top layer.
///
/// The radii are (columns - 4)/2, at most the number of layers, and its halves down to 4; a ring of fewer than 12 beads
/// has no bumps. The narrowest of some 24 r contacts bounds a bump, so that it moves a wave of its length by 1/r of
/// what that fluctuates: r^2 bumps at each place let it decay. With centres sqrt(r) apart that takes about r sweeps;
/// null moves take r^4.
class BumpMoves {
 public:
  BumpMoves(const FrictionCone& cone, const Lattice& lattice);

  /// Whether there is a bump on this lattice.
  static bool fit(const Lattice& lattice) { return largest_radius(lattice) >= least_radius; }

  struct Counts {
    std::uint64_t moves = 0, accepted = 0;
  };
  /// For each radius one bump at each place of a grid that is shifted at random. Uniforms(scale, number) returns a pair
  /// of numbers in [0, 1): number 0 shifts the grid, down and to the right; the first of the others are for the bumps.
  template <class Uniforms>
  Counts sweep(Pile& pile, const Uniforms& uniforms) const {
    Counts counts;
    const int columns = lattice_.columns();
    for (std::size_t s = 0; s < scales_.size(); ++s) {
      const Scale& scale = scales_[s];
      const int here = static_cast<int>(s);
      const UniformPair shift = uniforms(here, 0);
      const int right = static_cast<int>(shift.second * columns);
      int number = 0;
      for (int layer = scale.highest + static_cast<int>(shift.first * scale.step); layer <= scale.lowest;
           layer += scale.step) {
        for (int k = 0; k < scale.around_ring; ++k) {
          const int column = (right + k * columns / scale.around_ring) % columns;
          ++counts.moves;
          counts.accepted +=
              move(pile, scale.shapes[layer % 2 == 0 ? 0 : 1], layer, column, uniforms(here, ++number).first);
        }
      }
    }
    return counts;
  }

 private:
  static constexpr int least_radius = 4;
  static int largest_radius(const Lattice& lattice) { return std::min((lattice.columns() - 4) / 2, lattice.layers()); }

  /// A bead so many columns to the right of the centre, around the ring; index: what it has above the centre's, with no
  /// regard to the ring's end.
  struct Place {
    int index, right;
  };
  /// Right or left contacts that change alike, from the top down.
  struct Edge {
    bool right;
    double V, H;                ///< growth of their forces at t = 1
    double per_low, per_high;   ///< 1/(growth of h - t- V and of t+ V - h), h being outwards; 0 where neither grows
    std::vector<Place> places;  ///< of their beads
  };
  using Shape = std::vector<Edge>;
  struct Scale {
    std::array<Shape, 2> shapes;  ///< for centres in even and in odd layers
    int highest, lowest;          ///< layers where centres may lie, some of them below the last one
    int step, around_ring;        ///< of the grid: layers between its rows, centres in each
  };

  Shape shape(int radius, int parity) const;
  bool move(Pile& pile, const Shape& shape, int layer, int column, double u) const;

  FrictionCone cone_;
  Lattice lattice_;
  std::vector<Scale> scales_;
};

}  // namespace granuscope
