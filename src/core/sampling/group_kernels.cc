#include "sampling/group_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/group_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "sampling/philox-inl.h"
#include "sampling/repair_arithmetic-inl.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// What a repair needs of a stream's memory: vectors of the piles from lane `k` on.
struct Stream {
  GroupFront& front;
  const GroupBead& at;
  std::size_t k;
  unsigned lanes;  ///< of these piles

  std::size_t place(std::size_t bead) const { return bead * group_lanes + k; }
  HWY_INLINE V load(const double* row, std::size_t bead) const { return hn::Load(d, row + place(bead)); }
  HWY_INLINE M active() const {
    const std::uint8_t bits[8] = {static_cast<std::uint8_t>(lanes)};
    return hn::LoadMaskBits(d, bits);
  }
  /// The bead's attempts so far, and the numbers of the next one.
  HWY_INLINE W attempts() const { return hn::PromoteTo(dw, hn::Load(d32, front.attempts + place(at.bead))); }
  HWY_INLINE LaneUniforms<Tag> later_attempt() const {
    const W attempt = hn::Add(attempts(), hn::Set(dw, std::uint64_t{1}));
    return philox_uniforms(dw, front.keys, hn::Set(dw, static_cast<std::uint64_t>(at.bead)),
                           hn::Set(dw, static_cast<std::uint64_t>(static_cast<std::uint32_t>(front.layer))),
                           hn::Load(dw, front.sample.data() + k),
                           hn::Or(hn::ShiftLeft<8>(attempt), hn::Set(dw, std::uint64_t{later_attempt_stream})));
  }
  HWY_INLINE void keep(const Bead<V>& bead, M where, std::size_t number) const {
    const V H_R = point_at(bead.interval, load(front.first_uniform, number));
    const std::size_t to = place(number);
    hn::BlendedStore(bead.out.V_R, where, d, front.here.V_R + to);
    hn::BlendedStore(bead.out.V_L, where, d, front.here.V_L + to);
    hn::BlendedStore(bead.H, where, d, front.here.H + to);
    hn::BlendedStore(H_R, where, d, front.here.H_R + to);
  }
  HWY_INLINE void set_parent(std::size_t parent, V H_R, M where) const {
    hn::BlendedStore(H_R, where, d, front.above.H_R + place(parent));
  }
  HWY_INLINE void count(LaneWords& words, M where) const {
    std::uint64_t* const to = words.data() + k;
    hn::Store(hn::Add(hn::Load(dw, to), hn::IfThenElseZero(hn::RebindMask(dw, where), hn::Set(dw, std::uint64_t{1}))),
              dw, to);
  }
  HWY_INLINE void add_attempts(M where) const {
    const W more = hn::IfThenElseZero(hn::RebindMask(dw, where), hn::Set(dw, std::uint64_t{1}));
    hn::Store(hn::TruncateTo(d32, hn::Add(attempts(), more)), d32, front.attempts + place(at.bead));
  }
};

constexpr std::uint64_t every_byte = 0x0101010101010101U;

/// Which piles of a stream were repaired, and which were left over.
struct Outcome {
  unsigned repaired = 0, left_over = 0;
  unsigned no_pair = 0;  ///< of those left over: the bead is out of its band, and no pair of splits brings it back
  /// Another one's, of the piles from lane k on.
  HWY_INLINE void add(const Outcome& other, std::size_t k) {
    repaired |= other.repaired << k;
    left_over |= other.left_over << k;
    no_pair |= other.no_pair << k;
  }
};

/// Two uniform numbers for each pile.
template <class X>
struct Numbers {
  X first, second;
};

/// One stream, its neighbour behind being the left one or not.
template <bool behind_is_left>
struct One {
  using X = V;
  Stream stream;
  template <class Of>
  HWY_INLINE auto all(Of of) const {
    return of(stream);
  }
  /// By the side of the neighbour behind.
  HWY_INLINE V by_side(V left, V right) const { return behind_is_left ? left : right; }
  HWY_INLINE Numbers<V> later_attempt() const {
    const LaneUniforms<Tag> u = stream.later_attempt();
    return {u.first, u.second};
  }
  template <class Do>
  HWY_INLINE void each(Do act) const {
    act(
        stream, [](const auto& value) { return value; }, std::size_t{0});
  }
};

template <bool first_is_left, bool second_is_left>
struct Two {
  using X = V2;
  Stream first, second;
  template <class Of>
  HWY_INLINE auto all(Of of) const {
    if constexpr (std::is_same_v<decltype(of(first)), V>) return V2{of(first), of(second)};
    if constexpr (std::is_same_v<decltype(of(first)), M>) return M2{of(first), of(second)};
  }
  HWY_INLINE V2 by_side(V2 left, V2 right) const {
    return {first_is_left ? left.first : right.first, second_is_left ? left.second : right.second};
  }
  HWY_INLINE Numbers<V2> later_attempt() const {
    const LaneUniforms<Tag> u = first.later_attempt(), v = second.later_attempt();
    return {{u.first, v.first}, {u.second, v.second}};
  }
  template <class Do>
  HWY_INLINE void each(Do act) const {
    act(
        first, [](const auto& value) { return value.first; }, std::size_t{0});
    act(
        second, [](const auto& value) { return value.second; }, std::size_t{1});
  }
};

/// The part of `bead` that belongs to one stream.
template <class X, class Part>
HWY_INLINE Bead<V> part_of(const Bead<X>& bead, Part part) {
  return {{part(bead.out.V_R), part(bead.out.V_L)}, part(bead.H), {part(bead.interval.low), part(bead.interval.high)}};
}

template <class Streams>
HWY_INLINE void repair_streams(const FrictionCone& friction, const Streams& streams, Outcome* outcomes) {
  using X = typename Streams::X;
  const ConeOf<X> cone(friction);
  const auto above = [&](double* GroupRow::*row, std::size_t GroupBead::*bead) {
    return streams.all([=](const Stream& s) { return s.load(s.front.above.*row, s.at.*bead); });
  };
  const auto parent = [&](std::size_t GroupBead::*bead) __attribute__((always_inline)) {
    return Parent<X>{above(&GroupRow::V_R, bead), above(&GroupRow::V_L, bead), above(&GroupRow::H, bead),
                     above(&GroupRow::H_R, bead)};
  };
  const Parent<X> A = parent(&GroupBead::A), B = parent(&GroupBead::B), outer = parent(&GroupBead::outer);
  const auto by_side = [&](X left, X right) __attribute__((always_inline)) { return streams.by_side(left, right); };
  const X half_weight = streams.all([](const Stream& s) { return hn::Set(d, s.front.half_weight); });
  const PairRoom<X> room = room_for_pair(cone, A, B, outer, half_weight, by_side);

  const Numbers<X> u = streams.later_attempt();
  const auto trapezoid = cut_trapezoid(room.a, room.b, room.band);
  const auto exists = both(at_most(trapezoid.low, trapezoid.high), less(number<X>(0), trapezoid.area));
  const X difference = clamped(difference_at(trapezoid, u.first), trapezoid.low, trapezoid.high);
  const PairOf<X> pair = pair_apart(room.a, room.b, difference, u.second);
  const X A_H_L = A.H - pair.a, B_H_L = B.H - pair.b;
  const Bead<X> self = bead_under<X>(cone, {room.V_UL, room.V_UR, pair.a + B_H_L});
  const X behind_H = streams.by_side(outer.H_R + A_H_L, pair.b + (outer.H - outer.H_R));
  const Bead<X> behind = bead_under<X>(cone, {room.behind_V_UL, room.behind_V_UR, behind_H});
  // A neighbour or the bead itself whose interval is empty after all is so by rounding, which is not settled here.
  const auto active = streams.all([](const Stream& s) { return s.active(); });
  const auto out_of_band = both(active, room.out_of_band);
  const auto possible = both(out_of_band, both(room.some_pair, exists));
  const auto no_pair = only(room.some_pair, both(out_of_band, room.own_intervals));
  const auto repaired = only(either(self.unsolvable(), behind.unsolvable()), possible);

  streams.each([&](const Stream& s, auto part, std::size_t which) {
    const M here = part(repaired);
    s.set_parent(s.at.A, part(pair.a), here);
    s.set_parent(s.at.B, part(pair.b), here);
    s.keep(part_of(self, part), here, s.at.bead);
    s.keep(part_of(behind, part), here, s.at.behind);
    s.add_attempts(here);
    s.count(s.front.pairs, here);
    outcomes[which] = {bits_of(here), bits_of(hn::AndNot(here, part(active))), bits_of(part(no_pair))};
  });
}

/// The bits of the piles from lane k on that fit into a vector.
HWY_INLINE unsigned some_of(unsigned lanes, std::size_t k) { return lanes >> k & ((1U << hn::Lanes(d)) - 1) & 0xFFU; }

/// Solves the bead as it is with its first number, in those of the piles of `lanes` in which it has a solution; returns
/// the others.
HWY_INLINE unsigned draw_as_is(const ConeOf<V>& cone, GroupFront& front, const GroupBead& bead, unsigned lanes) {
  unsigned open = 0;
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const Stream s{front, bead, k, some_of(lanes, k)};
    if (s.lanes == 0) continue;
    const GroupRow& above = front.above;
    const V H = s.load(above.H_R, bead.A) + (s.load(above.H, bead.B) - s.load(above.H_R, bead.B));
    const V half_weight = hn::Set(d, front.half_weight);
    const Bead<V> as_is =
        bead_under<V>(cone, {s.load(above.V_R, bead.A) + half_weight, s.load(above.V_L, bead.B) + half_weight, H});
    const M active = s.active(), drawn = only(as_is.unsolvable(), active);
    s.keep(as_is, drawn, bead.bead);
    open |= bits_of(only(drawn, active)) << k;
  }
  return open;
}

HWY_INLINE GroupBead surroundings(const GroupFront& front) {
  const auto next = [&](int bead) { return bead + 1 == front.columns ? 0 : bead + 1; };
  const auto previous = [&](int bead) { return bead == 0 ? front.columns - 1 : bead - 1; };
  const auto number = [](int index) { return static_cast<std::size_t>(index); };
  const int left = previous(front.bead), right = next(front.bead);
  const bool even = front.layer % 2 == 0;
  const int A = even ? left : front.bead, B = even ? front.bead : right;
  return {number(A),
          number(B),
          number(front.forward ? previous(A) : next(B)),
          number(front.forward ? left : right),
          number(front.bead),
          number(front.forward ? right : left)};
}

/// Goes on to the next bead that was noted to fail in a pile that is running; false at the end of the layer.
HWY_INLINE bool skip_to_failing(GroupFront& front) {
  constexpr int at_once = 8;
  static_assert(at_once <= row_padding);
  const std::uint64_t running = front.running * every_byte;
  // The bead ahead of one just repaired, mostly. Its byte was just written, and would hold up the load of a whole word.
  if (front.position < front.columns && (front.failing[front.bead] & front.running) != 0) return true;
  while (front.position < front.columns) {
    // The beads up to the end of the row or of the layer's order, whichever comes first, eight at a time.
    const int to_end = front.forward ? front.columns - front.bead : front.bead + 1;
    const int rest = std::min(to_end, front.columns - front.position);
    int n = 0;
    for (; n < rest; n += at_once) {
      std::uint64_t word;
      std::memcpy(&word, front.failing + front.bead + (front.forward ? n : -n - (at_once - 1)), sizeof word);
      word &= running;
      if (word == 0) continue;
      n += (front.forward ? std::countr_zero(word) : std::countl_zero(word)) / 8;
      break;
    }
    if (n < rest) {
      front.step(n);
      return true;
    }
    front.step(rest);
  }
  return false;
}

/// Goes on to the next bead that has no solution as it is in some pile (`to_repair`), or that is left to the solvers of
/// single piles (`to_solve_singly`); false at the end of the layer.
HWY_INLINE bool find_unsolved(const ConeOf<V>& cone, GroupFront& front) {
  if ((front.to_repair | front.to_solve_singly) != 0) return true;
  for (; skip_to_failing(front); front.step()) {
    const unsigned failing = front.failing[front.bead] & front.running;
    if (front.at_an_end()) {
      front.to_solve_singly = failing;
      front.no_pair = 0;
      return true;
    }
    // A bead that had no solution when the layer was drawn has none now, unless its parents have changed since.
    const unsigned changed = failing & front.changed[front.bead];
    front.to_repair = failing & ~changed;
    if (changed != 0) front.to_repair |= draw_as_is(cone, front, surroundings(front), changed);
    if (front.to_repair != 0) return true;
  }
  return false;
}

HWY_INLINE void lap(const GroupFront& front, Phase phase) {
  if (front.times != nullptr) front.times->end(phase);
}

/// What follows from a bead's repair, in all its piles: the rule is kept, and the neighbour ahead, whose turn has not
/// come, forgets what was drawn for it.
HWY_INLINE void note(GroupFront& front, const GroupBead& bead, const Outcome& outcome) {
  front.failing[bead.ahead] = static_cast<std::uint8_t>(front.failing[bead.ahead] | outcome.repaired);
  front.changed[bead.ahead] = static_cast<std::uint8_t>(front.changed[bead.ahead] | outcome.repaired);
  // A byte of ones for each pile that was repaired, without a branch for each.
  constexpr std::uint64_t one_bit_a_byte = 0x8040201008040201U;
  const std::uint64_t some_bit = outcome.repaired * every_byte & one_bit_a_byte;
  const std::uint64_t whole_bytes = (((some_bit + (every_byte * 0x7F)) | some_bit) >> 7 & every_byte) * 0xFF;
  std::uint64_t rules;
  std::memcpy(&rules, front.rule + bead.bead * group_lanes, sizeof rules);
  rules = (rules & ~whole_bytes) | (whole_bytes & every_byte * front.repair_rule);
  std::memcpy(front.rule + bead.bead * group_lanes, &rules, sizeof rules);
  front.to_repair = 0;
  front.to_solve_singly = outcome.left_over;
  front.no_pair = outcome.no_pair;
  if (front.to_solve_singly == 0) front.step();
}

void RepairAlong(const FrictionCone& friction, GroupFront& front) {
  const ConeOf<V> cone(friction);
  while (find_unsolved(cone, front) && front.to_solve_singly == 0) {
    lap(front, Phase::search);
    const GroupBead bead = surroundings(front);
    Outcome whole;
    for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
      const Stream stream{front, bead, k, some_of(front.to_repair, k)};
      if (stream.lanes == 0) continue;
      Outcome outcome;
      if (front.forward) {
        repair_streams(friction, One<true>{stream}, &outcome);
      } else {
        repair_streams(friction, One<false>{stream}, &outcome);
      }
      whole.add(outcome, k);
    }
    note(front, bead, whole);
    lap(front, Phase::pairs);
  }
  lap(front, Phase::search);
}

void RepairAlongBoth(const FrictionCone& friction, GroupFront& a, GroupFront& b) {
  const ConeOf<V> cone(friction);
  for (;;) {
    const bool in_a = find_unsolved(cone, a), in_b = find_unsolved(cone, b);
    lap(a, Phase::search);
    if (!in_a || !in_b || (a.to_solve_singly | b.to_solve_singly) != 0) return;
    const GroupBead bead_a = surroundings(a), bead_b = surroundings(b);
    Outcome whole[2];
    for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
      const Stream first{a, bead_a, k, some_of(a.to_repair, k)}, second{b, bead_b, k, some_of(b.to_repair, k)};
      if ((first.lanes | second.lanes) == 0) continue;
      Outcome outcomes[2];
      if (a.forward && b.forward) {
        repair_streams(friction, Two<true, true>{first, second}, outcomes);
      } else if (a.forward) {
        repair_streams(friction, Two<true, false>{first, second}, outcomes);
      } else if (b.forward) {
        repair_streams(friction, Two<false, true>{first, second}, outcomes);
      } else {
        repair_streams(friction, Two<false, false>{first, second}, outcomes);
      }
      whole[0].add(outcomes[0], k);
      whole[1].add(outcomes[1], k);
    }
    note(a, bead_a, whole[0]);
    note(b, bead_b, whole[1]);
    lap(a, Phase::pairs);
    if ((a.to_solve_singly | b.to_solve_singly) != 0) return;
  }
}

/// One bead below A and B in the piles from lane k on; whether it has no solution.
HWY_INLINE unsigned draw_first(const ConeOf<V>& cone, const GroupFront& front, const TopLoad* top, std::size_t k,
                               std::size_t A, std::size_t B, std::size_t number, V uniform) {
  const std::size_t to = (number * group_lanes) + k;
  IncomingOf<V> in;
  if (top != nullptr) {
    const V half = hn::Load(d, top->half + to);
    const double lean = sqrt3 * top->line.slope - 2 * top->line.offset;
    if (top->line.of_excess) {
      const V excess = half - hn::Set(d, 0.5), leaning = hn::Set(d, lean) * excess;
      in.V_UL = half + leaning;
      in.V_UR = half - leaning;
      in.H = excess * hn::Set(d, 2 * top->line.slope);
    } else {
      in.V_UL = half * hn::Set(d, 1 + lean);
      in.V_UR = half * hn::Set(d, 1 - lean);
      in.H = half * hn::Set(d, 2 * top->line.slope);
    }
  } else {
    const std::size_t a = (A * group_lanes) + k, b = (B * group_lanes) + k;
    in.V_UL = hn::Load(d, front.above.V_R + a);
    in.V_UR = hn::Load(d, front.above.V_L + b);
    in.H = hn::Load(d, front.above.H_R + a) + (hn::Load(d, front.above.H + b) - hn::Load(d, front.above.H_R + b));
  }
  const V half_weight = hn::Set(d, front.half_weight);
  in.V_UL = in.V_UL + half_weight;
  in.V_UR = in.V_UR + half_weight;
  const DrawnBeadOf<V> bead = draw_bead(cone, in, uniform);
  hn::Store(bead.out.V_R, d, front.here.V_R + to);
  hn::Store(bead.out.V_L, d, front.here.V_L + to);
  hn::Store(in.H, d, front.here.H + to);
  hn::Store(bead.H_R, d, front.here.H_R + to);
  // What is not a number has no solution, either.
  return bits_of(negation(at_most(hn::Zero(d), bead.slack))) & ((1U << hn::Lanes(d)) - 1);
}

void DrawLayer(const FrictionCone& friction, const TopLoad& top, GroupFront& front) {
  const ConeOf<V> cone(friction);
  const auto columns = static_cast<std::size_t>(front.columns);
  const W layers = hn::Set(dw, static_cast<std::uint64_t>(static_cast<std::uint32_t>(front.layer)));
  const TopLoad* const load = front.layer == 0 ? &top : nullptr;
  const bool even = front.layer % 2 == 0;
  for (std::size_t k = 0; k < group_lanes; k += hn::Lanes(d)) {
    const W samples = hn::Load(dw, front.sample.data() + k);
    const auto draw = [&](std::size_t bead, V uniform) __attribute__((always_inline)) {
      const std::size_t previous = bead == 0 ? columns - 1 : bead - 1, next = bead + 1 == columns ? 0 : bead + 1;
      const unsigned fails = draw_first(cone, front, load, k, even ? previous : bead, even ? bead : next, bead, uniform)
                             << k;
      front.failing[bead] = static_cast<std::uint8_t>(k == 0 ? fails : front.failing[bead] | fails);
    };
    for (std::size_t bead = 0; bead < columns; bead += 2) {
      const auto u = philox_uniforms(dw, front.keys, hn::Set(dw, static_cast<std::uint64_t>(bead / 2)), layers, samples,
                                     hn::Zero(dw));
      hn::Store(u.first, d, front.first_uniform + (bead * group_lanes) + k);
      hn::Store(u.second, d, front.first_uniform + ((bead + 1) * group_lanes) + k);
      draw(bead, u.first);
      if (bead + 1 < columns) draw(bead + 1, u.second);
    }
  }
}

/// The vectors of the row; returns how many entries they held. The piles take turns at the bytes.
std::size_t CountRules(const std::uint8_t* HWY_RESTRICT rule, const std::uint8_t* HWY_RESTRICT backtracks,
                       std::size_t entries, RuleCounts& counts) {
  const hn::CappedTag<std::uint8_t, 64> d_bytes;
  const std::size_t lanes = hn::Lanes(d_bytes), most_in_a_byte = 255;
  const auto zero = hn::Zero(d_bytes), backtrack = hn::Set(d_bytes, last_rule);
  std::size_t done = 0;
  while (done + lanes <= entries) {
    auto by_1 = zero, by_2 = zero, by_3 = zero, by_4 = zero;
    for (std::size_t n = 0; n < most_in_a_byte && done + lanes <= entries; ++n, done += lanes) {
      const auto backtracked = hn::Ne(hn::LoadU(d_bytes, backtracks + done), zero);
      const auto by = hn::IfThenElse(backtracked, backtrack, hn::LoadU(d_bytes, rule + done));
      const auto add = [&](auto& sum, std::uint8_t which) {
        sum = hn::Sub(sum, hn::VecFromMask(d_bytes, hn::Eq(by, hn::Set(d_bytes, which))));
      };
      add(by_1, 1);
      add(by_2, 2);
      add(by_3, 3);
      add(by_4, 4);
    }
    const std::size_t first_pile = done % group_lanes;  // that of a vector's first byte
    const auto spread = [&](const auto& sum, std::size_t which) {
      alignas(64) std::uint8_t sums[64];
      hn::Store(sum, d_bytes, sums);
      for (std::size_t k = 0; k < lanes; ++k) counts[(first_pile + k) % group_lanes][which] += sums[k];
    };
    spread(by_1, 1);
    spread(by_2, 2);
    spread(by_3, 3);
    spread(by_4, 4);
  }
  return done;
}

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace granuscope {

HWY_EXPORT(RepairAlong);
HWY_EXPORT(RepairAlongBoth);
HWY_EXPORT(DrawLayer);
HWY_EXPORT(CountRules);

void repair_along(const FrictionCone& cone, GroupFront& front) { HWY_DYNAMIC_DISPATCH(RepairAlong)(cone, front); }

void repair_along(const FrictionCone& cone, GroupFront& a, GroupFront& b) {
  HWY_DYNAMIC_DISPATCH(RepairAlongBoth)(cone, a, b);
}

void draw_layer(const FrictionCone& cone, const TopLoad& top, GroupFront& front) {
  HWY_DYNAMIC_DISPATCH(DrawLayer)(cone, top, front);
}

void count_rules(const std::uint8_t* rule, const std::uint8_t* backtracks, std::size_t beads, RuleCounts& counts) {
  const std::size_t entries = beads * group_lanes;
  for (std::size_t i = HWY_DYNAMIC_DISPATCH(CountRules)(rule, backtracks, entries, counts); i < entries; ++i) {
    ++counts[i % group_lanes][backtracks[i] != 0 ? last_rule : rule[i]];
  }
}

}  // namespace granuscope
#endif
