#pragma once
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "model/lattice.h"
#include "model/pile.h"

/// Formulas for vectors must be inlined where the instruction set is known.
#define GRANUSCOPE_INLINE inline __attribute__((always_inline))

/// The arithmetic that formulas for every kind of number are written in, beside + - * /, for double.
/// Vectors have the same in sampling/repair_arithmetic-inl.h.
namespace granuscope::scalar {

template <class X>
GRANUSCOPE_INLINE X number(double value) {
  return value;
}

// Of equal numbers the first.
GRANUSCOPE_INLINE double larger(double a, double b) { return std::max(a, b); }
GRANUSCOPE_INLINE double smaller(double a, double b) { return std::min(a, b); }
GRANUSCOPE_INLINE double negative(double a) { return -a; }
GRANUSCOPE_INLINE double root(double a) { return std::sqrt(a); }
GRANUSCOPE_INLINE double magnitude(double a) { return std::abs(a); }
GRANUSCOPE_INLINE double choose(bool where, double yes, double no) { return where ? yes : no; }
GRANUSCOPE_INLINE bool less(double a, double b) { return a < b; }
GRANUSCOPE_INLINE bool at_most(double a, double b) { return a <= b; }
GRANUSCOPE_INLINE bool both(bool a, bool b) { return a && b; }
GRANUSCOPE_INLINE bool either(bool a, bool b) { return a || b; }
GRANUSCOPE_INLINE bool only(bool without, bool with) { return !without && with; }

}  // namespace granuscope::scalar

namespace granuscope {
namespace scalar {
#include "model/equilibrium_formulas.inc"
}  // namespace scalar

using Interval = scalar::IntervalOf<double>;
using Incoming = scalar::IncomingOf<double>;
using Outgoing = scalar::OutgoingOf<double>;
using scalar::balance;
using scalar::draw_bead;
using scalar::intersection;
using scalar::point_at;
using scalar::solvable_band;
using scalar::split_interval;
using scalar::unsolvable;

/// What enters a top bead: its load through two upper contacts, whose friction is the load's torque. With contacts like
/// gears, T_R + T_L = -(T_UL + T_UR) at every bead, or V_R - V_L = 2 sqrt(3) H - (V_UL - V_UR): a load through the
/// centres (offset 0) is borne by all layers alike, any other torque goes down with alternating sign. Of 30 degrees,
/// the only angle at which loads may lean or act beside the centres.
inline Incoming top_load(double load, const LoadLine& line) {
  const double half = load / 2, lean = sqrt3 * line.slope - 2 * line.offset;
  if (line.of_excess) {
    const double excess = half - 0.5;
    return {half + lean * excess, half - lean * excess, 2 * line.slope * excess};
  }
  return {half * (1 + lean), half * (1 - lean), line.slope * load};
}

inline Incoming with_weight(Incoming from_above, double half_weight) {
  return {from_above.V_UL + half_weight, from_above.V_UR + half_weight, from_above.H};
}

/// What enters a bead of a pile from its load or from the two beads above it, and half of its own weight with either: a
/// force through the centre, which bears no torque, acts on what leaves the bead as if both contacts brought a half.
inline Incoming incoming(const Pile& pile, int layer, int bead) {
  const double half_weight = pile.bead_weight / 2;
  if (layer == 0) {
    return with_weight(top_load(pile.load[static_cast<std::size_t>(bead)], pile.load_line), half_weight);
  }
  const Lattice& lattice = pile.lattice;
  const std::size_t a = lattice.index(layer - 1, lattice.upper_left(layer, bead));
  const std::size_t b = lattice.index(layer - 1, lattice.upper_right(layer, bead));
  return with_weight({pile.V_R[a], pile.V_L[b], pile.H_R[a] + pile.H_L[b]}, half_weight);
}

}  // namespace granuscope
