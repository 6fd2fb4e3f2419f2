#include "sampling/split_uniforms.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/friction_cone.h"
#include "model/incoming.h"

namespace granuscope {
namespace {

/// A split counts as kept within so many units in the last place of the forces that its interval is computed from: the
/// sampler's own rounding allowance (rounding.h), and as much again for the interval recomputed here.
constexpr double kept_ulps = 128;

struct BeadInterval {
  Interval interval;  ///< not empty
  double rounding;    ///< of its ends
};

BeadInterval interval_of(const FrictionCone& cone, const Pile& pile, int layer, int bead) {
  const Incoming in = incoming(pile, layer, bead);
  Interval interval = split_interval(cone, balance(in), in.H);
  const double scale = std::max({std::abs(interval.low), std::abs(interval.high), in.V_UL + in.V_UR, std::abs(in.H)});
  if (interval.empty()) interval.low = interval.high = interval.low + (interval.high - interval.low) / 2;
  return {interval, kept_ulps * std::numeric_limits<double>::epsilon() * scale};
}

template <typename Use>
void for_each_bead(const Lattice& lattice, Use use) {
  for (int layer = 0; layer < lattice.layers(); ++layer) {
    for (int bead = 0; bead < lattice.columns(); ++bead) use(layer, bead, lattice.index(layer, bead));
  }
}

double number_of(const BeadInterval& bead, double H_R) {
  const double length = bead.interval.high - bead.interval.low;
  return length > 0 ? std::clamp((H_R - bead.interval.low) / length, 0.0, 1.0) : 0.5;
}

}  // namespace

void read_split_uniforms(const Pile& pile, std::vector<double>& numbers) {
  numbers.resize(pile.lattice.beads());
  const FrictionCone cone(pile.mu);
  for_each_bead(pile.lattice, [&](int layer, int bead, std::size_t at) {
    numbers[at] = number_of(interval_of(cone, pile, layer, bead), pile.H_R[at]);
  });
}

void find_redrawn(const Pile& first, const Pile& again, std::vector<unsigned char>& redrawn) {
  redrawn.resize(first.lattice.beads());
  const FrictionCone cone(first.mu);
  for_each_bead(first.lattice, [&](int layer, int bead, std::size_t at) {
    const BeadInterval before = interval_of(cone, first, layer, bead), after = interval_of(cone, again, layer, bead);
    const double kept =
        kept_split(first, at, number_of(before, first.H_R[at]), {again.V_R[at], again.V_L[at]}, after.interval);
    redrawn[at] = std::abs(again.H_R[at] - kept) > after.rounding ? 1 : 0;
  });
}

}  // namespace granuscope
