#pragma once
#include <algorithm>

#include "model/friction_cone.h"
#include "model/lattice.h"

namespace granuscope {

/// A closed interval; empty if low > high.
struct Interval {
  double low, high;
  bool empty() const { return low > high; }
};

inline Interval intersection(Interval a, Interval b) { return {std::max(a.low, b.low), std::min(a.high, b.high)}; }

/// The point at fraction `uniform` of [0, 1) of an interval; never beyond its end by rounding.
inline double point_at(Interval interval, double uniform) {
  return std::min(interval.low + uniform * (interval.high - interval.low), interval.high);
}

/// What enters one bead from above: vertical forces of the upper-left and upper-right contact, and the sum of both
/// horizontal forces. (Of the horizontal forces only the sum matters to the bead.)
struct Incoming {
  double V_UL, V_UR, H;
};

/// Vertical forces leaving a bead. Force and torque balance fix both; only the split of H is free:
///   V_R = V_UR + sqrt(3) H,   V_L = V_UL - sqrt(3) H,   H_R + H_L = H.
struct Outgoing {
  double V_R, V_L;
};

/// Whether a bead has no solution. A contact that is pulled (V < 0) leaves none; at tiny friction rounding can make the
/// ends of its interval equal, so that the interval alone does not tell.
inline bool unsolvable(Outgoing out, const Interval& interval) {
  return interval.empty() || out.V_R < 0 || out.V_L < 0;
}

inline Outgoing balance(Incoming in) {
  const double shift = sqrt3 * in.H;
  return {in.V_UR + shift, in.V_UL - shift};
}

/// Where H_R may lie so that both lower contacts stay inside Coulomb's cone:
///   [max(t- V_R, t- V_L + H), min(t+ V_R, t+ V_L + H)].
/// Not empty only if V_R, V_L >= 0 (for mu < sqrt 3).
inline Interval split_interval(const FrictionCone& cone, Outgoing out, double H) {
  return {std::max(cone.t_minus() * out.V_R, cone.t_minus() * out.V_L + H),
          std::min(cone.t_plus() * out.V_R, cone.t_plus() * out.V_L + H)};
}

/// The H for which a bead under V_UL, V_UR >= 0 has a solution; never empty:
///   max(-V_UR/sqrt3, -(t+ V_UR - t- V_UL)/k) <= H <= min(V_UL/sqrt3, (t+ V_UL - t- V_UR)/k).
inline Interval solvable_band(const FrictionCone& cone, double V_UL, double V_UR) {
  return {std::max(-V_UR * tan30, cone.t_minus_over_k() * V_UL - cone.t_plus_over_k() * V_UR),
          std::min(V_UL * tan30, cone.t_plus_over_k() * V_UL - cone.t_minus_over_k() * V_UR)};
}

}  // namespace granuscope
