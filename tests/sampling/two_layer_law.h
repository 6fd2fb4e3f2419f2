#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "ring_quadrature.h"

namespace granuscope::test {

/// Moments of the four splits H_R of the top layer of a pile of 4 columns and 2 layers, once the lower layer is solved.
struct TwoLayerMoments {
  std::array<double, 4> mean{}, square{}, with_next{};  ///< <a_i>, <a_i^2>, <a_i a_{i+1}>
  std::array<double, 2> across{};                       ///< <a_i a_{i+2}>
  double lost = 0;  ///< probability that a pair finds nothing: the law would go on with a ring, which is not done here
};

/// The law "granusolve" on 4 columns and 2 layers by enumeration: the joint distribution of the four splits on a grid
/// of cells^4, sent through first draw, pair and ring for each of the eight orders of the lower layer. No random
/// numbers. On 4 columns there is no arc, and a two-layer pile has at least the frictionless solution, so that nothing
/// backtracks.
class TwoLayerLaw {
 public:
  TwoLayerLaw(double mu, const std::array<double, 4>& load, int cells, double angle = 30);
  /// The same for a layer that stands lower and receives any forces.
  TwoLayerLaw(double mu, const RingForces& received, int cells, double angle = 30);
  /// A bead of the upper layer has no interval: the splits above it were not admissible.
  bool solvable() const;
  TwoLayerMoments moments();

  /// Splits of the upper layer, one set for each cell that has a share of the distribution, admissible for both layers,
  /// with that share. After moments().
  struct State {
    std::array<double, 4> splits;
    double share;
  };
  std::vector<State> states() const;
  /// What the lower layer receives from such splits: bead j from those of j and j + 1.
  RingForces below(const std::array<double, 4>& splits) const;

 private:
  struct Range {
    double low, high;
  };
  std::size_t at(const std::array<int, 4>& cell) const {
    return ((static_cast<std::size_t>(cell[0]) * n_ + static_cast<std::size_t>(cell[1])) * n_ +
            static_cast<std::size_t>(cell[2])) *
               n_ +
           static_cast<std::size_t>(cell[3]);
  }
  double centre(int parent, int cell) const;
  /// Share of the cells x of parent j and y of parent j + 1 where lower bead j is solvable.
  double share(int bead, int x, int y) const {
    return share_[static_cast<std::size_t>(bead)][static_cast<std::size_t>(x) * n_ + static_cast<std::size_t>(y)];
  }
  void solve_bead(int bead, const std::array<bool, 4>& solved);
  void add_moments(TwoLayerMoments& moments, double weight) const;

  bool admits(const std::array<double, 4>& splits) const;

  double right_of(const RingForces& received, std::size_t i) const { return received.V_UR[i] + received.H[i] / tan_; }
  double left_of(const RingForces& received, std::size_t i) const { return received.V_UL[i] - received.H[i] / tan_; }

  std::size_t n_;
  int cells_;
  double tan_;  ///< of the contacts' angle
  RingForces received_;
  std::array<Range, 4> own_;   ///< of each upper bead's split
  std::array<Range, 4> band_;  ///< of a_j - a_{j+1}, for lower bead j
  std::array<std::vector<double>, 4> share_;
  std::vector<double> mass_;
  std::vector<double> mean_mass_;  ///< over the eight orders
  double lost_ = 0;
};

}  // namespace granuscope::test
