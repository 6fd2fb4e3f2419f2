// How granusolve changes more than two parents of a failing bead: arcs, and the whole ring.
#include <algorithm>
#include <limits>

#include "sampling/granusolve_rules.h"
#include "sampling/rounding.h"

namespace granuscope {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

/// The bead between parents k and k + 1 of the arc.
int GranusolveRules::child_after(const ParentArc& arc, int k) const {
  return arc.step > 0 ? state_.lattice().lower_right(arc.layer - 1, parent(arc, k))
                      : state_.lattice().lower_left(arc.layer - 1, parent(arc, k));
}

/// Band of H_R(parent k) - H_R(parent k + 1); everything if the bead between them is not solved and not the failed one.
Interval GranusolveRules::step_band(const ParentArc& arc, int k, int failed) const {
  const int child = child_after(arc, k);
  if (child != failed && !state_.solved(arc.layer, child)) return {-infinity, infinity};
  const Interval band = state_.difference_band(arc.layer, child);
  return arc.step > 0 ? band : Interval{-band.high, -band.low};
}

/// Given split_[from], draws split_[from - 1] .. split_[to], each uniformly on what the filter and the one drawn before
/// leave.
void GranusolveRules::draw_backwards(int from, int to) {
  for (int k = from - 1; k >= to; --k) {
    const auto here = static_cast<std::size_t>(k);
    const Interval reach{split_[here + 1] + bands_[here].low, split_[here + 1] + bands_[here].high};
    // The filter holds a solution; only rounding can leave none. The bead below is then within rounding of its band.
    split_[here] = point_at(closed(intersection(filter_[here], reach)), numbers_[here]);
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
  split_[static_cast<std::size_t>(last)] =
      point_at(filter_[static_cast<std::size_t>(last)], numbers_[static_cast<std::size_t>(last)]);
  draw_backwards(last, 0);
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
  const double pinned = point_at(own_[0], draws_.next_uniforms(layer - 1, parent(ring, 0), 1).first);
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
  split_[wrap(last)] = point_at(filter_[wrap(last)], numbers_[wrap(last)]);
  draw_backwards(last, 1);
  set_splits(ring, bead, GranusolveRule::ring);
  return true;
}

}  // namespace granuscope
