#include "sampling/climb_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sampling/climb_kernels.cc"
#include <hwy/foreach_target.h>  // compiles this file once for each instruction set
#include <hwy/highway.h>

#include "sampling/granusolve.h"
#include "sampling/mend_arithmetic-inl.h"
#include "sampling/philox-inl.h"

HWY_BEFORE_NAMESPACE();
namespace granuscope {
namespace HWY_NAMESPACE {

#if HWY_MAX_BYTES >= 64

constexpr int lanes = 8;

HWY_INLINE V with_entry(V row, int lane, double value) {
  const std::uint8_t bits[8] = {static_cast<std::uint8_t>(1U << lane)};
  return hn::IfThenElse(hn::LoadMaskBits(d, bits), hn::Set(d, value), row);
}
/// Each entry one lane on; the first stays.
HWY_INLINE V one_on(V row) {
  alignas(64) constexpr std::int64_t from[lanes] = {0, 0, 1, 2, 3, 4, 5, 6};
  return hn::TableLookupLanes(row, hn::SetTableIndices(d, from));
}
HWY_INLINE W word(std::int64_t value) { return hn::Set(dw, static_cast<std::uint64_t>(value)); }

/// The forces of a row of beads: bead k stands in lane k + 1, between the beads to both sides. The parents of a bead
/// are in its own lane and the one before, of the row above.
using Row = Parent<V>;

struct StoredRow {
  alignas(64) double V_R[lanes], V_L[lanes], H[lanes], H_R[lanes];
};

HWY_INLINE void store(const Row& row, StoredRow& to) {
  hn::Store(row.V_R, d, to.V_R);
  hn::Store(row.V_L, d, to.V_L);
  hn::Store(row.H, d, to.H);
  hn::Store(row.H_R, d, to.H_R);
}

/// What hangs below a row, and in which lanes it has no solution.
HWY_INLINE Row below(const Cone<V>& cone, const Row& above, V numbers, unsigned& fails) {
  const Bead<V> bead =
      bead_under(cone, one_on(above.V_R), above.V_L, plus(one_on(above.H_R), minus(above.H, above.H_R)));
  fails = bits_of(bead.unsolvable());
  return {bead.V_R, bead.V_L, bead.H, point_at(bead.interval, numbers)};
}

/// The beads above the front, numbered row by row, and as the last one that at the cursor: a multiple of eight.
template <int height>
struct ClimbingBeads {
  static constexpr int first_of(int row) { return row * (height + 1) + row * (row - 1) / 2; }
  static constexpr int size = first_of(height) + 1;
  static_assert(size % lanes == 0);

  std::array<int, size> row{}, place{};
  /// What is to be added to the number of the bead at the cursor, in an even layer or an odd one, and of its layer.
  alignas(64) std::int64_t bead[2][size] = {}, layer[size] = {};

  constexpr ClimbingBeads() {
    for (int r = 0; r < height; ++r) {
      for (int k = 0; k < LowClimb::beads(height, r); ++k) {
        const int n = first_of(r) + k;
        row[n] = r;
        place[n] = k;
        layer[n] = r - height;
        for (int odd = 0; odd < 2; ++odd) {
          // The number of an upper-right parent is one more than that of a bead of an odd layer (model/lattice.h).
          int steps = 0;
          for (int rows_up = 0; rows_up < height - r; ++rows_up) steps += (rows_up + odd) % 2;
          bead[odd][n] = k - height + steps;
        }
      }
    }
    row[size - 1] = place[size - 1] = height;
  }
};

template <int height>
class LowClimbRedrawing {
 public:
  HWY_INLINE LowClimbRedrawing(const LowClimb& climb, const GranusolveState& state, const FrictionCone& cone,
                               const PhiloxKeys& keys, std::uint32_t sample)
      : climb_(climb), state_(state), keys_(keys), cone_(cone), sample_(sample) {}

  HWY_INLINE LowClimbDrawn draw() {
    draw_next_numbers();
    const V front_numbers = entries<1, beads(height)>(state_.first_uniform + at_front(climb_.bead - height));
    const std::size_t up = climb_.at_parents;
    const Row parents{entries<0, height + 2>(state_.V_R + up), entries<0, height + 2>(state_.V_L + up),
                      entries<0, height + 2>(state_.H + up), entries<0, height + 2>(state_.H_R + up)};
    LowClimbDrawn drawn;
    drawn.rows = draw_rows<0>(parents);
    if (drawn.rows == height) draw_front(front_numbers, drawn);
    keep_rows<0>(drawn.rows);
    return drawn;
  }

 private:
  using Beads = ClimbingBeads<height>;
  static constexpr Beads climbing{};
  static constexpr int cursor = height;  ///< the place of that bead in the front row
  static constexpr unsigned cursor_bit = 2U << cursor;

  static constexpr int beads(int row) { return LowClimb::beads(height, row); }
  /// Of the lanes in which a row's beads stand.
  static constexpr unsigned bits(int row) { return ((1U << beads(row)) - 1) << 1; }
  HWY_INLINE std::size_t at_front(int bead) const { return static_cast<std::size_t>(bead) * state_.stride; }
  HWY_INLINE std::size_t at(int row, int place) const {
    return climb_.at[static_cast<std::size_t>(row)] + static_cast<std::size_t>(place) * state_.stride;
  }

  /// `count` entries, the first of them in lane `lane`.
  template <int lane, int count>
  HWY_INLINE V entries(const double* from) const {
    V row = hn::Set(d, from[0]);
    HWY_UNROLL(8)
    for (int k = 1; k < count; ++k) row = with_entry(row, lane + k, from[static_cast<std::size_t>(k) * state_.stride]);
    return row;
  }

  HWY_INLINE void draw_next_numbers() {
    hn::Store(hn::Zero(d), d, first_numbers_);
    hn::Store(hn::Zero(d), d, first_numbers_ + lanes + climbing.size);
    const hn::RebindToSigned<WordTag> di;
    HWY_UNROLL(2)
    for (int begin = 0; begin < climbing.size; begin += lanes) {
      auto attempts = hn::Zero(d32);
      HWY_UNROLL(8)
      for (int k = 0; k < lanes; ++k) {
        const auto n = static_cast<std::size_t>(begin + k);
        const std::uint8_t lane[8] = {static_cast<std::uint8_t>(1U << k)};
        attempts = hn::IfThenElse(hn::LoadMaskBits(d32, lane),
                                  hn::Set(d32, state_.attempts[at(climbing.row[n], climbing.place[n])]), attempts);
      }
      const W attempt = hn::Add(hn::PromoteTo(dw, attempts), word(1));
      const auto relative = [&](const std::int64_t* to) { return hn::BitCast(dw, hn::Load(di, to + begin)); };
      const auto u = philox_uniforms(dw, keys_, hn::Add(word(climb_.bead), relative(climbing.bead[climb_.layer % 2])),
                                     hn::Add(word(climb_.layer), relative(climbing.layer)), word(sample_),
                                     hn::Or(hn::ShiftLeft<8>(attempt), word(later_attempt_stream)));
      hn::Store(u.first, d, first_numbers_ + lanes + begin);
      hn::Store(u.second, d, second_numbers_ + begin);
    }
  }

  /// Returns the first row with a bead that has no solution, or the front row.
  template <int row>
  HWY_INLINE int draw_rows(const Row& above) {
    if constexpr (row == height) {
      return height;
    } else {
      unsigned fails;
      Row here = below(cone_, above, hn::LoadU(d, first_numbers_ + lanes - 1 + Beads::first_of(row)), fails);
      if ((fails & bits(row)) != 0) return row;
      add_sides<row>(here);
      store(here, rows_[row]);
      last_ = here;
      return draw_rows<row + 1>(here);
    }
  }
  /// The beads beside a row, which the outer ones of the next row hang from.
  template <int row>
  HWY_INLINE void add_sides(Row& here) const {
    const std::size_t left = at(row, -1), right = at(row, beads(row));
    constexpr int last = beads(row) + 1;
    here.V_R = with_entry(here.V_R, 0, state_.V_R[left]);
    here.H_R = with_entry(here.H_R, 0, state_.H_R[left]);
    here.V_L = with_entry(here.V_L, last, state_.V_L[right]);
    here.H = with_entry(here.H, last, state_.H[right]);
    here.H_R = with_entry(here.H_R, last, state_.H_R[right]);
  }

  HWY_INLINE void draw_front(V numbers, LowClimbDrawn& drawn) {
    const unsigned left = cursor_bit - 2, right = left << (height + 1);
    const unsigned behind = climb_.forward ? left : right, ahead = climb_.forward ? right : left;
    unsigned fails;
    Row here = below(cone_, last_, numbers, fails);
    if ((fails & behind) != 0) return;
    drawn.rows = height + 1;
    drawn.bead = LowClimbDrawn::Bead::drawn;
    if ((fails & cursor_bit) != 0) {
      drawn.bead = climb_.forward ? mend<true>(numbers, here, fails) : mend<false>(numbers, here, fails);
    }
    drawn.failing = (fails & ahead) >> 1;
    store(here, rows_[height]);
    for (int k = 0; k < beads(height); ++k) {
      if ((fails >> (k + 1) & 1) == 0) keep(height, k);
    }
  }

  /// The pair rule for the bead at the cursor. If it helps, the row is drawn again with the new splits above it.
  template <bool forward>
  HWY_INLINE LowClimbDrawn::Bead mend(V numbers, Row& here, unsigned& fails) {
    constexpr int B_lane = cursor + 1, A_lane = B_lane - 1, outer_lane = forward ? A_lane - 1 : B_lane + 1;
    StoredRow& above = rows_[height - 1];
    const auto parent = [&](int lane) __attribute__((always_inline)) {
      return Parent<V>{hn::Set(d, above.V_R[lane]), hn::Set(d, above.V_L[lane]), hn::Set(d, above.H[lane]),
                       hn::Set(d, above.H_R[lane])};
    };
    const PairRoom<V> room = room_for_pair(cone_, parent(A_lane), parent(B_lane), parent(outer_lane),
                                           [](V on_left, V on_right) { return forward ? on_left : on_right; });
    const auto holds = [](M mask) { return (bits_of(mask) & 1) != 0; };
    if (!holds(room.out_of_band)) return LowClimbDrawn::Bead::open;
    // The parents' own intervals are not empty: they have just been drawn on them.
    if (!holds(room.some_pair)) return LowClimbDrawn::Bead::no_pair;
    const auto pair =
        draw_truncated_pairs(room.a, room.b, room.band, hn::Set(d, first_numbers_[lanes + climbing.size - 1]),
                             hn::Set(d, second_numbers_[climbing.size - 1]));
    if (!holds(pair.exists)) return LowClimbDrawn::Bead::open;
    Row changed = last_;
    changed.H_R = with_entry(with_entry(changed.H_R, A_lane, hn::GetLane(pair.a)), B_lane, hn::GetLane(pair.b));
    unsigned fails_now;
    const Row redrawn = below(cone_, changed, numbers, fails_now);
    const unsigned behind_bit = forward ? cursor_bit >> 1 : cursor_bit << 1;
    // By rounding only.
    if ((fails_now & (cursor_bit | behind_bit)) != 0) return LowClimbDrawn::Bead::open;
    hn::Store(changed.H_R, d, above.H_R);
    here = redrawn;
    fails = fails_now;
    return LowClimbDrawn::Bead::mended;
  }

  HWY_INLINE void keep(int row, int place) const {
    const StoredRow& from = rows_[row];
    const std::size_t to = at(row, place);
    const int lane = place + 1;
    state_.V_R[to] = from.V_R[lane];
    state_.V_L[to] = from.V_L[lane];
    state_.H[to] = from.H[lane];
    state_.H_R[to] = from.H_R[lane];
    if (state_.H_L != nullptr) state_.H_L[to] = from.H[lane] - from.H_R[lane];
    state_.rule[to] = 0;
  }
  template <int row>
  HWY_INLINE void keep_rows(int rows) const {
    if constexpr (row < height) {
      if (row == rows) return;
      HWY_UNROLL(8)
      for (int k = 0; k < beads(row); ++k) {
        keep(row, k);
        ++state_.attempts[at(row, k)];
      }
      keep_rows<row + 1>(rows);
    }
  }

  const LowClimb& climb_;
  const GranusolveState& state_;
  const PhiloxKeys& keys_;
  const Cone<V> cone_;
  std::uint32_t sample_;
  /// Of the beads of `climbing`, between vectors of zeros: a row's vector begins one lane before its beads, and ends
  /// beyond them.
  alignas(64) double first_numbers_[climbing.size + 2 * lanes], second_numbers_[climbing.size];
  StoredRow rows_[height + 1];
  Row last_;  ///< of those above the front
};

LowClimbDrawn Redraw(const LowClimb& climb, const GranusolveState& state, const FrictionCone& cone,
                     const PhiloxKeys& keys, std::uint32_t sample) {
  return climb.height == LowClimb::lowest ? LowClimbRedrawing<2>(climb, state, cone, keys, sample).draw()
                                          : LowClimbRedrawing<3>(climb, state, cone, keys, sample).draw();
}

bool CanRedraw() { return hn::Lanes(d) == lanes; }

#else

LowClimbDrawn Redraw(const LowClimb&, const GranusolveState&, const FrictionCone&, const PhiloxKeys&, std::uint32_t) {
  return {};
}

bool CanRedraw() { return false; }

#endif

}  // namespace HWY_NAMESPACE
}  // namespace granuscope
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace granuscope {

HWY_EXPORT(Redraw);
HWY_EXPORT(CanRedraw);

bool can_redraw_low_climbs() { return HWY_DYNAMIC_DISPATCH(CanRedraw)(); }

LowClimbDrawn redraw(const LowClimb& climb, const GranusolveState& state, const FrictionCone& cone,
                     const PhiloxKeys& keys, std::uint32_t sample) {
  return HWY_DYNAMIC_DISPATCH(Redraw)(climb, state, cone, keys, sample);
}

}  // namespace granuscope
#endif
