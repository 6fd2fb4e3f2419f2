#include "sampling/granusolve_solver.h"

#include <algorithm>
#include <array>

#include "sampling/layer_kernels.h"
#include "support/interruption.h"

namespace granuscope {
namespace {

/// The beads of a run in the order of their layer.
class InOrder {
 public:
  InOrder(BeadRun run, RandomKey::Order order, int columns)
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
  BeadRun run_;
  int direction_, columns_, start_;
};

}  // namespace

GranusolveSolver::GranusolveSolver(const SamplerSpec& spec, const Lattice& lattice)
    : layer_order_(spec.order),
      state_(spec, lattice),
      work_{.counts = {},
            .solutions = 0,
            .max_solutions = static_cast<std::uint64_t>(spec.effort * static_cast<double>(lattice.beads()))},
      draws_(spec.seed, state_, work_),
      rules_(spec.rules, state_, draws_, work_) {}

void GranusolveSolver::begin_pile(std::uint64_t sample, std::span<const double> load, const Pile* first) {
  const std::uint32_t attempts_at_first = draws_.begin_pile(sample, first);
  state_.begin_pile(draws_.key(), layer_order_, load, attempts_at_first);
  work_.solutions = 0;
  ++work_.counts.tries;
}

void GranusolveSolver::count_pile(const std::array<std::uint64_t, granusolve_rules>& beads_by) {
  const auto by = [&](GranusolveRule rule) { return beads_by[static_cast<std::size_t>(rule)]; };
  work_.counts.beads += state_.lattice().beads();
  work_.counts.repaired_by_pair += by(GranusolveRule::pair);
  work_.counts.repaired_by_arc += by(GranusolveRule::arc);
  work_.counts.repaired_by_ring += by(GranusolveRule::ring);
  work_.counts.backtracked += by(GranusolveRule::backtrack);
}

void GranusolveSolver::count_bulk_draw() {
  const auto columns = static_cast<std::uint64_t>(state_.lattice().columns());
  work_.solutions += columns;
  work_.counts.uniforms += columns;
}

void GranusolveSolver::count_pairs(std::uint64_t beads) {
  // Each of them has one solved neighbour, which draws again with it.
  work_.solutions += 2 * beads;
  work_.counts.uniforms += 2 * beads;
  work_.counts.pairs += beads;
}

// ---------------------------------------------------------------------------------------------- one layer

SolveResult GranusolveSolver::solve_layer(int layer) {
  draws_.begin_layer(layer);
  for (int bead = state_.next_failing(); bead >= 0; bead = state_.next_failing()) {
    if (const SolveResult result = solve_failing(bead); result != SolveResult::solved) return result;
  }
  return end_layer(layer);
}

SolveResult GranusolveSolver::solve_at(int layer, int position, int bead, bool no_pair) {
  state_.move_cursor(layer, position, bead);
  return solve_failing(bead, no_pair);
}

SolveResult GranusolveSolver::end_layer(int layer) {
  state_.move_cursor(layer, state_.lattice().columns(), -1);
  if (checks_granusolve_state) state_.check();
  return work_.exhausted() ? SolveResult::out_of_effort : SolveResult::solved;
}

/// Solves the bead at the cursor, whatever it takes.
SolveResult GranusolveSolver::solve_failing(int bead, bool no_pair) {
  const int front = state_.front();
  SolveResult result = no_pair ? repair(front, bead, true) : solve_counted(front, bead);
  while (result == SolveResult::unsolved_above) {
    throw_if_interrupted();
    if (const SolveResult above = solve_pending(); above != SolveResult::solved) return above;
    result = solve_bead(front, bead);
  }
  if (result != SolveResult::solved) return result;
  state_.step_cursor();
  // A child that rounding left unsolvable waits as pending even without a backtrack.
  return state_.topmost_pending() > front ? SolveResult::solved : solve_pending();
}

// ---------------------------------------------------------------------------------------------- one bead

SolveResult GranusolveSolver::solve_bead(int layer, int bead) {
  ++work_.solutions;
  return solve_counted(layer, bead);
}

/// Changes the splits above so that the bead has a solution, and draws it; or backtracks.
SolveResult GranusolveSolver::repair(int layer, int bead, bool no_pair) {
  if (rules_.change_parents(layer, bead, no_pair)) {
    ++work_.solutions;
    // After a change of parents the bead is solvable up to rounding; should rounding exceed its allowance, backtrack.
    if (draws_.try_draw(layer, bead)) return SolveResult::solved;
  }
  return rules_.backtrack(layer, bead);
}

// ---------------------------------------------------------------------------------------------- after a backtrack

/// Solves everything that a backtrack has unsolved, topmost layer first.
SolveResult GranusolveSolver::solve_pending() {
  for (int layer = state_.topmost_pending(); layer <= state_.front();) {
    if (work_.exhausted()) return SolveResult::out_of_effort;
    state_.watch_pending();
    const SolveResult result = draws_.eight_at_once() && layer > 0 ? redraw_row(layer) : solve_row(layer);
    if (result == SolveResult::beyond_window) return result;
    if (result == SolveResult::solved) {
      if (checks_granusolve_state) state_.check_run(layer, state_.pending(layer));
      state_.clear_pending(layer);
      ++layer;
    } else {
      layer = std::min(layer, state_.topmost_pending());
    }
  }
  state_.watch_pending();
  return work_.exhausted() ? SolveResult::out_of_effort : SolveResult::solved;
}

/// Solves one of them, whatever it takes; unsolved_above if this layer, or one above it, must be begun anew.
SolveResult GranusolveSolver::solve_one_pending(int layer, int bead) {
  throw_if_interrupted();
  const SolveResult result = solve_bead(layer, bead);
  if (result != SolveResult::solved) return result;
  if (state_.topmost_pending() <= layer) return SolveResult::unsolved_above;
  return work_.exhausted() ? SolveResult::out_of_effort : SolveResult::solved;
}

/// Solves the unsolved beads of a layer in its order; unsolved_above if it must be begun anew.
SolveResult GranusolveSolver::solve_row(int layer) {
  const BeadRun run = state_.pending(layer);
  const InOrder beads(run, state_.order(layer), state_.lattice().columns());
  for (int k = 0; k < run.count; ++k) {
    if (state_.arrays().unsolved[state_.at(layer, beads[k])] == 0) continue;
    if (const SolveResult result = solve_one_pending(layer, beads[k]); result != SolveResult::solved) return result;
  }
  return SolveResult::solved;
}

/// The same, below the top layer, with eight numbers at a time.
SolveResult GranusolveSolver::redraw_row(int layer) {
  // Copies, which no store of a byte can change.
  const GranusolveArrays arrays = state_.arrays();
  const FrictionCone cone = state_.cone();
  const Lattice lattice = state_.lattice();
  const BeadRun run = state_.pending(layer);
  const InOrder in_order(run, state_.order(layer), lattice.columns());
  const bool at_front = layer == state_.front();
  const double half_weight = state_.half_weight();
  const std::size_t here = state_.at(layer, 0), above = state_.at(layer - 1, 0);
  for (int begin = 0; begin < run.count;) {
    std::array<std::uint32_t, attempts_at_once> beads{}, attempts{};
    std::array<double, attempts_at_once> numbers;
    std::size_t count = 0;
    for (; begin < run.count && count < attempts_at_once; ++begin) {
      const auto bead = static_cast<std::size_t>(in_order[begin]);
      const std::size_t at_bead = here + (bead * arrays.stride);
      beads[count] = static_cast<std::uint32_t>(bead);
      attempts[count] = arrays.attempts[at_bead] + 1;
      numbers[count] = arrays.first_uniform[bead * arrays.stride];  // at the front nobody has seen what came of it
      count += arrays.unsolved[at_bead] != 0 ? 1 : 0;
    }
    if (!at_front && count > 0) {
      later_numbers(draws_.philox_keys(), draws_.key().sample(), layer, beads, attempts, numbers);
    }
    for (std::size_t k = 0; k < count; ++k) {
      if (work_.exhausted()) return SolveResult::out_of_effort;
      const auto bead = static_cast<int>(beads[k]);
      const std::size_t a = above + (static_cast<std::size_t>(lattice.upper_left(layer, bead)) * arrays.stride);
      const std::size_t b = above + (static_cast<std::size_t>(lattice.upper_right(layer, bead)) * arrays.stride);
      const Incoming in =
          with_weight({arrays.V_R[a], arrays.V_L[b], arrays.H_R[a] + (arrays.H[b] - arrays.H_R[b])}, half_weight);
      const Outgoing out = balance(in);
      const Interval interval = split_interval(cone, out, in.H);
      if (unsolvable(out, interval)) {
        if (const SolveResult result = solve_one_pending(layer, bead); result != SolveResult::solved) return result;
        continue;
      }
      ++work_.solutions;
      const std::size_t to = here + (beads[k] * arrays.stride);
      const double H_R = point_at(interval, numbers[k]);
      arrays.V_R[to] = out.V_R;
      arrays.V_L[to] = out.V_L;
      arrays.H[to] = in.H;
      arrays.H_R[to] = H_R;
      if (arrays.H_L != nullptr) arrays.H_L[to] = in.H - H_R;
      arrays.attempts[to] += at_front ? 0 : 1;
      work_.counts.uniforms += at_front ? 0 : 1;
      arrays.unsolved[to] = 0;
      arrays.rule[to] = static_cast<std::uint8_t>(GranusolveRule::first_draw);
    }
  }
  return SolveResult::solved;
}

}  // namespace granuscope
