#pragma once
#include <limits>

#include "model/equilibrium.h"

namespace granuscope {

/// An H that misses its solvable band by at most this many units in the last place of the forces summed is put onto the
/// band's end: the splits above were chosen inside the band, and only their rounding carried H out of it.
inline constexpr double rounding_ulps = 64;

namespace scalar {
#include "sampling/pair_formulas.inc"
}  // namespace scalar
using scalar::nearest_solvable;

/// Whether a bead without solution is so by rounding only.
inline bool misses_by_rounding(const FrictionCone& cone, Incoming in) { return !scalar::misses_band(cone, in); }

/// An interval that is empty by rounding only, as the point it stands for.
inline Interval closed(Interval interval) {
  if (!interval.empty()) return interval;
  const double middle = interval.low + (interval.high - interval.low) / 2;
  return {middle, middle};
}

}  // namespace granuscope
