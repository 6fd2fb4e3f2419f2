#include "model/lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granuscope {
BeadGeometry::BeadGeometry(double degrees) {
  if (degrees == usual_angle) return;
  const double radians = degrees * std::numbers::pi / 180;
  angle = degrees;
  tangent = degrees == 45 ? 1 : std::tan(radians);
  cotangent = 1 / tangent;
  twice_sine = 2 * std::sin(radians);
  twice_cosine = 2 * std::cos(radians);
}

Problem find_problem(const LatticeSpec& spec) {
  if (spec.columns < fewest_columns) {
    return problem("columns",
                   "a lattice of {} is too narrow: around a ring of fewer than {} beads a bead is its own neighbour; "
                   "use {} columns or more",
                   how_many(spec.columns, "column"), fewest_columns, fewest_columns);
  }
  if (spec.layers < fewest_layers) {
    return problem("layers", "a lattice of {} layers holds no bead; use {} layer or more", spec.layers, fewest_layers);
  }
  if (!(spec.angle >= least_angle && spec.angle <= most_angle)) {
    return problem("angle", "contacts {} degrees from the vertical are no lattice of these contacts; give {} to {}",
                   spec.angle, least_angle, most_angle);
  }
  return {};
}

std::vector<Key> keys_of(LatticeSpec& spec) {
  return {
      make_key("lattice", "columns", "beads", "beads per layer, periodic in x; even or odd", spec.columns,
               KeyRange{}.within(fewest_columns, most_columns)),
      make_key("lattice", "layers", "layers",
               "layers computed; the lowest 20 of beads (5 of diluted ones) follow another law, since no failure below "
               "reaches up into them, and are not used",
               spec.layers, KeyRange{}.within(4, most_layers)),
      make_key(
          "lattice", "angle", "degrees",
          "of the contacts from the vertical; neighbours in a layer are 2 sin(angle) diameters apart. Below 30 degrees "
          "beads are discs cut at their sides, where they would overlap",
          spec.angle,
          KeyRange{.why = "above 60 degrees beads would touch those two layers down"}.within(least_angle, most_angle)),
  };
}

Lattice::Lattice(LatticeSpec spec) : spec_(spec), geometry_(spec.angle) { refuse(find_problem(spec)); }

double Lattice::x(int layer, int bead) const {
  const double x = bead - middle() + 0.5 * (layer % 2);
  // For an odd number of columns the last bead of an odd layer lies half a bead past the seam.
  return pitch() * (x >= 0.5 * columns() ? x - columns() : x);
}

FrictionCone::FrictionCone(double mu, const BeadGeometry& geometry)
    : mu_(mu), tangent_(geometry.tangent), cotangent_(geometry.cotangent) {
  if (!(mu >= 0 && mu < cotangent_)) {
    throw InputError(
        "friction coefficient {} is out of range: the law is defined for 0 <= mu < {} = {:.8g}, where the cone "
        "of admissible forces stays below the horizontal",
        mu, geometry.angle == usual_angle ? "sqrt(3)" : fmt::format("cot({} degrees)", geometry.angle), cotangent_);
  }
  t_minus_ = (tangent_ - mu) / (1 + mu * tangent_);
  t_plus_ = (tangent_ + mu) / (1 - mu * tangent_);
  k_ = cotangent_ * (t_minus_ + t_plus_) - 1;
  t_minus_over_k_ = t_minus_ / k_;
  t_plus_over_k_ = t_plus_ / k_;
}

double FrictionCone::mu_at_30() const {
  if (tangent_ == tan30) return mu_;
  const double stretch = tan30 / tangent_, low = stretch * t_minus_, high = stretch * t_plus_;
  return std::max((tan30 - low) / (1 + tan30 * low), (high - tan30) / (1 + tan30 * high));
}

}  // namespace granuscope
