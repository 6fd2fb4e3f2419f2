#include "sampling/granusolve.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sampling/granusolve_group.h"
#include "sampling/layer_kernels.h"
#include "sampling/rounding.h"
#include "sampling/truncated_pair.h"
#include "support/interruption.h"

namespace granuscope {

GranusolveSampler::GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      cone_(spec.mu),
      spec_(spec),
      philox_keys_(spec.seed),
      order_(static_cast<std::size_t>(lattice.layers())),
      pending_(static_cast<std::size_t>(lattice.layers())),
      slack_(static_cast<std::size_t>(lattice.columns())),
      half_load_(static_cast<std::size_t>(lattice.columns())),
      no_force_(static_cast<std::size_t>(lattice.columns())) {
  const auto columns = static_cast<std::size_t>(lattice.columns());
  own_.resize(columns);
  filter_.resize(columns);
  bands_.resize(columns);
  split_.resize(columns);
  numbers_.resize(columns);
  max_solutions_ = static_cast<std::uint64_t>(spec.effort * static_cast<double>(lattice.beads()));
}

/// Arrays of its own, for a pile that is solved by itself; each layer is cleared when it is begun.
void GranusolveSampler::use_own_state(Pile& pile) {
  const std::size_t beads = lattice_.beads(), columns = static_cast<std::size_t>(lattice_.columns());
  own_H_.resize(beads);
  own_first_uniform_.resize(columns + uniform_padding);
  own_failing_.resize((columns + 63) / 64);
  own_attempts_.resize(beads);
  own_unsolved_.resize(beads);
  own_rule_.resize(beads);
  own_climbs_.resize(beads);
  state_ = {pile.V_R.data(),    pile.V_L.data(),           pile.H_R.data(),      pile.H_L.data(),
            own_H_.data(),      own_attempts_.data(),      own_unsolved_.data(), own_rule_.data(),
            own_climbs_.data(), own_first_uniform_.data(), own_failing_.data(),  nullptr};
}

std::optional<SamplingFailure> GranusolveSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  first_ = nullptr;
  return solve_pile(sample, load, pile);
}

std::optional<SamplingFailure> GranusolveSampler::solve_pile(std::uint64_t sample, std::span<const double> load,
                                                             Pile& pile) {
  pile.mu = spec_.mu;
  pile.law = name_of(Law::granusolve);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  begin_pile(sample, load);
  use_own_state(pile);
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    throw_if_interrupted();
    if (auto failure = solve_layer(layer)) return failure;
  }
  count_pile();
  return std::nullopt;
}

void GranusolveSampler::begin_pile(std::uint64_t sample, std::span<const double> load) {
  load_ = load;
  key_ = RandomKey(spec_.seed, sample);
  eight_at_once_ = first_ == nullptr && !PlainKernels::in_use();
  std::fill(pending_.begin(), pending_.end(), Run{});
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    order_[static_cast<std::size_t>(layer)] =
        spec_.order == LayerOrder::random ? key_.layer_order(layer, lattice_.columns()) : RandomKey::Order{0, 1};
  }
  topmost_pending_ = lattice_.layers();
  beyond_window_ = false;
  solutions_ = 0;
  ++counts_.tries;
}

void GranusolveSampler::count_pile() {
  std::array<std::uint64_t, rules> beads_by{};
  for (std::size_t bead = 0; bead < own_rule_.size(); ++bead) {
    ++beads_by[own_climbs_[bead] != 0 ? static_cast<std::size_t>(Rule::climb) : own_rule_[bead]];
  }
  add_pile(beads_by);
}

void GranusolveSampler::add_pile(const std::array<std::uint64_t, rules>& beads_by) {
  const auto by = [&](Rule rule) { return beads_by[static_cast<std::size_t>(rule)]; };
  counts_.beads += lattice_.beads();
  counts_.mended_by_pair += by(Rule::pair);
  counts_.mended_by_arc += by(Rule::arc);
  counts_.mended_by_ring += by(Rule::ring);
  counts_.climbed += by(Rule::climb);
}

void GranusolveSampler::set_rule(std::size_t bead, Rule rule) { state_.rule[bead] = static_cast<std::uint8_t>(rule); }

// ---------------------------------------------------------------------------------------------- one layer

void GranusolveSampler::draw_layer_in_bulk(int layer) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  if (first_ == nullptr) fill_first_uniforms(key_.seed(), key_.sample(), layer, state_.first_uniform, columns);
  if (first_ != nullptr) std::copy_n(&first_numbers_[at(layer, 0)], columns, state_.first_uniform);
  const auto row = [&](std::size_t from) {
    const std::size_t here = at(layer, 0) + from;
    return LowerRow{&state_.V_R[here], &state_.V_L[here], &state_.H[here],
                    &state_.H_R[here], &state_.H_L[here], &slack_[from]};
  };
  if (layer == 0) {
    for (std::size_t i = 0; i < columns; ++i) half_load_[i] = load_[i] / 2;
    const double* const half = half_load_.data();
    draw_beads(cone_, {half, half, no_force_.data(), no_force_.data()}, state_.first_uniform, columns, row(0));
    if (first_ != nullptr) keep_splits(layer);
    return;
  }
  const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
    const std::size_t up = at(layer - 1, 0);
    return UpperRow{&state_.V_R[up + upper_left], &state_.V_L[up + upper_right], &state_.H_R[up + upper_left],
                    &state_.H_L[up + upper_right]};
  };
  // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
  const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
  draw_beads(cone_, above(0, 1), &state_.first_uniform[first], columns - 1, row(first));
  draw_beads(cone_, above(columns - 1, 0), &state_.first_uniform[seam], 1, row(seam));
  if (first_ != nullptr) keep_splits(layer);
}

void GranusolveSampler::begin_layer(int layer) {
  front_ = layer;
  cursor_ = 0;
  cursor_bead_ = order_[static_cast<std::size_t>(layer)].first_bead;
  const std::size_t here = at(layer, 0), columns = static_cast<std::size_t>(lattice_.columns());
  std::fill_n(&state_.attempts[here], columns, first_ == nullptr ? 0 : attempts_before_solving_again);
  std::fill_n(&state_.unsolved[here], columns, std::uint8_t{0});
  std::fill_n(&state_.rule[here], columns, static_cast<std::uint8_t>(Rule::first_draw));
  std::fill_n(&state_.climbs[here], columns, std::uint8_t{0});
  draw_layer_in_bulk(layer);
  find_failing(slack_.data(), slack_.size(), state_.failing);
  solutions_ += columns;
  if (first_ == nullptr) counts_.uniforms += columns;
}

/// The beads from `low` to `high` that fail: the first of them if `direction` > 0, else the last; -1 if there is none.
int GranusolveSampler::find_failing_between(int low, int high, int direction) const {
  if (low > high) return -1;
  const int first_word = low / 64, last_word = high / 64;
  const auto inside = [&](int word) {
    std::uint64_t bits = state_.failing[static_cast<std::size_t>(word)];
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

/// Moves the cursor on to the next bead of the front layer that has to be solved singly; -1 if there is none.
int GranusolveSampler::next_failing() {
  const int columns = lattice_.columns(), here = cursor_bead_;
  if (cursor_ == columns) return -1;
  if (const auto at_cursor = static_cast<std::size_t>(here);
      (state_.failing[at_cursor / 64] >> (at_cursor % 64) & 1) != 0) {
    return here;  // the neighbour of a bead just mended, mostly
  }
  const auto [first, direction] = order_[static_cast<std::size_t>(front_)];
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
  const int next = bead < 0 ? columns : position(front_, bead);
  cursor_ = next;
  cursor_bead_ = bead;
  return bead;
}

/// Solves the bead at the cursor, whatever it takes; `no_pair` says that it has no solution as it is, nor by the pair
/// rule. False if the effort ran out.
bool GranusolveSampler::solve_failing(int bead, bool no_pair) {
  Mend outcome = no_pair ? mend(front_, bead, true) : solve_counted(front_, bead);
  while (outcome == Mend::climbed) {
    throw_if_interrupted();
    if (!solve_pending()) return false;
    outcome = solve_bead(front_, bead);
  }
  step_cursor();
  // A child that rounding left unsolvable waits as pending even without a climb.
  return topmost_pending_ > front_ || solve_pending();
}

std::optional<SamplingFailure> GranusolveSampler::solve_layer(int layer) {
  begin_layer(layer);
  for (int bead = next_failing(); bead >= 0; bead = next_failing()) {
    if (!solve_failing(bead)) return SamplingFailure{layer};
  }
  if (solutions_ > max_solutions_) return SamplingFailure{layer};
  return std::nullopt;
}

// ---------------------------------------------------------------------------------------------- one bead

Incoming GranusolveSampler::incoming(int layer, int bead) const {
  if (layer == 0) {
    const double half = load_[static_cast<std::size_t>(bead)] / 2;
    return {half, half, 0.0};
  }
  const std::size_t a = at(layer - 1, lattice_.upper_left(layer, bead));
  const std::size_t b = at(layer - 1, lattice_.upper_right(layer, bead));
  return {state_.V_R[a], state_.V_L[b], state_.H_R[a] + (state_.H[b] - state_.H_R[b])};
}

/// Where a solved bead may move its H_R, whatever hangs below it.
Interval GranusolveSampler::interval_of(int layer, int bead) const {
  const std::size_t here = at(layer, bead);
  return closed(split_interval(cone_, {state_.V_R[here], state_.V_L[here]}, state_.H[here]));
}

/// Band of H_R(P) - H_R(Q) that keeps the bead solvable, P and Q being its upper-left and upper-right parents: its
/// H = H_R(P) + H(Q) - H_R(Q), while its V_UL and V_UR do not depend on the splits.
Interval GranusolveSampler::difference_band(int layer, int bead) const {
  const std::size_t P = at(layer - 1, lattice_.upper_left(layer, bead));
  const std::size_t Q = at(layer - 1, lattice_.upper_right(layer, bead));
  const Interval band = solvable_band(cone_, state_.V_R[P], state_.V_L[Q]);
  return {band.low - state_.H[Q], band.high - state_.H[Q]};
}

int GranusolveSampler::position(int layer, int bead) const {
  const RandomKey::Order order = order_[static_cast<std::size_t>(layer)];
  const int distance = order.direction > 0 ? bead - order.first_bead : order.first_bead - bead;
  return distance < 0 ? distance + lattice_.columns() : distance;
}

bool GranusolveSampler::solved(int layer, int bead) const {
  return state_.unsolved[at(layer, bead)] == 0 && (layer < front_ || position(layer, bead) < cursor_);
}

/// Takes the forces from above and draws the split; false if the interval is empty beyond rounding.
bool GranusolveSampler::try_draw(int layer, int bead) {
  Incoming in = incoming(layer, bead);
  Outgoing out = balance(in);
  Interval interval = split_interval(cone_, out, in.H);
  if (unsolvable(out, interval)) {
    if (!misses_by_rounding(cone_, in)) return false;
    in.H = nearest_solvable(cone_, in);
    ++counts_.rounded;
    out = balance(in);
    interval = closed(split_interval(cone_, out, in.H));
  }
  const std::size_t here = at(layer, bead);
  state_.V_R[here] = out.V_R;
  state_.V_L[here] = out.V_L;
  state_.H[here] = in.H;
  set_split(layer, bead, choose_split(layer, bead, out, interval));
  state_.unsolved[here] = 0;
  return true;
}

void GranusolveSampler::set_split(int layer, int bead, double H_R) {
  const std::size_t here = at(layer, bead);
  state_.H_R[here] = H_R;
  if (state_.H_L != nullptr) state_.H_L[here] = state_.H[here] - H_R;
}

UniformPair GranusolveSampler::next_uniforms(int layer, int bead, int used) {
  counts_.uniforms += static_cast<std::uint64_t>(used);
  return key_.attempt(layer, bead, ++state_.attempts[at(layer, bead)]);
}

GranusolveSampler::Mend GranusolveSampler::solve_bead(int layer, int bead) {
  ++solutions_;
  return solve_counted(layer, bead);
}

/// The same without counting: a bead of the front layer whose turn has come was counted when the layer was drawn.
GranusolveSampler::Mend GranusolveSampler::solve_counted(int layer, int bead) {
  if (try_draw(layer, bead)) {
    set_rule(at(layer, bead), Rule::first_draw);
    return Mend::done;
  }
  return mend(layer, bead);
}

// ---------------------------------------------------------------------------------------------- mending

/// Changes the splits above so that the bead has a solution, and draws it; or climbs.
GranusolveSampler::Mend GranusolveSampler::mend(int layer, int bead, bool no_pair) {
  if (change_parents(layer, bead, no_pair)) {
    ++solutions_;
    // After a change of parents the bead is solvable up to rounding; should rounding exceed its allowance, climb.
    if (try_draw(layer, bead)) return Mend::done;
  }
  return climb(layer, bead);
}

bool GranusolveSampler::change_parents(int layer, int bead, bool no_pair) {
  const bool arcs = spec_.rules == MendingRules::all || spec_.rules == MendingRules::no_pair;
  if (mends_pairs() && !no_pair && mend_by_pair(layer, bead)) return true;
  if (!arcs || hopeless_alone(layer, bead)) return false;
  for (int parents = 4; parents < lattice_.columns(); parents *= 2) {
    const ArcOutcome outcome = mend_by_arc(layer, bead, parents);
    if (outcome != ArcOutcome::too_narrow) return outcome == ArcOutcome::mended;
  }
  return mend_by_ring(layer, bead);
}

bool GranusolveSampler::mend_by_pair(int layer, int bead) {
  const int A = lattice_.upper_left(layer, bead), B = lattice_.upper_right(layer, bead);
  Interval a = interval_of(layer - 1, A), b = interval_of(layer - 1, B);
  // The other child of A hangs between its own upper-left parent and A, the other child of B between B and another.
  const int left = lattice_.previous(bead), right = lattice_.next(bead);
  const bool left_solved = solved(layer, left), right_solved = solved(layer, right);
  if (left_solved) {
    const double held = state_.H_R[at(layer - 1, lattice_.upper_left(layer, left))];
    const Interval band = difference_band(layer, left);
    a = intersection(a, {held - band.high, held - band.low});
  }
  if (right_solved) {
    const double held = state_.H_R[at(layer - 1, lattice_.upper_right(layer, right))];
    const Interval band = difference_band(layer, right);
    b = intersection(b, {held + band.low, held + band.high});
  }
  const Interval band = difference_band(layer, bead);
  if (a.empty() || b.empty() || std::max(band.low, a.low - b.high) > std::min(band.high, a.high - b.low)) {
    return false;
  }
  const UniformPair u = next_uniforms(layer, bead, 2);
  const auto drawn = draw_truncated_pair(a, b, band, u.first, u.second);
  if (!drawn) return false;
  ++counts_.pairs;
  set_split(layer - 1, A, drawn->a);
  set_split(layer - 1, B, drawn->b);
  set_rule(at(layer, bead), Rule::pair);
  renew_child(layer, left);
  renew_child(layer, right);
  return true;
}

/// A bead below a changed parent: a solved one draws again, and what was solved below it is unsolved; one whose turn
/// has not come forgets what was drawn for it in bulk.
void GranusolveSampler::renew_child(int layer, int bead) {
  if (!solved(layer, bead)) {
    if (layer == front_ && position(layer, bead) >= cursor_) forget_draw(bead);
    return;
  }
  ++solutions_;
  if (!try_draw(layer, bead)) {
    unsolve(layer, bead, 1);  // beyond the rounding allowance after all: it waits like a bead that a climb has unsolved
  } else if (layer < front_) {
    unsolve(layer + 1, lattice_.lower_left(layer, bead), 2);
  }
}

}  // namespace granuscope
