// The formulas of equilibrium.h and of the pair rule in vectors, for one stream of repairs or two. A vector file of
// Highway: included once for every instruction set, so it has no ordinary include guard.
#if defined(GRANUSCOPE_REPAIR_ARITHMETIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef GRANUSCOPE_REPAIR_ARITHMETIC_INL_H
#undef GRANUSCOPE_REPAIR_ARITHMETIC_INL_H
#else
#define GRANUSCOPE_REPAIR_ARITHMETIC_INL_H
#endif

#include <hwy/highway.h>

#include <utility>

#include "model/equilibrium.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"

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

// The arithmetic of one stream of repairs (V) and of two that are worked on in turn, operation by operation (V2).
struct V2 {
  V first, second;
};
struct M2 {
  M first, second;
};

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

HWY_INLINE V2 operator+(V2 a, V2 b) { return {a.first + b.first, a.second + b.second}; }
HWY_INLINE V2 operator-(V2 a, V2 b) { return {a.first - b.first, a.second - b.second}; }
HWY_INLINE V2 operator*(V2 a, V2 b) { return {a.first * b.first, a.second * b.second}; }
HWY_INLINE V2 operator/(V2 a, V2 b) { return {a.first / b.first, a.second / b.second}; }

// NOLINTBEGIN(bugprone-macro-parentheses): the arguments are names
#define GRANUSCOPE_TWO_STREAMS_1(Result, name, Argument) \
  HWY_INLINE Result name(Argument a) { return {name(a.first), name(a.second)}; }
#define GRANUSCOPE_TWO_STREAMS_2(Result, name, Argument) \
  HWY_INLINE Result name(Argument a, Argument b) { return {name(a.first, b.first), name(a.second, b.second)}; }
// NOLINTEND(bugprone-macro-parentheses)
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

#include "model/equilibrium_formulas.inc"
#include "sampling/pair_formulas.inc"

/// The cone's constants, the same in every lane and stream.
template <class X>
class ConeOf {
 public:
  explicit HWY_INLINE ConeOf(const FrictionCone& cone)
      : tangent_(number<X>(cone.tangent())),
        cotangent_(number<X>(cone.cotangent())),
        t_minus_(number<X>(cone.t_minus())),
        t_plus_(number<X>(cone.t_plus())),
        t_minus_over_k_(number<X>(cone.t_minus_over_k())),
        t_plus_over_k_(number<X>(cone.t_plus_over_k())) {}
  HWY_INLINE X tangent() const { return tangent_; }
  HWY_INLINE X cotangent() const { return cotangent_; }
  HWY_INLINE X t_minus() const { return t_minus_; }
  HWY_INLINE X t_plus() const { return t_plus_; }
  HWY_INLINE X t_minus_over_k() const { return t_minus_over_k_; }
  HWY_INLINE X t_plus_over_k() const { return t_plus_over_k_; }

 private:
  X tangent_, cotangent_, t_minus_, t_plus_, t_minus_over_k_, t_plus_over_k_;
};

/// A bead under its load: what leaves it, and where its split may lie.
template <class X>
struct Bead {
  OutgoingOf<X> out;
  X H;
  IntervalOf<X> interval;
  HWY_INLINE auto unsolvable() const { return HWY_NAMESPACE::unsolvable(out, interval); }
};

template <class X>
HWY_INLINE Bead<X> bead_under(const ConeOf<X>& cone, IncomingOf<X> in) {
  const OutgoingOf<X> out = balance(cone, in);
  return {out, in.H, split_interval(cone, out, in.H)};
}

/// A parent of the beads around one that fails.
template <class X>
struct Parent {
  X V_R, V_L, H, H_R;
  HWY_INLINE IntervalOf<X> interval(const ConeOf<X>& cone) const {
    return split_interval(cone, OutgoingOf<X>{V_R, V_L}, H);
  }
};

/// What the pair rule may draw from for a bead below A and B: their splits, and the difference of the two.
template <class X>
struct PairRoom {
  using Mask = decltype(less(std::declval<X>(), std::declval<X>()));
  IntervalOf<X> a, b, band;
  X V_UL, V_UR;                ///< onto the bead, with its weight
  X behind_V_UL, behind_V_UR;  ///< onto the neighbour behind
  Mask out_of_band;            ///< by more than rounding
  Mask own_intervals;          ///< a parent whose own is empty by rounding is left to others
  Mask some_pair;
};

/// GranusolveRules::repair_by_pair for a bead, the neighbour behind which is solved and hangs below `outer` and A (if
/// it is the left one) or B; the neighbour ahead is not.
template <class X, class BySide>
HWY_INLINE PairRoom<X> room_for_pair(const ConeOf<X>& cone, const Parent<X>& A, const Parent<X>& B,
                                     const Parent<X>& outer, X half_weight, BySide by_side) {
  const X V_UL = A.V_R + half_weight, V_UR = B.V_L + half_weight;
  const auto out_of_band = misses_band(cone, IncomingOf<X>{V_UL, V_UR, A.H_R + (B.H - B.H_R)});
  IntervalOf<X> a = A.interval(cone), b = B.interval(cone);
  const auto own_intervals = negation(either(a.empty(), b.empty()));
  const X behind_V_UL = by_side(outer.V_R, B.V_R) + half_weight;
  const X behind_V_UR = by_side(A.V_L, outer.V_L) + half_weight;
  const IntervalOf<X> hold = solvable_band(cone, behind_V_UL, behind_V_UR) - by_side(A.H, outer.H);
  const IntervalOf<X> held_a = intersection(a, outer.H_R - hold), held_b = intersection(b, outer.H_R + hold);
  a = {by_side(held_a.low, a.low), by_side(held_a.high, a.high)};
  b = {by_side(b.low, held_b.low), by_side(b.high, held_b.high)};
  const IntervalOf<X> band = solvable_band(cone, V_UL, V_UR) - B.H;
  const auto some_pair = negation(either(either(a.empty(), b.empty()), intersection(band, a - b).empty()));
  return {a, b, band, V_UL, V_UR, behind_V_UL, behind_V_UR, out_of_band, own_intervals, some_pair};
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#endif
