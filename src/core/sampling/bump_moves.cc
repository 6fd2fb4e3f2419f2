#include "sampling/bump_moves.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "model/equilibrium.h"

namespace granuscope {
NullMove::NullMove(const Lattice& lattice, int layer, int bead)
    : layers_below(std::min(3, lattice.layers() - 1 - layer)) {
  const int left = lattice.lower_left(layer, bead), right = lattice.lower_right(layer, bead);
  const auto at = [&](int down, int column) {
    return lattice.index(layer + (down <= layers_below ? down : 0), column);
  };
  o = at(0, bead);
  l = at(1, left);
  r = at(1, right);
  ll = at(2, lattice.previous(bead));
  lr = at(2, bead);
  rr = at(2, lattice.next(bead));
  llr = at(3, left);
  lrr = at(3, right);
}

void NullMove::add_to(Pile& forces, double t, double shift) const {
  forces.H_R[o] += t;
  forces.H_L[o] -= t;
  if (layers_below == 0) return;
  forces.H_R[l] -= t;
  forces.V_R[l] -= shift;
  forces.V_L[l] += shift;
  forces.H_L[r] += t;
  forces.V_L[r] -= shift;
  forces.V_R[r] += shift;
  if (layers_below == 1) return;
  forces.H_R[lr] -= t;
  forces.H_L[lr] += t;
  forces.V_R[lr] -= shift;
  forces.V_L[lr] -= shift;
  forces.V_R[ll] += shift;
  forces.V_L[rr] += shift;
  if (layers_below == 2) return;
  forces.H_R[llr] += t;
  forces.H_L[lrr] -= t;
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A slack that grows by less than this part of the forces does so by rounding only.
constexpr double rounding = 1e-13;

}  // namespace

BumpMoves::BumpMoves(const FrictionCone& cone, const Lattice& lattice) : cone_(cone), lattice_(lattice) {
  for (int r = largest_radius(lattice); r >= least_radius; r /= 2) {
    const int step = static_cast<int>(std::sqrt(r));
    scales_.push_back(
        {{shape(r, 0), shape(r, 1)}, r - 1, lattice.layers() - 1 + r - 1, step, lattice.columns() / step});
  }
}

BumpMoves::Shape BumpMoves::shape(int radius, int parity) const {
  const int centre = radius + (radius + parity) % 2, middle = lattice_.columns() / 2;
  const Lattice around({.columns = lattice_.columns(), .layers = centre + radius + 3});
  Pile growth(around);  // in whole numbers, V without its factor cot(angle): exactly 0 wherever it is
  for (int n = centre - radius + 1; n < centre + radius; ++n) {
    for (int i = 0; i < around.columns(); ++i) {
      const int rows = std::abs(n - centre), twice_right = std::abs(2 * (i - middle) + n % 2 - parity);
      const int amount = radius - std::max(rows, (twice_right + rows) / 2);
      if (amount > 0) NullMove(around, n, i).add_to(growth, amount, amount);
    }
  }
  const auto per_slack = [](double grows, double size) { return std::abs(grows) < rounding * size ? 0 : 1 / grows; };
  Shape shape;
  const auto add = [&](bool right, double V, double H, Place place) {
    if (V == 0 && H == 0) return;
    V *= cone_.cotangent();
    auto edge =
        std::ranges::find_if(shape, [&](const Edge& one) { return one.right == right && one.V == V && one.H == H; });
    if (edge == shape.end()) {
      const double h = right ? H : -H, size = std::abs(V) + std::abs(H);
      edge = shape.insert(
          edge, {right, V, H, per_slack(h - cone_.t_minus() * V, size), per_slack(cone_.t_plus() * V - h, size), {}});
    }
    edge->places.push_back(place);
  };
  for (int n = 0; n < around.layers(); ++n) {
    for (int i = 0; i < around.columns(); ++i) {
      const std::size_t k = around.index(n, i);
      const int right = (i - middle + around.columns()) % around.columns();
      const Place place{(n - centre) * around.columns() + right, right};
      add(true, growth.V_R[k], growth.H_R[k], place);
      add(false, growth.V_L[k], growth.H_L[k], place);
    }
  }
  return shape;
}

bool BumpMoves::move(Pile& pile, const Shape& shape, int layer, int column, double u) const {
  const int columns = lattice_.columns(), wraps = columns - column, below = (lattice_.layers() - layer) * columns;
  const std::ptrdiff_t centre = static_cast<std::ptrdiff_t>(layer) * columns + column;
  const auto for_each_bead = [&](const Edge& edge, const auto& f) {
    for (const Place& place : edge.places) {
      if (place.index >= below) break;
      f(centre + place.index - (place.right < wraps ? 0 : columns));
    }
  };
  const double t_minus = cone_.t_minus(), t_plus = cone_.t_plus();
  double up = infinity, down = infinity;
  const auto bound = [&](double slack, double per_slack) {
    if (per_slack < 0) up = std::min(up, -per_slack * slack);
    if (per_slack > 0) down = std::min(down, per_slack * slack);
  };
  for (const Edge& edge : shape) {
    const double *const V = (edge.right ? pile.V_R : pile.V_L).data(), *const H =
                                                                           (edge.right ? pile.H_R : pile.H_L).data();
    const double outwards = edge.right ? 1 : -1;
    double low = infinity, high = infinity;
    for_each_bead(edge, [&](std::ptrdiff_t k) {
      const double h = outwards * H[k];
      low = std::min(low, h - t_minus * V[k]);
      high = std::min(high, t_plus * V[k] - h);
    });
    bound(low, edge.per_low);
    bound(high, edge.per_high);
  }
  if (!(-down < up)) return false;  // as in a corner of the set
  const double t = point_at({-down, up}, u);
  for (const Edge& edge : shape) {
    double *const V = (edge.right ? pile.V_R : pile.V_L).data(), *const H = (edge.right ? pile.H_R : pile.H_L).data();
    const double of_V = t * edge.V, of_H = t * edge.H;
    for_each_bead(edge, [&](std::ptrdiff_t k) {
      V[k] += of_V;
      H[k] += of_H;
    });
  }
  return true;
}

}  // namespace granuscope
