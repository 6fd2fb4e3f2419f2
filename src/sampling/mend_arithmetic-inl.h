// The arithmetic of mends: equilibrium.h, the pair rule and truncated_pair.cc in vectors, for one stream of mends or
// two. A vector file of Highway: included once for every instruction set, so it has no ordinary include guard.
#if defined(GRANUSCOPE_MEND_ARITHMETIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GRANUSCOPE_MEND_ARITHMETIC_INL_H
#undef GRANUSCOPE_MEND_ARITHMETIC_INL_H
#else
#define GRANUSCOPE_MEND_ARITHMETIC_INL_H
#endif

#include <hwy/highway.h>

#include <limits>
#include <utility>

#include "model/friction_cone.h"
#include "model/lattice.h"
#include "sampling/pile_group.h"
#include "sampling/rounding.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, group_lanes>;
using WordTag = hn::RebindToUnsigned<Tag>;
using V = hn::Vec<Tag>;
using M = hn::Mask<Tag>;
using W = hn::Vec<WordTag>;
constexpr Tag d;
constexpr WordTag dw;
constexpr hn::Rebind<std::uint32_t, Tag> d32;

// The arithmetic of one stream of mends (V) and of two that are worked on in turn, operation by operation (V2).
struct V2 {
  V first, second;
};
struct M2 {
  M first, second;
};

HWY_INLINE V plus(V a, V b) { return hn::Add(a, b); }
HWY_INLINE V minus(V a, V b) { return hn::Sub(a, b); }
HWY_INLINE V times(V a, V b) { return hn::Mul(a, b); }
HWY_INLINE V over(V a, V b) { return hn::Div(a, b); }
HWY_INLINE V root(V a) { return hn::Sqrt(a); }
HWY_INLINE V magnitude(V a) { return hn::Abs(a); }
HWY_INLINE V negative(V a) { return hn::Neg(a); }
// std::max and std::min, bit for bit (of equal numbers the first): x86 vector maxima prefer the second.
HWY_INLINE V larger(V a, V b) {
#if HWY_ARCH_X86
  return hn::Max(b, a);
#else
  return hn::IfThenElse(hn::Lt(a, b), b, a);
#endif
}
HWY_INLINE V smaller(V a, V b) {
#if HWY_ARCH_X86
  return hn::Min(b, a);
#else
  return hn::IfThenElse(hn::Lt(b, a), b, a);
#endif
}
HWY_INLINE V choose(M where, V yes, V no) { return hn::IfThenElse(where, yes, no); }
HWY_INLINE M less(V a, V b) { return hn::Lt(a, b); }
HWY_INLINE M at_most(V a, V b) { return hn::Le(a, b); }
HWY_INLINE M both(M a, M b) { return hn::And(a, b); }
HWY_INLINE M either(M a, M b) { return hn::Or(a, b); }
HWY_INLINE M only(M without, M with) { return hn::AndNot(without, with); }
HWY_INLINE M negation(M a) { return hn::Not(a); }

// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are names
#define GRANUSCOPE_TWO_STREAMS_1(Result, name, Argument) \
  HWY_INLINE Result name(Argument a) { return {name(a.first), name(a.second)}; }
#define GRANUSCOPE_TWO_STREAMS_2(Result, name, Argument) \
  HWY_INLINE Result name(Argument a, Argument b) { return {name(a.first, b.first), name(a.second, b.second)}; }
// NOLINTEND(bugprone-macro-parentheses)
GRANUSCOPE_TWO_STREAMS_2(V2, plus, V2)
GRANUSCOPE_TWO_STREAMS_2(V2, minus, V2)
GRANUSCOPE_TWO_STREAMS_2(V2, times, V2)
GRANUSCOPE_TWO_STREAMS_2(V2, over, V2)
GRANUSCOPE_TWO_STREAMS_1(V2, root, V2)
GRANUSCOPE_TWO_STREAMS_1(V2, magnitude, V2)
GRANUSCOPE_TWO_STREAMS_1(V2, negative, V2)
GRANUSCOPE_TWO_STREAMS_2(V2, larger, V2)
GRANUSCOPE_TWO_STREAMS_2(V2, smaller, V2)
GRANUSCOPE_TWO_STREAMS_2(M2, less, V2)
GRANUSCOPE_TWO_STREAMS_2(M2, at_most, V2)
GRANUSCOPE_TWO_STREAMS_2(M2, both, M2)
GRANUSCOPE_TWO_STREAMS_2(M2, either, M2)
GRANUSCOPE_TWO_STREAMS_2(M2, only, M2)
GRANUSCOPE_TWO_STREAMS_1(M2, negation, M2)
#undef GRANUSCOPE_TWO_STREAMS_1
#undef GRANUSCOPE_TWO_STREAMS_2
HWY_INLINE V2 choose(M2 where, V2 yes, V2 no) {
  return {choose(where.first, yes.first, no.first), choose(where.second, yes.second, no.second)};
}

template <class X>
HWY_INLINE X number(double value);
template <>
HWY_INLINE V number<V>(double value) {
  return hn::Set(d, value);
}
template <>
HWY_INLINE V2 number<V2>(double value) {
  return {hn::Set(d, value), hn::Set(d, value)};
}

/// A bit for each lane.
HWY_INLINE unsigned bits_of(M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

/// std::clamp, for low <= high.
template <class X>
HWY_INLINE X clamped(X v, X low, X high) {
  return smaller(larger(v, low), high);
}

template <class X>
struct Range {
  X low, high;
  HWY_INLINE auto empty() const { return less(high, low); }
};

template <class X>
HWY_INLINE Range<X> intersection(Range<X> a, Range<X> b) {
  return {larger(a.low, b.low), smaller(a.high, b.high)};
}

template <class X>
HWY_INLINE X point_at(Range<X> range, X uniform) {
  return smaller(plus(range.low, times(uniform, minus(range.high, range.low))), range.high);
}

/// The cone's constants, the same in every lane and stream.
template <class X>
struct Cone {
  explicit HWY_INLINE Cone(const FrictionCone& cone)
      : t_minus(number<X>(cone.t_minus())),
        t_plus(number<X>(cone.t_plus())),
        t_minus_over_k(number<X>(cone.t_minus_over_k())),
        t_plus_over_k(number<X>(cone.t_plus_over_k())),
        root3(number<X>(sqrt3)),
        tan(number<X>(tan30)) {}
  X t_minus, t_plus, t_minus_over_k, t_plus_over_k, root3, tan;
};

template <class X>
HWY_INLINE Range<X> split_interval(const Cone<X>& cone, X V_R, X V_L, X H) {
  return {larger(times(cone.t_minus, V_R), plus(times(cone.t_minus, V_L), H)),
          smaller(times(cone.t_plus, V_R), plus(times(cone.t_plus, V_L), H))};
}

template <class X>
HWY_INLINE Range<X> solvable_band(const Cone<X>& cone, X V_UL, X V_UR) {
  return {
      larger(times(negative(V_UR), cone.tan), minus(times(cone.t_minus_over_k, V_UL), times(cone.t_plus_over_k, V_UR))),
      smaller(times(V_UL, cone.tan), minus(times(cone.t_plus_over_k, V_UL), times(cone.t_minus_over_k, V_UR)))};
}

/// A bead under its load: what leaves it, and where its split may lie.
template <class X>
struct Bead {
  X V_R, V_L, H;
  Range<X> interval;
  /// At tiny friction a contact that is pulled leaves an interval whose ends rounding makes equal.
  HWY_INLINE auto unsolvable() const { return either(interval.empty(), less(smaller(V_R, V_L), number<X>(0))); }
};

template <class X>
HWY_INLINE Bead<X> bead_under(const Cone<X>& cone, X V_UL, X V_UR, X H) {
  const X shift = times(cone.root3, H);
  const X V_R = plus(V_UR, shift), V_L = minus(V_UL, shift);
  return {V_R, V_L, H, split_interval(cone, V_R, V_L, H)};
}

/// A parent of the beads around one that fails.
template <class X>
struct Parent {
  X V_R, V_L, H, H_R;
};

/// What the pair rule may draw from for a bead below A and B: their splits, and the difference of the two.
template <class X>
struct PairRoom {
  using Mask = decltype(less(std::declval<X>(), std::declval<X>()));
  Range<X> a, b, band;
  X behind_V_UL, behind_V_UR;  ///< onto the neighbour behind
  Mask out_of_band;            ///< by more than rounding
  Mask own_intervals;          ///< a parent whose own is empty by rounding is left to others
  Mask some_pair;
};

/// GranusolveRules::mend_by_pair for a bead, the neighbour behind which is solved and hangs below `outer` and A (if
/// it is the left one) or B; the neighbour ahead is not.
template <class X, class BySide>
HWY_INLINE PairRoom<X> room_for_pair(const Cone<X>& cone, const Parent<X>& A, const Parent<X>& B,
                                     const Parent<X>& outer, BySide by_side) {
  // Whether it misses its band by more than rounding.
  const X H = plus(A.H_R, minus(B.H, B.H_R));
  const Range<X> solvable = solvable_band(cone, A.V_R, B.V_L);
  const X on_band = clamped(H, solvable.low, larger(solvable.low, solvable.high));
  const X allowance =
      times(number<X>(rounding_ulps * std::numeric_limits<double>::epsilon()), plus(plus(A.V_R, B.V_L), magnitude(H)));
  const auto out_of_band = less(allowance, magnitude(minus(H, on_band)));

  Range<X> a = split_interval(cone, A.V_R, A.V_L, A.H), b = split_interval(cone, B.V_R, B.V_L, B.H);
  const auto own_intervals = negation(either(a.empty(), b.empty()));
  const X behind_V_UL = by_side(outer.V_R, B.V_R), behind_V_UR = by_side(A.V_L, outer.V_L);
  const Range<X> hold = solvable_band(cone, behind_V_UL, behind_V_UR);
  const X H_between = by_side(A.H, outer.H);
  const X hold_low = minus(hold.low, H_between), hold_high = minus(hold.high, H_between);
  a = {by_side(larger(a.low, minus(outer.H_R, hold_high)), a.low),
       by_side(smaller(a.high, minus(outer.H_R, hold_low)), a.high)};
  b = {by_side(b.low, larger(b.low, plus(outer.H_R, hold_low))),
       by_side(b.high, smaller(b.high, plus(outer.H_R, hold_high)))};
  const Range<X> band{minus(solvable.low, B.H), minus(solvable.high, B.H)};
  const auto feasible = at_most(larger(band.low, minus(a.low, b.high)), smaller(band.high, minus(a.high, b.low)));
  const auto nonempty = negation(either(a.empty(), b.empty()));
  return {a, b, band, behind_V_UL, behind_V_UR, out_of_band, own_intervals, both(nonempty, feasible)};
}

template <class X, class Mask>
struct PairDraws {
  X a, b;
  Mask exists;
};

/// draw_truncated_pair (truncated_pair.cc), step by step, for polygons with an area.
template <class X>
HWY_INLINE auto draw_truncated_pairs(Range<X> A, Range<X> B, Range<X> D, X u_difference, X u_chord) {
  const X zero = number<X>(0), half = number<X>(0.5);
  const X corner1 = minus(A.low, B.low), corner2 = minus(A.high, B.high);
  const X lowest = minus(A.low, B.high), rise_end = smaller(corner1, corner2);
  const X fall_start = larger(corner1, corner2), highest = minus(A.high, B.low);
  const X low = larger(D.low, lowest), high = smaller(D.high, highest);
  const X plateau = smaller(minus(A.high, A.low), minus(B.high, B.low));
  const auto density = [&](X x) { return smaller(smaller(plateau, minus(x, lowest)), minus(highest, x)); };
  const X knot1 = clamped(rise_end, low, high), knot2 = clamped(fall_start, low, high);
  const X y0 = density(low), y1 = density(knot1), y2 = density(knot2), y3 = density(high);
  const X area1 = times(times(minus(knot1, low), plus(y0, y1)), half);
  const X area2 = times(times(minus(knot2, knot1), plus(y1, y2)), half);
  const X area3 = times(times(minus(high, knot2), plus(y2, y3)), half);
  const X area = plus(plus(area1, area2), area3);
  const auto exists = both(at_most(low, high), less(zero, area));

  // Which of the three pieces, then one root and one division for whichever it is.
  const X grown1 = times(u_difference, area), grown2 = minus(grown1, area1), grown3 = minus(grown2, area2);
  const auto rising = less(grown1, area1), flat = only(rising, less(grown2, area2));
  const auto pick = [&](X on_rise, X on_plateau, X on_fall) {
    return choose(rising, on_rise, choose(flat, on_plateau, on_fall));
  };
  const X grown = pick(grown1, grown2, grown3), y = pick(y0, y1, y2), twice = plus(grown, grown);
  const X square = times(y, y);
  const X under_root = larger(zero, choose(rising, plus(square, twice), minus(square, twice)));
  const X denominator = plus(y, choose(flat, y, root(under_root)));
  const X way = choose(less(zero, denominator), over(twice, denominator), zero);
  X difference = plus(pick(low, knot1, knot2), way);
  difference = clamped(difference, low, high);
  const X chord_low = larger(A.low, plus(B.low, difference)), chord_high = smaller(A.high, plus(B.high, difference));
  const X a = clamped(plus(chord_low, times(u_chord, minus(chord_high, chord_low))), A.low, A.high);
  return PairDraws<X, decltype(exists)>{a, clamped(minus(a, difference), B.low, B.high), exists};
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#endif
