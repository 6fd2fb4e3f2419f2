#pragma once
#include <array>
#include <functional>
#include <vector>

namespace granuscope::test {

/// Forces entering four beads that stand on a ring: what a layer of four columns receives.
struct RingForces {
  std::array<double, 4> V_UL{}, V_UR{}, H{};
};

/// Means over the splits H_R of two layers, weighted, and what normalises them.
struct SplitMoments {
  static constexpr std::size_t per_layer = 14;  ///< <a_i>, <a_i^2>, <a_i a_{i+1}> for i = 0..3, <a_0 a_2>, <a_1 a_3>
  std::array<double, per_layer> upper{}, lower{};
};

/// Piles of four columns and two or three layers by quadrature, no random numbers: the density
///   prod over beads of length^-lambda
/// over all splits. The interval of every split of the layer above the last is divided into `cells`; with three layers
/// the top layer's splits are cells^4 evenly scattered points. In the last layer splits integrate to their lengths.
/// `redraws` = 0: that density. redraws = K > 0 (three layers, lambda = 1): the law that keeps the top layer for K
/// attempts at the two below it, and draws all three anew for each further attempt.
SplitMoments small_pile_moments(double mu, const std::array<double, 4>& load, int layers, double lambda, int cells,
                                int redraws = 0);

}  // namespace granuscope::test
