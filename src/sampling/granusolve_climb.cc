// Climbing: what is unsolved above a bead that no change of its parents helps, and how it is solved again.
#include <algorithm>
#include <array>
#include <limits>

#include "sampling/granusolve.h"
#include "sampling/layer_kernels.h"

namespace granuscope {

void GranusolveSampler::climb(int layer, int bead) {
  ++counts_.climbs;
  std::uint8_t& climbs = state_.climbs[at(layer, bead)];
  const int height = 2 + climbs;
  if (climbs < std::numeric_limits<std::uint8_t>::max()) ++climbs;
  const int top = std::max(0, layer - height);
  // Mends of the topmost unsolved layer change the one above it, and whoever keeps a window has read that one's
  // neighbours as final.
  if (front_ - top > window_ - 4) {
    beyond_window_ = true;
    solutions_ = max_solutions_ + 1;
    return;
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
}

/// The beads `first` .. `first + count - 1` of a layer and all that hangs below them. Whatever hangs below an unsolved
/// bead is unsolved already.
void GranusolveSampler::unsolve(int layer, int first, int count) {
  bool some_solved = true;
  for (; layer <= front_ && some_solved; first = lattice_.lower_left(layer, first), ++layer, ++count) {
    some_solved = false;
    count = std::min(count, lattice_.columns());
    for (int k = 0, bead = first; k < count; ++k, bead = lattice_.next(bead)) {
      // The bead at the cursor is either being solved right now, and is tried again by whoever called, or the next one.
      if (layer == front_ && position(layer, bead) >= cursor_) {
        forget_draw(bead);
        continue;
      }
      std::uint8_t& state = state_.unsolved[at(layer, bead)];
      if (state != 0) continue;
      state = below_climb;
      some_solved = true;
      pending_[static_cast<std::size_t>(layer)].push_back(bead);
      topmost_pending_ = std::min(topmost_pending_, layer);
    }
  }
}

bool GranusolveSampler::solve_pending() {
  int layer = topmost_pending_;
  while (layer <= front_) {
    const int bead = rows_ ? redraw_in_order(layer) : next_pending(layer);
    if (bead < 0) {
      ++layer;
      continue;
    }
    if (solutions_ > max_solutions_) return false;
    topmost_pending_ = lattice_.layers();
    if (solve_bead(layer, bead) == Mend::climbed) {
      layer = std::min(layer, topmost_pending_);
    }
  }
  topmost_pending_ = lattice_.layers();
  return solutions_ <= max_solutions_;
}

int GranusolveSampler::next_pending(int layer) {
  auto& beads = pending_[static_cast<std::size_t>(layer)];
  std::erase_if(beads, [&](int bead) { return state_.unsolved[at(layer, bead)] == 0; });
  const auto first = std::min_element(beads.begin(), beads.end(),
                                      [&](int a, int b) { return position(layer, a) < position(layer, b); });
  return first == beads.end() ? -1 : *first;
}

/// Draws the unsolved beads of a layer in its order as long as they have a solution as they are; returns the first that
/// has none, or -1. What next_pending and solve_bead do in turn, without looking for each bead anew, and with eight
/// numbers at a time.
int GranusolveSampler::redraw_in_order(int layer) {
  if (layer == 0) return next_pending(layer);
  auto& beads = pending_[static_cast<std::size_t>(layer)];
  // Copies, which no store of a byte can change.
  const GranusolveState state = state_;
  const FrictionCone cone = cone_;
  const Lattice lattice = lattice_;
  const bool at_front = layer == front_;
  const std::size_t here = at(layer, 0), above = at(layer - 1, 0);
  row_.clear();
  for (const int bead : beads) {
    if (state.unsolved[here + at(bead)] == 0) continue;
    row_.push_back(static_cast<std::uint64_t>(position(layer, bead)) << 32 | static_cast<std::uint64_t>(bead));
  }
  beads.clear();
  std::sort(row_.begin(), row_.end());
  for (std::size_t begin = 0; begin < row_.size(); begin += attempts_at_once) {
    const std::size_t count = std::min(attempts_at_once, row_.size() - begin);
    std::array<std::uint32_t, attempts_at_once> bead{}, attempt{};
    std::array<double, attempts_at_once> number;
    for (std::size_t k = 0; k < count; ++k) {
      bead[k] = static_cast<std::uint32_t>(row_[begin + k]);
      attempt[k] = state.attempts[here + (bead[k] * state.stride)] + 1;
      if (at_front) number[k] = state.first_uniform[bead[k] * state.stride];
    }
    if (!at_front) later_numbers(philox_keys_, key_.sample(), layer, bead, attempt, number);
    for (std::size_t k = 0; k < count; ++k) {
      const auto index = static_cast<int>(bead[k]);
      const std::size_t a = above + (static_cast<std::size_t>(lattice.upper_left(layer, index)) * state.stride);
      const std::size_t b = above + (static_cast<std::size_t>(lattice.upper_right(layer, index)) * state.stride);
      const Incoming in{state.V_R[a], state.V_L[b], state.H_R[a] + (state.H[b] - state.H_R[b])};
      const Outgoing out = balance(in);
      const Interval interval = split_interval(cone, out, in.H);
      if (unsolvable(out, interval) || solutions_ > max_solutions_) {
        for (std::size_t rest = begin + k; rest < row_.size(); ++rest) {
          beads.push_back(static_cast<int>(static_cast<std::uint32_t>(row_[rest])));
        }
        return index;
      }
      ++solutions_;
      const std::size_t to = here + (bead[k] * state.stride);
      if (!at_front) {
        state.attempts[to] = attempt[k];
        ++counts_.uniforms;
      }
      const double H_R = point_at(interval, number[k]);
      state.V_R[to] = out.V_R;
      state.V_L[to] = out.V_L;
      state.H[to] = in.H;
      state.H_R[to] = H_R;
      if (state.H_L != nullptr) state.H_L[to] = in.H - H_R;
      state.unsolved[to] = 0;
      state.rule[to] = static_cast<std::uint8_t>(Rule::first_draw);
    }
  }
  return -1;
}

}  // namespace granuscope
