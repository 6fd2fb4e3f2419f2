#pragma once
#include <vector>

#include "analysis/jackknife.h"
#include "model/pile.h"

namespace granuscope {

/// How the thrust ratio of a row of beads goes with what the row happens to carry:
/// kappa = kappa(0) + by_slope h^2/2 + by_torque t^2/2, h = H/w and t the torque over w of so many beads, from the
/// fluctuations of uniformly loaded piles. In long rows it is what loads that lean, or act beside the centres, do to
/// it.
struct ThrustInBlocks {
  int beads = 0;
  Replicated by_slope, by_torque;
};

/// Sums over all rows of that length of which the parabola is the least squares. They add up.
class BlockRegression {
 public:
  explicit BlockRegression(int beads) : beads_(beads) {}
  int beads() const { return beads_; }
  /// The rows of one layer, as many as fit into it; as LayerFluctuations what torque is.
  void add(const Pile& pile, int layer);
  void add(const BlockRegression& other, double times = 1);
  double by_slope() const;
  double by_torque() const;

 private:
  /// Covariances of h^2/2, t^2/2 and the thrust ratio.
  struct Moments {
    double hh, ht, tt, h_thrust, t_thrust;
  };
  Moments moments() const;

  int beads_;
  double rows_ = 0;
  double sum_[3] = {}, products_[3][3] = {};  ///< of those three numbers
};

/// Of rows of one length, from the regressions over the piles of each block.
ThrustInBlocks thrust_in_blocks(const std::vector<BlockRegression>& blocks);

}  // namespace granuscope
