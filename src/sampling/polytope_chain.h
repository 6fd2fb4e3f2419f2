#pragma once
#include <cstdint>
#include <vector>

#include "model/friction_cone.h"
#include "model/pile.h"
#include "sampling/random_key.h"

namespace granuscope {

/// A Markov chain on the admissible piles under one load, with density prod length^-lambda over all beads, length being
/// that of the interval of a bead's split. lambda = 0: every admissible pile alike; lambda = 1: the law "rejection".
///
/// The null move of bead o = (n, i) changes 12 contacts by t such that every balance still holds (l, r: its lower-left
/// and lower-right neighbour, products compose; what would lie below the last layer is left out):
///
///   H_R: +t of o, -t of l, -t of lr, +t of llr          H_L: -t of o, +t of r, +t of lr, -t of lrr
///   V_R: sqrt3 t (+ of r, - of l, - of lr, + of ll)     V_L: sqrt3 t (- of r, + of l, + of rr, - of lr)
///
/// t is drawn uniformly on the interval that the 12 cones allow, and accepted with prod (old/new length)^lambda over
/// the seven beads l, r, ll, lr, rr, llr, lrr. The ring move adds t to every H_R of a layer and takes it from every
/// H_L: no V, no total H and no length changes, so that it is always accepted. Without it the thrust of a layer is
/// slow.
class PolytopeChain {
 public:
  PolytopeChain(const FrictionCone& cone, const Lattice& lattice, double lambda);

  /// Starts, or goes on, from an admissible pile.
  void set(const Pile& pile);
  /// The forces, recomputed from the splits layer by layer so that the rounding of many moves does not add up. The
  /// chain itself goes on from them.
  void store(Pile& pile);

  /// One null move for each bead and one ring move for each layer. Uniform(layer, bead) returns a pair of numbers in
  /// [0, 1); `bead` = columns stands for the ring. `lambda` of this sweep: 0 leaves corners of vanishing length at
  /// once.
  template <class Uniforms>
  void sweep(const Uniforms& uniforms) {
    for (int layer = 0; layer < lattice_.layers(); ++layer) {
      for (int bead = 0; bead < lattice_.columns(); ++bead) null_move(layer, bead, uniforms(layer, bead));
      ring_move(layer, uniforms(layer, lattice_.columns()).first);
    }
  }
  void set_lambda(double lambda) { lambda_ = lambda; }

  const Pile& pile() const { return pile_; }
  std::uint64_t moves() const { return moves_; }
  std::uint64_t accepted_moves() const { return accepted_; }

 private:
  struct Contact {
    double V, h;  ///< h: the horizontal force outwards, H_R or -H_L
  };
  /// The beads that a null move reaches, as indices; layers below the last one hold no_bead.
  struct Neighbourhood {
    std::size_t o, l, r, ll, lr, rr, llr, lrr;
    int layers_below;  ///< 0 to 3 of the three below the bead
  };

  Neighbourhood around(int layer, int bead) const;
  void null_move(int layer, int bead, UniformPair u);
  void ring_move(int layer, double u);
  double length(double V_R, double V_L, double H) const;

  Contact right(std::size_t bead) const { return {pile_.V_R[bead], pile_.H_R[bead]}; }
  Contact left(std::size_t bead) const { return {pile_.V_L[bead], -pile_.H_L[bead]}; }

  FrictionCone cone_;
  Lattice lattice_;
  double lambda_;
  Pile pile_;
  std::vector<double> H_;       ///< total horizontal force entering each bead
  std::vector<double> length_;  ///< of each bead's interval
  // Reciprocal speeds at which the slack of a contact shrinks with t: see null_move.
  double per_V_low_, per_V_high_, per_both_low_, per_both_high_;
  std::uint64_t moves_ = 0, accepted_ = 0;
};

}  // namespace granuscope
