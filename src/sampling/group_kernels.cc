#include "sampling/group_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/group_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include <bit>
#include <limits>

#include "model/lattice.h"
#include "sampling/philox-inl.h"
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
HWY_INLINE V clamped(V v, V low, V high) {
  return hn::IfThenElse(hn::Lt(v, low), low, hn::IfThenElse(hn::Lt(high, v), high, v));
}

struct Range {
  V low, high;
  HWY_INLINE M empty() const { return hn::Gt(low, high); }
};

HWY_INLINE Range intersection(Range a, Range b) { return {larger(a.low, b.low), smaller(a.high, b.high)}; }

HWY_INLINE V point_at(Range range, V uniform) {
  return smaller(hn::Add(range.low, hn::Mul(uniform, hn::Sub(range.high, range.low))), range.high);
}

struct Cone {
  V t_minus, t_plus, t_minus_over_k, t_plus_over_k, root3, tan;
};

HWY_INLINE Range split_interval(const Cone& cone, V V_R, V V_L, V H) {
  return {larger(hn::Mul(cone.t_minus, V_R), hn::Add(hn::Mul(cone.t_minus, V_L), H)),
          smaller(hn::Mul(cone.t_plus, V_R), hn::Add(hn::Mul(cone.t_plus, V_L), H))};
}

HWY_INLINE Range solvable_band(const Cone& cone, V V_UL, V V_UR) {
  return {
      larger(hn::Mul(hn::Neg(V_UR), cone.tan),
             hn::Sub(hn::Mul(cone.t_minus_over_k, V_UL), hn::Mul(cone.t_plus_over_k, V_UR))),
      smaller(hn::Mul(V_UL, cone.tan), hn::Sub(hn::Mul(cone.t_plus_over_k, V_UL), hn::Mul(cone.t_minus_over_k, V_UR)))};
}

/// A bead under its load: what leaves it, and where its split may lie.
struct Bead {
  V V_R, V_L, H;
  Range interval;
};

HWY_INLINE Bead bead_under(const Cone& cone, V V_UL, V V_UR, V H) {
  const V shift = hn::Mul(cone.root3, H);
  const V V_R = hn::Add(V_UR, shift), V_L = hn::Sub(V_UL, shift);
  return {V_R, V_L, H, split_interval(cone, V_R, V_L, H)};
}

using Uniforms = LaneUniforms<Tag>;

/// The stream of later attempts.
HWY_INLINE Uniforms later_attempt(const GroupFront& front, std::size_t bead, W sample, W attempt) {
  return philox_uniforms(dw, front.keys, hn::Set(dw, static_cast<std::uint64_t>(bead)),
                         hn::Set(dw, static_cast<std::uint64_t>(static_cast<std::uint32_t>(front.layer))), sample,
                         hn::Or(hn::ShiftLeft<8>(attempt), hn::Set(dw, std::uint64_t{1})));
}

struct PairDraws {
  V a, b;
  M exists;
};

/// draw_truncated_pair (truncated_pair.cc), step by step, for polygons with an area.
HWY_INLINE PairDraws draw_truncated_pairs(Range A, Range B, Range D, V u_difference, V u_chord) {
  const V zero = hn::Zero(d), one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
  const V corner1 = hn::Sub(A.low, B.low), corner2 = hn::Sub(A.high, B.high);
  const V lowest = hn::Sub(A.low, B.high), rise_end = smaller(corner1, corner2);
  const V fall_start = larger(corner1, corner2), highest = hn::Sub(A.high, B.low);
  const V low = larger(D.low, lowest), high = smaller(D.high, highest);
  const V plateau = smaller(hn::Sub(A.high, A.low), hn::Sub(B.high, B.low));
  const auto density = [&](V x) {
    return larger(zero, smaller(smaller(plateau, hn::Sub(x, lowest)), hn::Sub(highest, x)));
  };
  const V knot1 = clamped(rise_end, low, high), knot2 = clamped(fall_start, low, high);
  const V y0 = density(low), y1 = density(knot1), y2 = density(knot2), y3 = density(high);
  const V area1 = hn::Mul(hn::Mul(hn::Sub(knot1, low), hn::Add(y0, y1)), half);
  const V area2 = hn::Mul(hn::Mul(hn::Sub(knot2, knot1), hn::Add(y1, y2)), half);
  const V area3 = hn::Mul(hn::Mul(hn::Sub(high, knot2), hn::Add(y2, y3)), half);
  const V area = hn::Add(hn::Add(area1, area2), area3);
  const M exists = hn::And(hn::Le(low, high), hn::Gt(area, zero));

  // Which of the three pieces, then one division and one root for whichever it is.
  const V share1 = hn::Mul(u_difference, area), share2 = hn::Sub(share1, area1), share3 = hn::Sub(share2, area2);
  const M rising = hn::Lt(share1, area1), flat = hn::AndNot(rising, hn::Lt(share2, area2));
  const M falling = hn::Not(hn::Or(rising, flat));
  const auto pick = [&](V on_rise, V on_plateau, V on_fall) {
    return hn::IfThenElse(rising, on_rise, hn::IfThenElse(flat, on_plateau, on_fall));
  };
  V share = hn::Div(pick(share1, share2, share3), pick(area1, area2, area3));
  share = hn::IfThenElse(falling, hn::IfThenElse(hn::Gt(area3, zero), smaller(one, share), zero), share);
  const V from = pick(y0, y1, y2), to = pick(y1, y2, y3);
  const V target = hn::Mul(share, hn::Add(from, to));
  const V root = hn::Sqrt(larger(zero, hn::Add(hn::Mul(from, from), hn::Mul(hn::Sub(to, from), target))));
  const V denominator = hn::Add(from, root);
  const V inverted = hn::IfThenElse(hn::Gt(denominator, zero), smaller(one, hn::Div(target, denominator)), share);
  const V length = pick(hn::Sub(knot1, low), hn::Sub(knot2, knot1), hn::Sub(high, knot2));
  V difference = hn::Add(pick(low, knot1, knot2), hn::Mul(length, hn::IfThenElse(flat, share, inverted)));
  difference = clamped(difference, low, high);
  const V chord_low = larger(A.low, hn::Add(B.low, difference)),
          chord_high = smaller(A.high, hn::Add(B.high, difference));
  const V a = clamped(hn::Add(chord_low, hn::Mul(u_chord, hn::Sub(chord_high, chord_low))), A.low, A.high);
  return {a, clamped(hn::Sub(a, difference), B.low, B.high), exists};
}

/// Attempts of a bead, as the random numbers need them.
struct Attempts {
  std::uint32_t* at;
  W count;
  HWY_INLINE explicit Attempts(std::uint32_t* from) : at(from), count(hn::PromoteTo(dw, hn::Load(d32, from))) {}
  HWY_INLINE W after(std::uint64_t more) const { return hn::Add(count, hn::Set(dw, more)); }
  HWY_INLINE void add(std::uint64_t more, M where) const {
    hn::Store(hn::TruncateTo(d32, hn::Add(count, hn::IfThenElseZero(hn::RebindMask(dw, where), hn::Set(dw, more)))),
              d32, at);
  }
};

HWY_INLINE void keep(const Bead& bead, V uniform, M where, const GroupRow& row, std::size_t at) {
  const V H_R = point_at(bead.interval, uniform);
  hn::BlendedStore(bead.V_R, where, d, row.V_R + at);
  hn::BlendedStore(bead.V_L, where, d, row.V_L + at);
  hn::BlendedStore(bead.H, where, d, row.H + at);
  hn::BlendedStore(H_R, where, d, row.H_R + at);
  hn::BlendedStore(hn::Sub(bead.H, H_R), where, d, row.H_L + at);
}

HWY_INLINE void count(LaneWords& words, std::size_t k, std::uint64_t more, M where) {
  std::uint64_t* const at = words.data() + k;
  hn::Store(hn::Add(hn::Load(dw, at), hn::IfThenElseZero(hn::RebindMask(dw, where), hn::Set(dw, more))), dw, at);
}

HWY_INLINE unsigned bits_of(M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0];
}

/// The piles from lane `k` on; `lanes` holds their bits. Returns those left over, and those mended by the pair rule.
HWY_INLINE unsigned mend_lanes(const Cone& cone, GroupFront& front, const GroupBead& at, std::size_t k, unsigned lanes,
                               unsigned& mended_lanes) {
  const std::uint8_t lane_bits[8] = {static_cast<std::uint8_t>(lanes)};
  const M active = hn::LoadMaskBits(d, lane_bits);
  const GroupRow &above = front.above, &here = front.here;
  const auto place = [&](std::size_t bead) { return bead * group_lanes + k; };
  const auto load = [&](const double* row, std::size_t bead) { return hn::Load(d, row + place(bead)); };
  const V A_V_R = load(above.V_R, at.A), B_V_L = load(above.V_L, at.B);

  // As it is.
  const Bead as_is = bead_under(cone, A_V_R, B_V_L, hn::Add(load(above.H_R, at.A), load(above.H_L, at.B)));
  const M drawn = hn::AndNot(as_is.interval.empty(), active);
  keep(as_is, load(front.first_uniform, at.bead), drawn, here, place(at.bead));
  count(front.met, k, 1, active);
  const M open = hn::AndNot(drawn, active);
  if (hn::AllFalse(d, open)) return 0;

  const Range solvable = solvable_band(cone, A_V_R, B_V_L);
  const V on_band = clamped(as_is.H, solvable.low, larger(solvable.low, solvable.high));
  const V allowance = hn::Mul(hn::Set(d, rounding_ulps * std::numeric_limits<double>::epsilon()),
                              hn::Add(hn::Add(A_V_R, B_V_L), hn::Abs(as_is.H)));
  const M failing = hn::Gt(hn::Abs(hn::Sub(as_is.H, on_band)), allowance);

  // The pair rule.
  const V A_V_L = load(above.V_L, at.A), B_V_R = load(above.V_R, at.B);
  const V A_H = load(above.H, at.A), B_H = load(above.H, at.B);
  // A parent whose own interval is empty by rounding is left over with the rest.
  Range a = split_interval(cone, A_V_R, A_V_L, A_H), b = split_interval(cone, B_V_R, B_V_L, B_H);
  V P_V_R = A_V_R, P_H_R = A_H, Q_V_L = B_V_L, Q_H_L = B_H;  // read only where the neighbour below is solved
  if (at.left_solved) {
    P_V_R = load(above.V_R, at.P);
    P_H_R = load(above.H_R, at.P);
    const Range band = solvable_band(cone, P_V_R, A_V_L);
    a = intersection(a, {hn::Sub(P_H_R, hn::Sub(band.high, A_H)), hn::Sub(P_H_R, hn::Sub(band.low, A_H))});
  }
  if (at.right_solved) {
    const V Q_H = load(above.H, at.Q), Q_H_R = load(above.H_R, at.Q);
    Q_V_L = load(above.V_L, at.Q);
    Q_H_L = load(above.H_L, at.Q);
    const Range band = solvable_band(cone, B_V_R, Q_V_L);
    b = intersection(b, {hn::Add(Q_H_R, hn::Sub(band.low, Q_H)), hn::Add(Q_H_R, hn::Sub(band.high, Q_H))});
  }
  const Range band{hn::Sub(solvable.low, B_H), hn::Sub(solvable.high, B_H)};
  const M feasible = hn::Le(larger(band.low, hn::Sub(a.low, b.high)), smaller(band.high, hn::Sub(a.high, b.low)));
  const M nonempty = hn::Not(hn::Or(a.empty(), b.empty()));

  const W sample = hn::Load(dw, front.sample.data() + k);
  const Attempts tries(front.attempts + place(at.bead));
  const Uniforms u = later_attempt(front, at.bead, sample, tries.after(1));
  const PairDraws pair = draw_truncated_pairs(a, b, band, u.first, u.second);
  const V A_H_L = hn::Sub(A_H, pair.a), B_H_L = hn::Sub(B_H, pair.b);
  const Bead self = bead_under(cone, A_V_R, B_V_L, hn::Add(pair.a, B_H_L));
  // A neighbour or the bead itself whose interval is empty after all is so by rounding, which is not settled here.
  M mended = hn::And(hn::And(open, failing), hn::And(nonempty, hn::And(feasible, pair.exists)));
  mended = hn::AndNot(self.interval.empty(), mended);
  const Bead left = bead_under(cone, P_V_R, A_V_L, hn::Add(P_H_R, A_H_L));
  const Bead right = bead_under(cone, B_V_R, Q_V_L, hn::Add(pair.b, Q_H_L));
  if (at.left_solved) mended = hn::AndNot(left.interval.empty(), mended);
  if (at.right_solved) mended = hn::AndNot(right.interval.empty(), mended);

  const Uniforms u_below = later_attempt(front, at.bead, sample, tries.after(2));
  keep(self, u_below.first, mended, here, place(at.bead));
  tries.add(2, mended);
  hn::BlendedStore(pair.a, mended, d, above.H_R + place(at.A));
  hn::BlendedStore(A_H_L, mended, d, above.H_L + place(at.A));
  hn::BlendedStore(pair.b, mended, d, above.H_R + place(at.B));
  hn::BlendedStore(B_H_L, mended, d, above.H_L + place(at.B));
  // The second number goes to the solved neighbour; if both are solved, to the left one.
  if (at.left_solved) keep(left, u_below.second, mended, here, place(at.left));
  if (at.right_solved && !at.left_solved) keep(right, u_below.second, mended, here, place(at.right));
  if (at.right_solved && at.left_solved) {
    const Attempts before(front.attempts + place(at.right));
    keep(right, later_attempt(front, at.right, sample, before.after(1)).first, mended, here, place(at.right));
    before.add(1, mended);
  }
  count(front.pairs, k, 1, mended);
  if (at.left_solved != at.right_solved) {
    count(front.renewed, k, 1, mended);
  } else if (at.left_solved) {
    count(front.renewed, k, 2, mended);
  }
  mended_lanes = bits_of(mended);
  return bits_of(hn::AndNot(mended, open));
}

unsigned MendBeads(const FrictionCone& cone, GroupFront& front, const GroupBead& bead, unsigned lanes) {
  const Cone broadcast{hn::Set(d, cone.t_minus()),       hn::Set(d, cone.t_plus()), hn::Set(d, cone.t_minus_over_k()),
                       hn::Set(d, cone.t_plus_over_k()), hn::Set(d, sqrt3),         hn::Set(d, tan30)};
  constexpr unsigned all = (1U << group_lanes) - 1;
  unsigned left_over = 0, mended = 0;
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const unsigned some = lanes >> k & ((1U << hn::Lanes(d)) - 1) & all;
    if (some == 0) continue;
    unsigned mended_here = 0;
    left_over |= mend_lanes(broadcast, front, bead, k, some, mended_here) << k;
    mended |= mended_here << k;
  }
  for (unsigned rest = mended; rest != 0; rest &= rest - 1) {
    front.rule[bead.bead * group_lanes + static_cast<unsigned>(std::countr_zero(rest))] = front.mended_rule;
  }
  // Neighbours whose turn has not come forget what was drawn for them.
  if (!bead.left_solved) front.failing[bead.left] = static_cast<std::uint8_t>(front.failing[bead.left] | mended);
  if (!bead.right_solved) front.failing[bead.right] = static_cast<std::uint8_t>(front.failing[bead.right] | mended);
  return left_over;
}

void FillGroupUniforms(const PhiloxKeys& keys, const LaneWords& sample, int layer, double* HWY_RESTRICT uniforms,
                       std::size_t beads) {
  const W layers = hn::Set(dw, static_cast<std::uint64_t>(static_cast<std::uint32_t>(layer)));
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const W samples = hn::Load(dw, sample.data() + k);
    for (std::size_t bead = 0; bead < beads; bead += 2) {
      const Uniforms u =
          philox_uniforms(dw, keys, hn::Set(dw, static_cast<std::uint64_t>(bead / 2)), layers, samples, hn::Zero(dw));
      hn::Store(u.first, d, uniforms + bead * group_lanes + k);
      hn::Store(u.second, d, uniforms + (bead + 1) * group_lanes + k);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace granuscope {

HWY_EXPORT(MendBeads);
HWY_EXPORT(FillGroupUniforms);

unsigned mend_beads(const FrictionCone& cone, GroupFront& front, const GroupBead& bead, unsigned lanes) {
  return HWY_DYNAMIC_DISPATCH(MendBeads)(cone, front, bead, lanes);
}

void fill_group_uniforms(const PhiloxKeys& keys, const LaneWords& sample, int layer, double* uniforms,
                         std::size_t beads) {
  HWY_DYNAMIC_DISPATCH(FillGroupUniforms)(keys, sample, layer, uniforms, beads);
}

}  // namespace granuscope
#endif
