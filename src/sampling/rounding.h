#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/equilibrium.h"

namespace granuscope {

/// An H that misses its solvable band by at most this many units in the last place of the forces summed is put onto the
/// band's end: the splits above were chosen inside the band, and only their rounding carried H out of it.
inline constexpr double rounding_ulps = 64;

/// The point of a bead's solvable band that is nearest to its H.
inline double nearest_solvable(const FrictionCone& cone, Incoming in) {
  const Interval band = solvable_band(cone, in.V_UL, in.V_UR);
  return std::clamp(in.H, band.low, std::max(band.low, band.high));
}

/// Whether a bead without solution is so by rounding only.
inline bool misses_by_rounding(const FrictionCone& cone, Incoming in) {
  return !(std::abs(in.H - nearest_solvable(cone, in)) >
           rounding_ulps * std::numeric_limits<double>::epsilon() * (in.V_UL + in.V_UR + std::abs(in.H)));
}

/// An interval that is empty by rounding only, as the point it stands for.
inline Interval closed(Interval interval) {
  if (!interval.empty()) return interval;
  const double middle = interval.low + (interval.high - interval.low) / 2;
  return {middle, middle};
}

}  // namespace granuscope
