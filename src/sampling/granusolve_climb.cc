// Climbing: what is unsolved above a bead that no change of its parents helps, and how it is solved again.
#include <algorithm>
#include <array>
#include <limits>

#include "sampling/granusolve.h"
#include "sampling/layer_kernels.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

constexpr int lowest_climb = 2;  // layers, of the first climb that sets out from a bead

}  // namespace

GranusolveSampler::Mend GranusolveSampler::climb(int layer, int bead) {
  ++counts_.climbs;
  std::uint8_t& climbs = state_.climbs[at(layer, bead)];
  const int height = lowest_climb + climbs;
  if (climbs < std::numeric_limits<std::uint8_t>::max()) ++climbs;
  const int top = std::max(0, layer - height);
  // Mends of the topmost unsolved layer change the one above it, and whoever keeps a window has read that one's
  // neighbours as final.
  if (front_ - top > window_ - 4) {
    beyond_window_ = true;
    solutions_ = max_solutions_ + 1;
    return Mend::climbed;
  }
  const int sideways = height - (layer - top);
  int first = bead;
  for (int n = layer; n > top; --n) first = lattice_.upper_left(n, first);
  const int columns = lattice_.columns();
  const int count = std::min(columns, layer - top + 1 + 2 * sideways);
  const int leftmost = ((first - sideways) % columns + columns) % columns;
  unsolve(top, leftmost, count);
  for (int k = 0, ancestor = leftmost; k < count; ++k, ancestor = lattice_.next(ancestor)) {
    if (state_.unsolved[at(top, ancestor)] != 0) state_.unsolved[at(top, ancestor)] = top_of_climb;
  }
  return Mend::climbed;
}

/// The beads `first` .. `first + count - 1` of a layer and all that hangs below them. Whatever hangs below an unsolved
/// bead is unsolved already.
void GranusolveSampler::unsolve(int layer, int first, int count) {
  // A copy, which no store of a byte can change.
  const Lattice lattice = lattice_;
  const std::size_t stride = state_.stride;
  for (; layer <= front_; first = lattice.lower_left(layer, first), ++layer, ++count) {
    bool some_solved = false;
    count = std::min(count, lattice.columns());
    std::uint8_t* const unsolved = state_.unsolved + at(layer, 0);
    const bool at_front = layer == front_;
    for (int k = 0, bead = first; k < count; ++k, bead = lattice.next(bead)) {
      // The bead at the cursor is either being solved right now, and is tried again by whoever called, or the next one.
      if (at_front && position(layer, bead) >= cursor_) {
        forget_draw(bead);
        continue;
      }
      std::uint8_t& state = unsolved[static_cast<std::size_t>(bead) * stride];
      some_solved |= state == 0;
      state = std::max(state, below_climb);
    }
    if (!some_solved) return;
    pending_[static_cast<std::size_t>(layer)].include(first, count, lattice_.columns());
    topmost_pending_ = std::min(topmost_pending_, layer);
  }
}

void GranusolveSampler::Run::include(int other, int others, int columns) {
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

bool GranusolveSampler::solve_pending() {
  for (int layer = topmost_pending_; layer <= front_;) {
    if (solutions_ > max_solutions_) return false;
    topmost_pending_ = lattice_.layers();
    if (eight_at_once_ && layer > 0 ? redraw_in_order(layer) : solve_in_order(layer)) {
      pending_[static_cast<std::size_t>(layer)].count = 0;
      ++layer;
    } else {
      layer = std::min(layer, topmost_pending_);
    }
  }
  topmost_pending_ = lattice_.layers();
  return solutions_ <= max_solutions_;
}

/// The beads of a run in the order of their layer.
class GranusolveSampler::InOrder {
 public:
  InOrder(Run run, RandomKey::Order order, int columns)
      : run_(run), direction_(order.direction), columns_(columns), start_(order.direction > 0 ? 0 : run.count - 1) {
    // The order may begin in the midst of the run.
    const int begins =
        order.first_bead < run.first ? order.first_bead - run.first + columns : order.first_bead - run.first;
    if (begins < run.count) start_ = begins;
  }
  int operator[](int k) const {
    int offset = start_ + direction_ * k;
    offset += offset < 0 ? run_.count : 0;
    offset -= offset >= run_.count ? run_.count : 0;
    const int bead = run_.first + offset;
    return bead >= columns_ ? bead - columns_ : bead;
  }

 private:
  Run run_;
  int direction_, columns_, start_;
};

/// Solves one of them, whatever it takes; false if this layer, or one above it, must be begun anew.
bool GranusolveSampler::solve_one_pending(int layer, int bead) {
  throw_if_interrupted();
  return solve_bead(layer, bead) != Mend::climbed && topmost_pending_ > layer && solutions_ <= max_solutions_;
}

/// Solves the unsolved beads of a layer in its order; false if it must be begun anew.
bool GranusolveSampler::solve_in_order(int layer) {
  const Run run = pending_[static_cast<std::size_t>(layer)];
  const InOrder beads(run, order_[static_cast<std::size_t>(layer)], lattice_.columns());
  for (int k = 0; k < run.count; ++k) {
    if (state_.unsolved[at(layer, beads[k])] != 0 && !solve_one_pending(layer, beads[k])) return false;
  }
  return true;
}

/// The same, below the top layer, with eight numbers at a time.
bool GranusolveSampler::redraw_in_order(int layer) {
  // Copies, which no store of a byte can change.
  const GranusolveState state = state_;
  const FrictionCone cone = cone_;
  const Lattice lattice = lattice_;
  const Run run = pending_[static_cast<std::size_t>(layer)];
  const InOrder in_order(run, order_[static_cast<std::size_t>(layer)], lattice.columns());
  const bool at_front = layer == front_;
  const std::size_t here = at(layer, 0), above = at(layer - 1, 0);
  for (int begin = 0; begin < run.count;) {
    std::array<std::uint32_t, attempts_at_once> beads{}, attempts{};
    std::array<double, attempts_at_once> numbers;
    std::size_t count = 0;
    for (; begin < run.count && count < attempts_at_once; ++begin) {
      const auto bead = static_cast<std::size_t>(in_order[begin]);
      const std::size_t at_bead = here + (bead * state.stride);
      beads[count] = static_cast<std::uint32_t>(bead);
      attempts[count] = state.attempts[at_bead] + 1;
      numbers[count] = state.first_uniform[bead * state.stride];  // at the front nobody has seen what came of it
      count += state.unsolved[at_bead] != 0 ? 1 : 0;
    }
    if (!at_front && count > 0) later_numbers(philox_keys_, key_.sample(), layer, beads, attempts, numbers);
    for (std::size_t k = 0; k < count; ++k) {
      if (solutions_ > max_solutions_) return false;
      const auto bead = static_cast<int>(beads[k]);
      const std::size_t a = above + (static_cast<std::size_t>(lattice.upper_left(layer, bead)) * state.stride);
      const std::size_t b = above + (static_cast<std::size_t>(lattice.upper_right(layer, bead)) * state.stride);
      const Incoming in{state.V_R[a], state.V_L[b], state.H_R[a] + (state.H[b] - state.H_R[b])};
      const Outgoing out = balance(in);
      const Interval interval = split_interval(cone, out, in.H);
      if (unsolvable(out, interval)) {
        if (!solve_one_pending(layer, bead)) return false;
        continue;
      }
      ++solutions_;
      const std::size_t to = here + (beads[k] * state.stride);
      const double H_R = point_at(interval, numbers[k]);
      state.V_R[to] = out.V_R;
      state.V_L[to] = out.V_L;
      state.H[to] = in.H;
      state.H_R[to] = H_R;
      if (state.H_L != nullptr) state.H_L[to] = in.H - H_R;
      state.attempts[to] += at_front ? 0 : 1;
      counts_.uniforms += at_front ? 0 : 1;
      state.unsolved[to] = 0;
      state.rule[to] = static_cast<std::uint8_t>(Rule::first_draw);
    }
  }
  return true;
}

}  // namespace granuscope
