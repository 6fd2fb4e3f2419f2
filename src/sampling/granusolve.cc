#include "sampling/granusolve.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sampling/layer_kernels.h"
#include "sampling/truncated_pair.h"

namespace granuscope {
namespace {

/// An H that misses its solvable band by at most this many units in the last place of the forces summed is put onto the
/// band's end: the splits above were chosen inside the band, and only their rounding carried H out of it.
constexpr double rounding_ulps = 64;
constexpr double ulp = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Slack of a bead of the front layer whose bulk draw does not hold (any more).
constexpr double not_drawn = -1;

/// An interval that is empty by rounding only, as the point it stands for.
Interval closed(Interval interval) {
  if (!interval.empty()) return interval;
  const double middle = interval.low + (interval.high - interval.low) / 2;
  return {middle, middle};
}

}  // namespace

GranusolveSampler::GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice)
    : lattice_(lattice),
      cone_(spec.mu),
      spec_(spec),
      H_(lattice.beads()),
      attempts_(lattice.beads()),
      unsolved_(lattice.beads()),
      rule_(lattice.beads()),
      order_(static_cast<std::size_t>(lattice.layers())),
      pending_(static_cast<std::size_t>(lattice.layers())),
      first_uniform_(static_cast<std::size_t>(lattice.columns()) + uniform_padding),
      slack_(static_cast<std::size_t>(lattice.columns())),
      half_load_(static_cast<std::size_t>(lattice.columns())),
      no_force_(static_cast<std::size_t>(lattice.columns())) {
  const auto columns = static_cast<std::size_t>(lattice.columns());
  own_.resize(columns);
  filter_.resize(columns);
  bands_.resize(columns);
  split_.resize(columns);
  max_solutions_ = static_cast<std::uint64_t>(spec.effort * static_cast<double>(lattice.beads()));
}

std::optional<SamplingFailure> GranusolveSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  first_ = nullptr;
  return solve_pile(sample, load, pile);
}

std::optional<SamplingFailure> GranusolveSampler::solve_pile(std::uint64_t sample, std::span<const double> load,
                                                             Pile& pile) {
  begin_pile(sample, load, pile);
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    if (auto failure = solve_layer(layer)) return failure;
  }
  count_pile();
  return std::nullopt;
}

void GranusolveSampler::begin_pile(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  pile_ = &pile;
  pile.mu = spec_.mu;
  pile.law = name_of(Law::granusolve);
  pile.seed = spec_.seed;
  pile.sample = sample;
  pile.load.assign(load.begin(), load.end());
  key_ = RandomKey(spec_.seed, sample);
  std::fill(attempts_.begin(), attempts_.end(), first_ == nullptr ? 0 : attempts_before_solving_again);
  std::fill(unsolved_.begin(), unsolved_.end(), std::uint8_t{0});
  std::fill(rule_.begin(), rule_.end(), Rule::first_draw);
  by_rule_ = {lattice_.beads(), 0, 0, 0, 0};
  for (auto& layer : pending_) layer.clear();
  for (int layer = 0; layer < lattice_.layers(); ++layer) {
    order_[static_cast<std::size_t>(layer)] =
        spec_.order == LayerOrder::random ? key_.layer_order(layer, lattice_.columns()) : RandomKey::Order{0, 1};
  }
  topmost_pending_ = lattice_.layers();
  climbs_.clear();
  solutions_ = 0;
  ++counts_.tries;
}

void GranusolveSampler::count_pile() {
  for (const auto& [bead, times] : climbs_) set_rule(bead, Rule::climb);
  const auto beads_by = [&](Rule rule) { return by_rule_[static_cast<std::size_t>(rule)]; };
  counts_.beads += lattice_.beads();
  counts_.mended_by_pair += beads_by(Rule::pair);
  counts_.mended_by_arc += beads_by(Rule::arc);
  counts_.mended_by_ring += beads_by(Rule::ring);
  counts_.climbed += beads_by(Rule::climb);
}

void GranusolveSampler::set_rule(std::size_t bead, Rule rule) {
  --by_rule_[static_cast<std::size_t>(rule_[bead])];
  ++by_rule_[static_cast<std::size_t>(rule)];
  rule_[bead] = rule;
}

// ---------------------------------------------------------------------------------------------- one layer

void GranusolveSampler::draw_layer_in_bulk(int layer) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  if (first_ == nullptr) fill_first_uniforms(key_.seed(), key_.sample(), layer, first_uniform_.data(), columns);
  if (first_ != nullptr) std::copy_n(&first_numbers_[at(layer, 0)], columns, first_uniform_.begin());
  const auto row = [&](std::size_t from) {
    const std::size_t here = at(layer, 0) + from;
    return LowerRow{&pile_->V_R[here], &pile_->V_L[here], &H_[here],
                    &pile_->H_R[here], &pile_->H_L[here], &slack_[from]};
  };
  if (layer == 0) {
    for (std::size_t i = 0; i < columns; ++i) half_load_[i] = pile_->load[i] / 2;
    const double* const half = half_load_.data();
    draw_beads(cone_, {half, half, no_force_.data(), no_force_.data()}, first_uniform_.data(), columns, row(0));
    if (first_ != nullptr) keep_splits(layer);
    return;
  }
  const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
    const std::size_t up = at(layer - 1, 0);
    return UpperRow{&pile_->V_R[up + upper_left], &pile_->V_L[up + upper_right], &pile_->H_R[up + upper_left],
                    &pile_->H_L[up + upper_right]};
  };
  // Away from the seam the parents of a bead stand side by side; the seam's bead is a run of its own.
  const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
  draw_beads(cone_, above(0, 1), &first_uniform_[first], columns - 1, row(first));
  draw_beads(cone_, above(columns - 1, 0), &first_uniform_[seam], 1, row(seam));
  if (first_ != nullptr) keep_splits(layer);
}

std::optional<SamplingFailure> GranusolveSampler::solve_layer(int layer) {
  front_ = layer;
  draw_layer_in_bulk(layer);
  const int columns = lattice_.columns();
  solutions_ += static_cast<std::uint64_t>(columns);
  const RandomKey::Order order = order_[static_cast<std::size_t>(layer)];
  int bead = order.first_bead;
  for (cursor_ = 0; cursor_ < columns;) {
    if (slack_[static_cast<std::size_t>(bead)] >= 0) {
      if (first_ == nullptr) ++counts_.uniforms;
      ++cursor_;
    } else {
      while (solve_bead(layer, bead, Attempt::first) == Mend::climbed) {
        if (!solve_pending()) return SamplingFailure{layer};
      }
      ++cursor_;  // from here on the bead counts as solved
      // A child that rounding left unsolvable waits as pending even without a climb.
      if (topmost_pending_ <= front_ && !solve_pending()) return SamplingFailure{layer};
    }
    bead = order.direction > 0 ? lattice_.next(bead) : lattice_.previous(bead);
  }
  if (solutions_ > max_solutions_) return SamplingFailure{layer};
  return std::nullopt;
}

bool GranusolveSampler::solve_pending() {
  int layer = topmost_pending_;
  while (layer <= front_) {
    const int bead = next_pending(layer);
    if (bead < 0) {
      ++layer;
      continue;
    }
    if (solutions_ > max_solutions_) return false;
    topmost_pending_ = lattice_.layers();
    if (solve_bead(layer, bead, Attempt::later) == Mend::climbed) {
      layer = std::min(layer, topmost_pending_);
    }
  }
  topmost_pending_ = lattice_.layers();
  return solutions_ <= max_solutions_;
}

int GranusolveSampler::next_pending(int layer) {
  auto& beads = pending_[static_cast<std::size_t>(layer)];
  std::erase_if(beads, [&](int bead) { return unsolved_[at(layer, bead)] == 0; });
  const auto first = std::min_element(beads.begin(), beads.end(),
                                      [&](int a, int b) { return position(layer, a) < position(layer, b); });
  return first == beads.end() ? -1 : *first;
}

// ---------------------------------------------------------------------------------------------- one bead

Incoming GranusolveSampler::incoming(int layer, int bead) const {
  if (layer == 0) {
    const double half = pile_->load[static_cast<std::size_t>(bead)] / 2;
    return {half, half, 0.0};
  }
  const std::size_t a = at(layer - 1, lattice_.upper_left(layer, bead));
  const std::size_t b = at(layer - 1, lattice_.upper_right(layer, bead));
  return {pile_->V_R[a], pile_->V_L[b], pile_->H_R[a] + pile_->H_L[b]};
}

/// Where a solved bead may move its H_R, whatever hangs below it.
Interval GranusolveSampler::interval_of(int layer, int bead) const {
  const std::size_t here = at(layer, bead);
  return closed(split_interval(cone_, {pile_->V_R[here], pile_->V_L[here]}, H_[here]));
}

/// Band of H_R(P) - H_R(Q) that keeps the bead solvable, P and Q being its upper-left and upper-right parents: its
/// H = H_R(P) + H(Q) - H_R(Q), while its V_UL and V_UR do not depend on the splits.
Interval GranusolveSampler::difference_band(int layer, int bead) const {
  const std::size_t P = at(layer - 1, lattice_.upper_left(layer, bead));
  const std::size_t Q = at(layer - 1, lattice_.upper_right(layer, bead));
  const Interval band = solvable_band(cone_, pile_->V_R[P], pile_->V_L[Q]);
  return {band.low - H_[Q], band.high - H_[Q]};
}

int GranusolveSampler::position(int layer, int bead) const {
  const RandomKey::Order order = order_[static_cast<std::size_t>(layer)];
  const int distance = order.direction > 0 ? bead - order.first_bead : order.first_bead - bead;
  return distance < 0 ? distance + lattice_.columns() : distance;
}

bool GranusolveSampler::solved(int layer, int bead) const {
  return unsolved_[at(layer, bead)] == 0 && (layer < front_ || position(layer, bead) < cursor_);
}

/// Takes the forces from above and draws the split; false if the interval is empty beyond rounding.
bool GranusolveSampler::try_draw(int layer, int bead, Attempt attempt) {
  Incoming in = incoming(layer, bead);
  Outgoing out = balance(in);
  Interval interval = split_interval(cone_, out, in.H);
  if (interval.empty()) {
    const Interval band = solvable_band(cone_, in.V_UL, in.V_UR);
    const double on_band = std::clamp(in.H, band.low, std::max(band.low, band.high));
    if (std::abs(in.H - on_band) > rounding_ulps * ulp * (in.V_UL + in.V_UR + std::abs(in.H))) return false;
    ++counts_.rounded;
    in.H = on_band;
    out = balance(in);
    interval = closed(split_interval(cone_, out, in.H));
  }
  const std::size_t here = at(layer, bead);
  pile_->V_R[here] = out.V_R;
  pile_->V_L[here] = out.V_L;
  H_[here] = in.H;
  set_split(layer, bead, choose_split(layer, bead, attempt, out, interval));
  unsolved_[here] = 0;
  return true;
}

void GranusolveSampler::set_split(int layer, int bead, double H_R) {
  const std::size_t here = at(layer, bead);
  pile_->H_R[here] = H_R;
  pile_->H_L[here] = H_[here] - H_R;
}

UniformPair GranusolveSampler::next_uniforms(int layer, int bead, int used) {
  counts_.uniforms += static_cast<std::uint64_t>(used);
  return key_.attempt(layer, bead, ++attempts_[at(layer, bead)]);
}

GranusolveSampler::Mend GranusolveSampler::solve_bead(int layer, int bead, Attempt attempt) {
  ++solutions_;
  if (try_draw(layer, bead, attempt)) {
    set_rule(at(layer, bead), Rule::first_draw);
    return Mend::done;
  }
  return mend(layer, bead);
}

// ---------------------------------------------------------------------------------------------- mending

/// Changes the splits above so that the bead has a solution, and draws it; or climbs.
GranusolveSampler::Mend GranusolveSampler::mend(int layer, int bead) {
  if (change_parents(layer, bead)) {
    ++solutions_;
    // After a change of parents the bead is solvable up to rounding; should rounding exceed its allowance, climb.
    if (try_draw(layer, bead, Attempt::later)) return Mend::done;
  }
  climb(layer, bead);
  return Mend::climbed;
}

bool GranusolveSampler::change_parents(int layer, int bead) {
  if (mend_by_pair(layer, bead)) return true;
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
    const double held = pile_->H_R[at(layer - 1, lattice_.upper_left(layer, left))];
    const Interval band = difference_band(layer, left);
    a = intersection(a, {held - band.high, held - band.low});
  }
  if (right_solved) {
    const double held = pile_->H_R[at(layer - 1, lattice_.upper_right(layer, right))];
    const Interval band = difference_band(layer, right);
    b = intersection(b, {held + band.low, held + band.high});
  }
  const Interval band = difference_band(layer, bead);
  if (a.empty() || b.empty() || std::max(band.low, a.low - b.high) > std::min(band.high, a.high - b.low)) return false;
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

int GranusolveSampler::parent(const Arc& arc, int k) const {
  const int columns = lattice_.columns();
  return ((arc.first + arc.step * k) % columns + columns) % columns;
}

/// The bead between parents k and k + 1 of the arc.
int GranusolveSampler::child_after(const Arc& arc, int k) const {
  return arc.step > 0 ? lattice_.lower_right(arc.layer - 1, parent(arc, k))
                      : lattice_.lower_left(arc.layer - 1, parent(arc, k));
}

/// Band of H_R(parent k) - H_R(parent k + 1); everything if the bead between them is not solved and not the failed one.
Interval GranusolveSampler::step_band(const Arc& arc, int k, int failed) const {
  const int child = child_after(arc, k);
  if (child != failed && !solved(arc.layer, child)) return {-infinity, infinity};
  const Interval band = difference_band(arc.layer, child);
  return arc.step > 0 ? band : Interval{-band.high, -band.low};
}

/// Given split_[from], draws split_[from - 1] .. split_[to], each uniformly on what the filter and the one drawn before
/// leave.
void GranusolveSampler::draw_backwards(const Arc& arc, int from, int to) {
  for (int k = from - 1; k >= to; --k) {
    const auto here = static_cast<std::size_t>(k);
    const Interval reach{split_[here + 1] + bands_[here].low, split_[here + 1] + bands_[here].high};
    const double u = next_uniforms(arc.layer - 1, parent(arc, k), 1).first;
    // The filter holds a solution; only rounding can leave none. The bead below is then within rounding of its band.
    split_[here] = point_at(closed(intersection(filter_[here], reach)), u);
  }
}

GranusolveSampler::ArcOutcome GranusolveSampler::mend_by_arc(int layer, int bead, int parents) {
  const int step = order_[static_cast<std::size_t>(layer)].direction;
  // The failed bead hangs below the arc's two middle parents.
  const int near = step > 0 ? lattice_.upper_left(layer, bead) : lattice_.upper_right(layer, bead);
  Arc arc{layer, near - step * (parents / 2 - 1), parents, step};
  const int last = parents - 1;
  const auto filter_from = [&](Interval first, Interval end) {
    filter_[0] = intersection(own_[0], first);
    for (int k = 1; k <= last && !filter_[static_cast<std::size_t>(k - 1)].empty(); ++k) {
      const auto here = static_cast<std::size_t>(k);
      filter_[here] = intersection(
          own_[here], {filter_[here - 1].low - bands_[here - 1].high, filter_[here - 1].high - bands_[here - 1].low});
      if (k == last) {
        filter_[here] = intersection(filter_[here], end);
        return !filter_[here].empty();
      }
    }
    return false;
  };
  for (int k = 0; k < parents; ++k) {
    own_[static_cast<std::size_t>(k)] = interval_of(layer - 1, parent(arc, k));
    bands_[static_cast<std::size_t>(k)] = step_band(arc, k, bead);
  }
  const Interval everything{-infinity, infinity};
  if (!filter_from(everything, everything)) return ArcOutcome::hopeless;
  // The parents next to the arc are held: parent -1 through the band before the arc, parent `parents` through the last.
  const double before = pile_->H_R[at(layer - 1, parent(arc, -1))];
  const double after = pile_->H_R[at(layer - 1, parent(arc, parents))];
  const Interval band_before = step_band(arc, -1, bead), band_after = bands_[static_cast<std::size_t>(last)];
  if (!filter_from({before - band_before.high, before - band_before.low},
                   {after + band_after.low, after + band_after.high})) {
    return ArcOutcome::too_narrow;
  }
  ++counts_.arcs;
  split_[static_cast<std::size_t>(last)] =
      point_at(filter_[static_cast<std::size_t>(last)], next_uniforms(layer - 1, parent(arc, last), 1).first);
  draw_backwards(arc, last, 0);
  for (int k = 0; k < parents; ++k) set_split(layer - 1, parent(arc, k), split_[static_cast<std::size_t>(k)]);
  set_rule(at(layer, bead), Rule::arc);
  for (int k = -1; k < parents; ++k) {
    if (const int child = child_after(arc, k); child != bead) renew_child(layer, child);
  }
  return ArcOutcome::mended;
}

bool GranusolveSampler::mend_by_ring(int layer, int bead) {
  const int columns = lattice_.columns();
  const int step = order_[static_cast<std::size_t>(layer)].direction;
  // Pinned first is the parent that the layer's direction reaches first, so that the law keeps its mirror symmetry.
  const int near = step > 0 ? lattice_.upper_left(layer, bead) : lattice_.upper_right(layer, bead);
  const Arc ring{layer, near, columns, step};
  const auto wrap = [&](int k) { return static_cast<std::size_t>(k >= columns ? k - columns : k); };
  for (int k = 0; k < columns; ++k) {
    own_[wrap(k)] = interval_of(layer - 1, parent(ring, k));
    bands_[wrap(k)] = step_band(ring, k, bead);
  }
  // Difference constraints on a cycle: after two rounds each way every interval is the exact shadow of the solutions.
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
  const double pinned = point_at(own_[0], next_uniforms(layer - 1, parent(ring, 0), 1).first);
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
  ++counts_.rings;
  split_[0] = pinned;
  split_[wrap(last)] = point_at(filter_[wrap(last)], next_uniforms(layer - 1, parent(ring, last), 1).first);
  draw_backwards(ring, last, 1);
  for (int k = 0; k < columns; ++k) set_split(layer - 1, parent(ring, k), split_[wrap(k)]);
  set_rule(at(layer, bead), Rule::ring);
  for (int k = 0; k < columns; ++k) {
    if (const int child = child_after(ring, k); child != bead) renew_child(layer, child);
  }
  return true;
}

/// A bead below a changed parent: a solved one draws again, and what was solved below it is unsolved; one whose turn
/// has not come forgets what was drawn for it in bulk.
void GranusolveSampler::renew_child(int layer, int bead) {
  if (!solved(layer, bead)) {
    if (layer == front_ && position(layer, bead) >= cursor_) slack_[static_cast<std::size_t>(bead)] = not_drawn;
    return;
  }
  ++solutions_;
  if (!try_draw(layer, bead, Attempt::later)) {
    unsolve(layer, bead);  // beyond the rounding allowance after all: it waits like a bead that a climb has unsolved
  } else if (layer < front_) {
    unsolve(layer + 1, lattice_.lower_left(layer, bead));
    unsolve(layer + 1, lattice_.lower_right(layer, bead));
  }
}

void GranusolveSampler::climb(int layer, int bead) {
  ++counts_.climbs;
  const int height = 2 + climbs_[at(layer, bead)]++;
  const int top = std::max(0, layer - height);
  const int sideways = height - (layer - top);
  int first = bead;
  for (int n = layer; n > top; --n) first = lattice_.upper_left(n, first);
  const int columns = lattice_.columns();
  const int count = std::min(columns, layer - top + 1 + 2 * sideways);
  for (int k = 0; k < count; ++k) {
    const int ancestor = ((first - sideways + k) % columns + columns) % columns;
    unsolve(top, ancestor);
    if (unsolved_[at(top, ancestor)] != 0) unsolved_[at(top, ancestor)] = top_of_climb;
  }
}

void GranusolveSampler::unsolve(int layer, int bead) {
  stack_.assign(1, {layer, bead});
  while (!stack_.empty()) {
    const auto [n, i] = stack_.back();
    stack_.pop_back();
    if (n > front_) continue;
    // The bead at the cursor is either being solved right now, and is tried again by whoever called, or the next one.
    if (n == front_ && position(n, i) >= cursor_) {
      slack_[static_cast<std::size_t>(i)] = not_drawn;
      continue;
    }
    if (unsolved_[at(n, i)] != 0) continue;
    unsolved_[at(n, i)] = below_climb;
    pending_[static_cast<std::size_t>(n)].push_back(i);
    topmost_pending_ = std::min(topmost_pending_, n);
    stack_.emplace_back(n + 1, lattice_.lower_left(n, i));
    stack_.emplace_back(n + 1, lattice_.lower_right(n, i));
  }
}

}  // namespace granuscope
