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
  const auto add = [this](Contacts& contacts, Place place, double V, double h) {
    if (V == 0 && h == 0) return;
    V *= cone_.cotangent();
    contacts.changes.push_back({place, V, h});
    const auto keep_positive = [&](double of_V, double of_h) {  // the slack of_V V + of_h h
      const double grows = of_V * V + of_h * h, size = std::abs(grows);
      if (size < rounding * (std::abs(V) + std::abs(h))) return;
      (grows < 0 ? contacts.upwards : contacts.downwards).push_back({place, of_V / size, of_h / size});
    };
    keep_positive(-cone_.t_minus(), 1);
    keep_positive(cone_.t_plus(), -1);
  };
  Shape shape;
  for (int n = 0; n < around.layers(); ++n) {
    for (int i = 0; i < around.columns(); ++i) {
      const std::size_t k = around.index(n, i);
      const int right = (i - middle + around.columns()) % around.columns();
      const Place place{(n - centre) * around.columns() + right, right};
      add(shape.right, place, growth.V_R[k], growth.H_R[k]);
      add(shape.left, place, growth.V_L[k], -growth.H_L[k]);
    }
  }
  return shape;
}

bool BumpMoves::move(Pile& pile, const Shape& shape, int layer, int column, double u) const {
  const int columns = lattice_.columns(), wraps = columns - column, below = (lattice_.layers() - layer) * columns;
  const std::ptrdiff_t centre = static_cast<std::ptrdiff_t>(layer) * columns + column;
  const auto bead = [&](Place place) { return centre + place.index - (place.right < wraps ? 0 : columns); };
  const auto reach = [&](const std::vector<Bound>& bounds, const double* V, const double* H, double outwards) {
    double least = std::numeric_limits<double>::infinity();
    for (const Bound& bound : bounds) {
      if (bound.place.index >= below) break;
      const std::ptrdiff_t k = bead(bound.place);
      least = std::min(least, bound.of_V * V[k] + bound.of_h * (outwards * H[k]));
    }
    return least;
  };
  double *const V_R = pile.V_R.data(), *const V_L = pile.V_L.data();
  double *const H_R = pile.H_R.data(), *const H_L = pile.H_L.data();
  const Interval allowed{
      -std::min(reach(shape.right.downwards, V_R, H_R, 1), reach(shape.left.downwards, V_L, H_L, -1)),
      std::min(reach(shape.right.upwards, V_R, H_R, 1), reach(shape.left.upwards, V_L, H_L, -1))};
  if (!(allowed.low < allowed.high)) return false;  // as in a corner of the set
  const double t = point_at(allowed, u);
  const auto add = [&](const std::vector<Change>& changes, double* V, double* H, double outwards) {
    for (const Change& change : changes) {
      if (change.place.index >= below) break;
      const std::ptrdiff_t k = bead(change.place);
      V[k] += t * change.V;
      H[k] += t * (outwards * change.h);
    }
  };
  add(shape.right.changes, V_R, H_R, 1);
  add(shape.left.changes, V_L, H_L, -1);
  return true;
}

}  // namespace granuscope
