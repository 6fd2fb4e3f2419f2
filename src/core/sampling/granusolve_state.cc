// The invariants of a pile that is being solved (granusolve_state.h), verified.
#include "sampling/granusolve_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace granuscope {
void BeadRun::include(int other, int others, int columns) {
  if (count == 0) {
    first = other;
    count = others;
    return;
  }
  // The shorter way from one run's first bead to the other's.
  const int to_other = other < first ? other - first + columns : other - first;
  if (to_other <= columns / 2) {
    count = std::max(count, to_other + others);
  } else {
    count = std::max(others, columns - to_other + count);
    first = other;
  }
  count = std::min(count, columns);
}

GranusolveState::GranusolveState(const SamplerSpec& spec, const Lattice& lattice)
    : lattice_(lattice),
      cone_(spec.mu, lattice.geometry()),
      drawn_(spec.drawn),
      order_(static_cast<std::size_t>(lattice.layers())),
      pending_(static_cast<std::size_t>(lattice.layers())),
      load_line_(granuscope::load_line(spec)),
      half_weight_(spec.bead_weight / 2) {}

void GranusolveState::begin_pile(const RandomKey& key, LayerOrder order, std::span<const double> load,
                                 std::uint32_t attempts_at_first) {
  load_ = load;
  attempts_at_first_ = attempts_at_first;
  std::fill(pending_.begin(), pending_.end(), BeadRun{});
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    RandomKey::Order& here = order_[static_cast<std::size_t>(layer)] = {0, 1};
    if (order == LayerOrder::fixed) continue;
    here = key.layer_order(layer, lattice_.columns());
    if (order == LayerOrder::rightwards) here.direction = 1;
  }
  watch_pending();
}

/// The beads from `low` to `high` that fail: the first of them if `direction` > 0, else the last; -1 if there is none.
int GranusolveState::find_failing_between(int low, int high, int direction) const {
  if (low > high) return -1;
  const int first_word = low / 64, last_word = high / 64;
  const auto inside = [&](int word) {
    std::uint64_t bits = arrays_.failing[static_cast<std::size_t>(word)];
    if (word == first_word) bits &= ~std::uint64_t{0} << (low % 64);
    if (word == last_word) bits &= ~std::uint64_t{0} >> (63 - high % 64);
    return bits;
  };
  if (direction > 0) {
    for (int word = first_word; word <= last_word; ++word) {
      if (const std::uint64_t bits = inside(word); bits != 0) return 64 * word + std::countr_zero(bits);
    }
  } else {
    for (int word = last_word; word >= first_word; --word) {
      if (const std::uint64_t bits = inside(word); bits != 0) return 64 * word + 63 - std::countl_zero(bits);
    }
  }
  return -1;
}

int GranusolveState::next_failing() {
  const int columns = lattice_.columns(), here = cursor_bead_;
  if (cursor_ == columns) return -1;
  if (bit_of(arrays_.failing, here)) return here;  // the neighbour of a bead just repaired, mostly
  const auto [first, direction] = order(front_);
  // From the cursor to the end of the row, and what lies beyond it up to the first bead of the order.
  const bool wrapped = direction > 0 ? here < first : here > first;
  int bead = -1;
  if (direction > 0) {
    bead = find_failing_between(here, wrapped ? first - 1 : columns - 1, 1);
    if (bead < 0 && !wrapped) bead = find_failing_between(0, first - 1, 1);
  } else {
    bead = find_failing_between(wrapped ? first + 1 : 0, here, -1);
    if (bead < 0 && !wrapped) bead = find_failing_between(first + 1, columns - 1, -1);
  }
  move_cursor(front_, bead < 0 ? columns : position(front_, bead), bead);
  return bead;
}

Interval GranusolveState::interval_of(int layer, int bead) const {
  const std::size_t here = at(layer, bead);
  return closed(split_interval(cone_, {arrays_.V_R[here], arrays_.V_L[here]}, arrays_.H[here]));
}

Interval GranusolveState::difference_band(int layer, int bead) const {
  const std::size_t P = at(layer - 1, lattice_.upper_left(layer, bead));
  const std::size_t Q = at(layer - 1, lattice_.upper_right(layer, bead));
  const Interval band = solvable_band(cone_, arrays_.V_R[P] + half_weight_, arrays_.V_L[Q] + half_weight_);
  return {band.low - arrays_.H[Q], band.high - arrays_.H[Q]};
}

/// Whatever hangs below an unsolved bead is unsolved already.
void GranusolveState::unsolve(int layer, int first, int count) {
  // A copy, which no store of a byte can change.
  const Lattice lattice = lattice_;
  const std::size_t stride = arrays_.stride;
  for (; layer <= front_; first = lattice.lower_left(layer, first), ++layer, ++count) {
    bool some_solved = false;
    count = std::min(count, lattice.columns());
    std::uint8_t* const unsolved = arrays_.unsolved + at(layer, 0);
    const bool at_front = layer == front_;
    for (int k = 0, bead = first; k < count; ++k, bead = lattice.next(bead)) {
      // The bead at the cursor is either being solved right now, and is tried again by whoever called, or the next one.
      if (at_front && position(layer, bead) >= cursor_) {
        forget_draw(bead);
        continue;
      }
      std::uint8_t& state = unsolved[static_cast<std::size_t>(bead) * stride];
      some_solved |= state == 0;
      state = std::max(state, below_backtrack);
    }
    if (!some_solved) return;
    pending_[static_cast<std::size_t>(layer)].include(first, count, lattice_.columns());
    topmost_pending_ = std::min(topmost_pending_, layer);
  }
}

namespace {

constexpr double ulps = rounding_ulps * std::numeric_limits<double>::epsilon();

[[noreturn, gnu::cold]] void fail(const char* what, int layer, int bead) {
  throw std::logic_error(fmt::format("granusolve, layer {}, bead {}: {}", layer, bead, what));
}

/// Inline: each bead of each layer is looked at ten times, a third of the time of the tests under the sanitizers.
inline void require(bool holds, const char* what, int layer, int bead) {
  if (!holds) fail(what, layer, bead);
}

}  // namespace

void GranusolveState::check() const {
  const int columns = lattice_.columns();
  require(cursor_ >= 0 && cursor_ <= columns, "the cursor has left the layer", front_, cursor_bead_);
  if (cursor_ < columns) {
    require(position(front_, cursor_bead_) == cursor_, "the bead at the cursor is another one", front_, cursor_bead_);
  }
  require(topmost_pending_ == lattice_.layers(), "some layer is pending", topmost_pending_, 0);
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    require(pending(layer).count == 0, "a run of beads is pending", layer, pending(layer).first);
  }
  if (front_ > 0) check_row(front_ - 1);
  check_row(front_);
}

/// Splits are held to their intervals within the rounding of the largest force in the row: the arcs add and subtract
/// forces of neighbours, near mu = sqrt 3 of any order of magnitude.
void GranusolveState::check_row(int layer) const {
  double largest = 0;
  for (int bead = 0; bead < lattice_.columns(); ++bead) {
    const std::size_t here = at(layer, bead);
    largest = std::max({largest, arrays_.V_R[here], arrays_.V_L[here], std::abs(arrays_.H[here])});
  }
  for (int bead = 0; bead < lattice_.columns(); ++bead) {
    const std::size_t here = at(layer, bead);
    require(arrays_.unsolved[here] == 0, "it is unsolved, and not pending", layer, bead);
    require(arrays_.rule[here] < static_cast<std::uint8_t>(GranusolveRule::backtrack), "it has no rule", layer, bead);
    require(arrays_.attempts[here] >= attempts_at_first_, "its attempts have begun anew", layer, bead);
    if (awaits_turn(layer, bead)) {
      const bool failing = bit_of(arrays_.failing, bead);
      require(arrays_.attempts[here] == attempts_at_first_ && arrays_.backtracks[here] == 0 &&
                  arrays_.rule[here] == static_cast<std::uint8_t>(GranusolveRule::first_draw),
              "something was done for it before its turn", layer, bead);
      require(failing || arrays_.changed == nullptr || !bit_of(arrays_.changed, bead),
              "it has changed, and does not fail", layer, bead);
      if (failing) continue;
    }
    check_balance(layer, bead);
    const Interval interval = interval_of(layer, bead);
    require(arrays_.V_R[here] >= -ulps * largest && arrays_.V_L[here] >= -ulps * largest, "a contact is pulled", layer,
            bead);
    require(arrays_.H_R[here] >= interval.low - ulps * largest && arrays_.H_R[here] <= interval.high + ulps * largest,
            "its split has left its interval", layer, bead);
    require(arrays_.H_L == nullptr || arrays_.H_L[here] == arrays_.H[here] - arrays_.H_R[here],
            "its two horizontal forces do not add up", layer, bead);
  }
}

void GranusolveState::check_run(int layer, const BeadRun& run) const {
  for (int k = 0, bead = run.first; k < run.count; ++k, bead = lattice_.next(bead)) {
    if (awaits_turn(layer, bead)) continue;
    require(arrays_.unsolved[at(layer, bead)] == 0, "it was to be solved again, and was not", layer, bead);
    check_balance(layer, bead);
  }
}

/// A solved bead takes what its parents hand down, or by rounding the nearest force that it can take.
void GranusolveState::check_balance(int layer, int bead) const {
  const std::size_t here = at(layer, bead);
  const Incoming handed = incoming(layer, bead);
  const double allowance = ulps * (handed.V_UL + handed.V_UR + std::abs(handed.H));
  require(std::abs(arrays_.H[here] - handed.H) <= allowance, "its parents hand down another force", layer, bead);
  const Outgoing out = balance(cone_, {handed.V_UL, handed.V_UR, arrays_.H[here]});
  require(out.V_R == arrays_.V_R[here] && out.V_L == arrays_.V_L[here], "its vertical forces do not balance", layer,
          bead);
}

}  // namespace granuscope
