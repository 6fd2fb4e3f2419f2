#include "thrust_in_blocks.h"

#include "model/lattice.h"

namespace granuscope {

void BlockRegression::add(const Pile& pile, int layer) {
  const double sign = layer % 2 == 0 ? 1 : -1;
  for (int first = 0; first + beads_ <= pile.lattice.columns(); first += beads_) {
    double w = 0, H = 0, torque = 0, thrust = 0;
    for (int i = first; i < first + beads_; ++i) {
      const std::size_t at = pile.lattice.index(layer, i);
      w += pile.V_R[at] + pile.V_L[at];
      H += pile.H_R[at] + pile.H_L[at];
      torque += sign * (sqrt3 * (pile.H_R[at] + pile.H_L[at]) - pile.V_R[at] + pile.V_L[at]) / 2;
      thrust += sqrt3 * (pile.H_R[at] - pile.H_L[at]);
    }
    const double row[3] = {H * H / (2 * w * w), torque * torque / (2 * w * w), thrust / w};
    rows_ += 1;
    for (int a = 0; a < 3; ++a) {
      sum_[a] += row[a];
      for (int b = 0; b < 3; ++b) products_[a][b] += row[a] * row[b];
    }
  }
}

void BlockRegression::add(const BlockRegression& other, double times) {
  rows_ += times * other.rows_;
  for (int a = 0; a < 3; ++a) {
    sum_[a] += times * other.sum_[a];
    for (int b = 0; b < 3; ++b) products_[a][b] += times * other.products_[a][b];
  }
}

BlockRegression::Moments BlockRegression::moments() const {
  const auto covariance = [&](int a, int b) { return products_[a][b] / rows_ - sum_[a] / rows_ * (sum_[b] / rows_); };
  return {covariance(0, 0), covariance(0, 1), covariance(1, 1), covariance(0, 2), covariance(1, 2)};
}

double BlockRegression::by_slope() const {
  const Moments m = moments();
  return (m.h_thrust * m.tt - m.t_thrust * m.ht) / (m.hh * m.tt - m.ht * m.ht);
}

double BlockRegression::by_torque() const {
  const Moments m = moments();
  return (m.t_thrust * m.hh - m.h_thrust * m.ht) / (m.hh * m.tt - m.ht * m.ht);
}

ThrustInBlocks thrust_in_blocks(const std::vector<BlockRegression>& blocks) {
  BlockRegression all(blocks.front().beads());
  for (const BlockRegression& block : blocks) all.add(block);
  ThrustInBlocks result{all.beads(), {all.by_slope(), {}}, {all.by_torque(), {}}};
  for (const BlockRegression& block : blocks) {
    BlockRegression without = all;
    without.add(block, -1);
    result.by_slope.without_block.push_back(without.by_slope());
    result.by_torque.without_block.push_back(without.by_torque());
  }
  return result;
}

}  // namespace granuscope
