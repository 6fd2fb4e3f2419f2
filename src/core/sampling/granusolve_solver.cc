// How granusolve changes more than two parents of a failing bead: arcs, and the whole ring.
#include "sampling/granusolve_solver.h"

#include <algorithm>
#include <limits>

#include "sampling/layer_kernels.h"
#include "sampling/pile_group.h"
#include "support/progress.h"

namespace granuscope {
namespace {

/// The numbers kept from a first solution came partly from its later attempts; those of the second solution start here,
/// so that they are independent of them.
constexpr std::uint32_t attempts_before_solving_again = std::uint32_t{1} << 23;

}  // namespace

GranusolveDraws::GranusolveDraws(std::uint64_t seed, GranusolveState& state, GranusolveWork& work)
    : state_(state),
      work_(work),
      key_(seed, 0),
      philox_keys_(seed),
      slack_(static_cast<std::size_t>(state.lattice().columns())),
      from_left_(slack_.size()),
      from_right_(slack_.size()),
      half_across_(slack_.size()) {}

std::uint32_t GranusolveDraws::begin_pile(std::uint64_t sample, const Pile* first) {
  key_ = RandomKey(key_.seed(), sample);
  first_ = first;
  if (first != nullptr) read_split_uniforms(*first, first_numbers_);
  eight_at_once_ = first == nullptr && state_.drawn() == DrawnVariable::force && !PlainKernels::in_use();
  return first == nullptr ? 0 : attempts_before_solving_again;
}

void GranusolveDraws::begin_layer(int layer) {
  state_.move_cursor(layer, 0, state_.order(layer).first_bead);
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t here = state_.at(layer, 0), columns = slack_.size();
  std::fill_n(&arrays.attempts[here], columns, state_.attempts_at_first());
  std::fill_n(&arrays.unsolved[here], columns, std::uint8_t{0});
  std::fill_n(&arrays.rule[here], columns, static_cast<std::uint8_t>(GranusolveRule::first_draw));
  std::fill_n(&arrays.backtracks[here], columns, std::uint8_t{0});
  draw_in_bulk(layer);
  find_failing(slack_.data(), slack_.size(), arrays.failing);
  if (first_ != nullptr) keep_splits(layer);
  if (first_ == nullptr && state_.drawn() != DrawnVariable::force) draw_other_variable(layer);
  work_.solutions += columns;
  if (first_ == nullptr) work_.counts.uniforms += columns;
}

void GranusolveDraws::draw_in_bulk(int layer) {
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t columns = slack_.size();
  if (first_ == nullptr) {
    fill_first_uniforms(key_.seed(), key_.sample(), layer, arrays.first_uniform, columns);
  } else {
    std::copy_n(&first_numbers_[state_.at(layer, 0)], columns, arrays.first_uniform);
  }
  const auto row = [&](std::size_t from) {
    const std::size_t here = state_.at(layer, 0) + from;
    return LowerRow{.V_R = &arrays.V_R[here],
                    .V_L = &arrays.V_L[here],
                    .H = &arrays.H[here],
                    .H_R = &arrays.H_R[here],
                    .H_L = &arrays.H_L[here],
                    .slack = &slack_[from]};
  };
  const FrictionCone& cone = state_.cone();
  const double half_weight = state_.half_weight();
  if (layer == 0) {
    for (std::size_t i = 0; i < columns; ++i) {
      const Incoming load = top_load(state_.load()[i], state_.load_line());
      from_left_[i] = load.V_UL;
      from_right_[i] = load.V_UR;
      half_across_[i] = load.H / 2;
    }
    const double* const across = half_across_.data();
    draw_beads(cone,
               {.V_UL = from_left_.data(),
                .V_UR = from_right_.data(),
                .H_UL = across,
                .H_UR = across,
                .half_weight = half_weight},
               arrays.first_uniform, columns, row(0));
    return;
  }
  const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
    const std::size_t a = state_.at(layer - 1, 0) + upper_left, b = state_.at(layer - 1, 0) + upper_right;
    return UpperRow{.V_UL = &arrays.V_R[a],
                    .V_UR = &arrays.V_L[b],
                    .H_UL = &arrays.H_R[a],
                    .H_UR = &arrays.H_L[b],
                    .half_weight = half_weight};
  };
  // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
  const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
  draw_beads(cone, above(0, 1), &arrays.first_uniform[first], columns - 1, row(first));
  draw_beads(cone, above(columns - 1, 0), &arrays.first_uniform[seam], 1, row(seam));
}

/// What kept_split adds to the numbers that the layer was drawn in bulk with.
void GranusolveDraws::keep_splits(int layer) {
  const GranusolveArrays& arrays = state_.arrays();
  for (int bead = 0; bead < state_.lattice().columns(); ++bead) {
    const std::size_t here = state_.at(layer, bead);
    if (arrays.V_R[here] == first_->V_R[here] && arrays.V_L[here] == first_->V_L[here]) {
      state_.set_split(layer, bead, first_->H_R[here]);
    }
  }
}

/// The splits of another variable than the force, with the numbers that the layer was drawn in bulk with.
void GranusolveDraws::draw_other_variable(int layer) {
  for (int bead = 0; bead < state_.lattice().columns(); ++bead) {
    if (slack_[static_cast<std::size_t>(bead)] < 0) continue;
    state_.set_split(
        layer, bead,
        state_.split_on(layer, bead, state_.interval_of(layer, bead), state_.arrays().first_uniform[state_.at(bead)]));
  }
}

inline double GranusolveDraws::choose_split(int layer, int bead, Outgoing out, Interval interval) {
  const std::size_t here = state_.at(layer, bead);
  if (first_ != nullptr && state_.arrays().unsolved[here] != top_of_backtrack) {
    return kept_split(*first_, here, first_numbers_[here], out, interval);
  }
  // At the front nobody has seen what came of the bead's first number.
  if (first_ == nullptr && layer == state_.front()) {
    return state_.split_on(layer, bead, interval, state_.arrays().first_uniform[state_.at(bead)]);
  }
  return state_.split_on(layer, bead, interval, next_uniforms(layer, bead, 1).first);
}

bool GranusolveDraws::try_draw(int layer, int bead) {
  const FrictionCone& cone = state_.cone();
  Incoming in = state_.incoming(layer, bead);
  Outgoing out = balance(cone, in);
  Interval interval = split_interval(cone, out, in.H);
  if (unsolvable(out, interval)) {
    if (!misses_by_rounding(cone, in)) return false;
    in.H = nearest_solvable(cone, in);
    ++work_.counts.rounded;
    out = balance(cone, in);
    interval = closed(split_interval(cone, out, in.H));
  }
  const GranusolveArrays& arrays = state_.arrays();
  const std::size_t here = state_.at(layer, bead);
  arrays.V_R[here] = out.V_R;
  arrays.V_L[here] = out.V_L;
  arrays.H[here] = in.H;
  state_.set_split(layer, bead, choose_split(layer, bead, out, interval));
  arrays.unsolved[here] = 0;
  return true;
}

void GranusolveDraws::renew_child(int layer, int bead) {
  if (!state_.solved(layer, bead)) {
    if (state_.awaits_turn(layer, bead)) state_.forget_draw(bead);
    return;
  }
  ++work_.solutions;
  if (!try_draw(layer, bead)) {
    // Beyond the rounding allowance after all: it waits like a bead that a backtrack has unsolved.
    state_.unsolve(layer, bead, 1);
  } else if (layer < state_.front()) {
    state_.unsolve(layer + 1, state_.lattice().lower_left(layer, bead), 2);
  }
}

void GranusolveDraws::next_numbers(const ParentArc& arc, int from, std::vector<double>& numbers) {
  constexpr int at_once = attempts_at_once;
  for (int begin = from; begin < arc.count; begin += at_once) {
    const int count = std::min(at_once, arc.count - begin);
    std::array<std::uint32_t, attempts_at_once> beads{}, attempts{};
    std::array<double, attempts_at_once> found{};
    for (int k = 0; k < count; ++k) {
      const auto here = static_cast<std::size_t>(k);
      const int bead = parent_of(state_.lattice(), arc, begin + k);
      beads[here] = static_cast<std::uint32_t>(bead);
      attempts[here] = ++state_.arrays().attempts[state_.at(arc.layer - 1, bead)];
      if (!eight_at_once_) found[here] = key_.attempt(arc.layer - 1, bead, attempts[here]).first;
    }
    if (eight_at_once_) later_numbers(philox_keys_, key_.sample(), arc.layer - 1, beads, attempts, found);
    std::copy_n(found.begin(), count, numbers.begin() + begin);
    work_.counts.uniforms += static_cast<std::uint64_t>(count);
  }
}

namespace {

constexpr int lowest_backtrack = 2;  // layers, of the first backtrack that sets out from a bead

}  // namespace

GranusolveRules::GranusolveRules(RepairRules rules, GranusolveState& state, GranusolveDraws& draws,
                                 GranusolveWork& work)
    : pairs_(rules == RepairRules::all || rules == RepairRules::no_arcs),
      arcs_(rules == RepairRules::all || rules == RepairRules::no_pair),
      state_(state),
      draws_(draws),
      work_(work),
      own_(static_cast<std::size_t>(state.lattice().columns())),
      filter_(own_.size()),
      bands_(own_.size()),
      split_(own_.size()),
      numbers_(own_.size()) {}

bool GranusolveRules::change_parents(int layer, int bead, bool no_pair) {
  if (pairs_ && !no_pair && repair_by_pair(layer, bead)) return true;
  if (!arcs_ || infeasible_alone(layer, bead)) return false;
  for (int parents = 4; parents < state_.lattice().columns(); parents *= 2) {
    const ArcOutcome outcome = repair_by_arc(layer, bead, parents);
    if (outcome != ArcOutcome::too_narrow) return outcome == ArcOutcome::repaired;
  }
  return repair_by_ring(layer, bead);
}

/// Whether splits that were drawn uniformly for both parents are kept, so that each has the density of its own law.
bool GranusolveRules::keeps_pair(int layer, int bead, const PairDraw& pair) {
  const GranusolveArrays& arrays = state_.arrays();
  const auto share = [&](int parent, double H_R) {
    const std::size_t at = state_.at(layer - 1, parent);
    return kept_share(state_.drawn(), {arrays.V_R[at], arrays.V_L[at]}, arrays.H[at],
                      state_.interval_of(layer - 1, parent), H_R);
  };
  const UniformPair u = draws_.next_uniforms(layer, bead, 2);
  return u.first < share(state_.lattice().upper_left(layer, bead), pair.a) &&
         u.second < share(state_.lattice().upper_right(layer, bead), pair.b);
}

bool GranusolveRules::repair_by_pair(int layer, int bead) {
  const Lattice& lattice = state_.lattice();
  const int A = lattice.upper_left(layer, bead), B = lattice.upper_right(layer, bead);
  Interval a = state_.interval_of(layer - 1, A), b = state_.interval_of(layer - 1, B);
  // The other child of A hangs between its own upper-left parent and A, the other child of B between B and another.
  const int left = lattice.previous(bead), right = lattice.next(bead);
  const bool left_solved = state_.solved(layer, left), right_solved = state_.solved(layer, right);
  const double* const H_R = state_.arrays().H_R;
  if (left_solved) {
    const double held = H_R[state_.at(layer - 1, lattice.upper_left(layer, left))];
    const Interval band = state_.difference_band(layer, left);
    a = intersection(a, {held - band.high, held - band.low});
  }
  if (right_solved) {
    const double held = H_R[state_.at(layer - 1, lattice.upper_right(layer, right))];
    const Interval band = state_.difference_band(layer, right);
    b = intersection(b, {held + band.low, held + band.high});
  }
  const Interval band = state_.difference_band(layer, bead);
  if (a.empty() || b.empty() || std::max(band.low, a.low - b.high) > std::min(band.high, a.high - b.low)) {
    return false;
  }
  std::optional<PairDraw> drawn;
  do {
    const UniformPair u = draws_.next_uniforms(layer, bead, 2);
    drawn = draw_truncated_pair(a, b, band, u.first, u.second);
    if (!drawn) return false;
  } while (state_.drawn() != DrawnVariable::force && !keeps_pair(layer, bead, *drawn));
  ++work_.counts.pairs;
  state_.set_split(layer - 1, A, drawn->a);
  state_.set_split(layer - 1, B, drawn->b);
  state_.set_rule(state_.at(layer, bead), GranusolveRule::pair);
  draws_.renew_child(layer, left);
  draws_.renew_child(layer, right);
  return true;
}

SolveResult GranusolveRules::backtrack(int layer, int bead) {
  const Lattice& lattice = state_.lattice();
  const GranusolveArrays& arrays = state_.arrays();
  ++work_.counts.backtracks;
  std::uint8_t& backtracks = arrays.backtracks[state_.at(layer, bead)];
  const int height = lowest_backtrack + backtracks, top = std::max(0, layer - height);
  // Repairs of the topmost unsolved layer change the one above it, and whoever keeps a window has read that one's
  // neighbours as final.
  if (state_.front() - top > arrays.window - 4) return SolveResult::beyond_window;
  if (backtracks < std::numeric_limits<std::uint8_t>::max()) ++backtracks;
  const int sideways = height - (layer - top);
  int first = bead;
  for (int n = layer; n > top; --n) first = lattice.upper_left(n, first);
  const int columns = lattice.columns();
  const int count = std::min(columns, layer - top + 1 + 2 * sideways);
  const int leftmost = ((first - sideways) % columns + columns) % columns;
  state_.unsolve(top, leftmost, count);
  for (int k = 0, ancestor = leftmost; k < count; ++k, ancestor = lattice.next(ancestor)) {
    std::uint8_t& unsolved = arrays.unsolved[state_.at(top, ancestor)];
    if (unsolved != 0) unsolved = top_of_backtrack;
  }
  return SolveResult::unsolved_above;
}

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
      const Outgoing out = balance(cone, in);
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

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

}  // namespace

/// The bead between parents k and k + 1 of the arc.
int GranusolveRules::child_after(const ParentArc& arc, int k) const {
  return arc.step > 0 ? state_.lattice().lower_right(arc.layer - 1, parent(arc, k))
                      : state_.lattice().lower_left(arc.layer - 1, parent(arc, k));
}

/// Band of H_R(parent k) - H_R(parent k + 1); everything if the bead between them is not solved and not the failed one.
Interval GranusolveRules::step_band(const ParentArc& arc, int k, int failed) const {
  const int child = child_after(arc, k);
  if (child != failed && !state_.solved(arc.layer, child)) return {-unbounded, unbounded};
  const Interval band = state_.difference_band(arc.layer, child);
  return arc.step > 0 ? band : Interval{-band.high, -band.low};
}

/// Given split_[from], draws split_[from - 1] .. split_[to], each uniformly on what the filter and the one drawn before
/// leave.
void GranusolveRules::draw_backwards(const ParentArc& arc, int from, int to) {
  for (int k = from - 1; k >= to; --k) {
    const auto here = static_cast<std::size_t>(k);
    const Interval reach{split_[here + 1] + bands_[here].low, split_[here + 1] + bands_[here].high};
    // The filter holds a solution; only rounding can leave none. The bead below is then within rounding of its band.
    split_[here] =
        state_.split_on(arc.layer - 1, parent(arc, k), closed(intersection(filter_[here], reach)), numbers_[here]);
  }
}

/// The parents take the splits drawn for them; their children other than the failed bead are renewed, of a ring once.
void GranusolveRules::set_splits(const ParentArc& arc, int bead, GranusolveRule rule) {
  for (int k = 0; k < arc.count; ++k) {
    state_.set_split(arc.layer - 1, parent(arc, k), split_[static_cast<std::size_t>(k)]);
  }
  state_.set_rule(state_.at(arc.layer, bead), rule);
  for (int k = rule == GranusolveRule::ring ? 0 : -1; k < arc.count; ++k) {
    if (const int child = child_after(arc, k); child != bead) draws_.renew_child(arc.layer, child);
  }
}

/// Whether even the bead's own two parents, with all others let go, cannot help it: then every arc is infeasible.
bool GranusolveRules::infeasible_alone(int layer, int bead) const {
  const Interval a = state_.interval_of(layer - 1, state_.lattice().upper_left(layer, bead));
  const Interval b = state_.interval_of(layer - 1, state_.lattice().upper_right(layer, bead));
  const Interval band = state_.difference_band(layer, bead);
  // As the filter along the arc goes, which rounds otherwise the other way.
  return state_.order(layer).direction > 0 ? intersection(b, {a.low - band.high, a.high - band.low}).empty()
                                           : intersection(a, {b.low + band.low, b.high + band.high}).empty();
}

GranusolveRules::ArcOutcome GranusolveRules::repair_by_arc(int layer, int bead, int parents) {
  const int step = state_.order(layer).direction;
  // The failed bead hangs below the arc's two middle parents.
  const int near = step > 0 ? state_.lattice().upper_left(layer, bead) : state_.lattice().upper_right(layer, bead);
  const int columns = state_.lattice().columns(), first = near - step * (parents / 2 - 1);
  const ParentArc arc{layer, first < 0 ? first + columns : first % columns, parents, step};
  const int last = parents - 1;
  const auto filtered = [&](std::size_t k) {
    const Interval before = filter_[k - 1], band = bands_[k - 1];
    return intersection(own_[k], {before.low - band.high, before.high - band.low});
  };
  // First as if nothing were held, and no farther than it goes.
  for (int k = 0; k < parents; ++k) {
    const auto here = static_cast<std::size_t>(k);
    own_[here] = state_.interval_of(layer - 1, parent(arc, k));
    filter_[here] = k == 0 ? own_[here] : filtered(here);
    if (filter_[here].empty()) return ArcOutcome::infeasible;
    bands_[here] = step_band(arc, k, bead);
  }
  // The parents next to the arc are held: parent -1 through the band before the arc, parent `parents` through the last.
  const double before = state_.arrays().H_R[state_.at(layer - 1, parent(arc, -1))];
  const double after = state_.arrays().H_R[state_.at(layer - 1, parent(arc, parents))];
  const Interval band_before = step_band(arc, -1, bead), band_after = bands_[static_cast<std::size_t>(last)];
  filter_[0] = intersection(own_[0], {before - band_before.high, before - band_before.low});
  for (int k = 0; k < parents; ++k) {
    const auto here = static_cast<std::size_t>(k);
    if (k > 0) filter_[here] = filtered(here);
    if (k == last) filter_[here] = intersection(filter_[here], {after + band_after.low, after + band_after.high});
    if (filter_[here].empty()) return ArcOutcome::too_narrow;
  }
  ++work_.counts.arcs;
  draws_.next_numbers(arc, 0, numbers_);
  split_[static_cast<std::size_t>(last)] = state_.split_on(
      layer - 1, parent(arc, last), filter_[static_cast<std::size_t>(last)], numbers_[static_cast<std::size_t>(last)]);
  draw_backwards(arc, last, 0);
  set_splits(arc, bead, GranusolveRule::arc);
  return ArcOutcome::repaired;
}

bool GranusolveRules::repair_by_ring(int layer, int bead) {
  const int columns = state_.lattice().columns();
  const int step = state_.order(layer).direction;
  // Pinned first is the parent that the layer's direction reaches first, so that the law keeps its mirror symmetry.
  const int near = step > 0 ? state_.lattice().upper_left(layer, bead) : state_.lattice().upper_right(layer, bead);
  const ParentArc ring{layer, near, columns, step};
  const auto wrap = [&](int k) { return static_cast<std::size_t>(k >= columns ? k - columns : k); };
  for (int k = 0; k < columns; ++k) {
    own_[wrap(k)] = state_.interval_of(layer - 1, parent(ring, k));
    bands_[wrap(k)] = step_band(ring, k, bead);
  }
  // Difference constraints on a cycle: after two rounds each way every interval is the exact shadow of the solutions.
  // One round would do for the law: it rests on the first parent's interval alone, which both sweeps end at and no
  // shortest path passes on its way; of the others only points that complete to a solution are ever drawn. The second
  // round finds more of the infeasible rings before a number is spent on them.
  for (int round = 0; round < 2; ++round) {
    for (int k = 0; k < columns; ++k) {
      const Interval& from = own_[wrap(k)];
      own_[wrap(k + 1)] =
          intersection(own_[wrap(k + 1)], {from.low - bands_[wrap(k)].high, from.high - bands_[wrap(k)].low});
    }
    for (int k = columns - 1; k >= 0; --k) {
      const Interval& from = own_[wrap(k + 1)];
      own_[wrap(k)] = intersection(own_[wrap(k)], {from.low + bands_[wrap(k)].low, from.high + bands_[wrap(k)].high});
    }
  }
  for (int k = 0; k < columns; ++k) {
    if (own_[wrap(k)].empty()) return false;
  }
  // One parent is drawn; the others are an arc that starts and ends at it.
  const double pinned =
      state_.split_on(layer - 1, parent(ring, 0), own_[0], draws_.next_uniforms(layer - 1, parent(ring, 0), 1).first);
  filter_[0] = {pinned, pinned};
  for (int k = 1; k < columns; ++k) {
    filter_[wrap(k)] = intersection(own_[wrap(k)], {filter_[wrap(k - 1)].low - bands_[wrap(k - 1)].high,
                                                    filter_[wrap(k - 1)].high - bands_[wrap(k - 1)].low});
  }
  const int last = columns - 1;
  filter_[wrap(last)] =
      intersection(filter_[wrap(last)], {pinned + bands_[wrap(last)].low, pinned + bands_[wrap(last)].high});
  for (int k = 0; k < columns; ++k) {
    if (filter_[wrap(k)].empty()) return false;
  }
  ++work_.counts.rings;
  split_[0] = pinned;
  draws_.next_numbers(ring, 1, numbers_);
  split_[wrap(last)] = state_.split_on(layer - 1, parent(ring, last), filter_[wrap(last)], numbers_[wrap(last)]);
  draw_backwards(ring, last, 1);
  set_splits(ring, bead, GranusolveRule::ring);
  return true;
}

}  // namespace granuscope
