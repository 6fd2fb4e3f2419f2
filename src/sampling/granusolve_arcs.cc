// How granusolve changes more than two parents of a failing bead: arcs, and the whole ring.
#include <algorithm>
#include <array>
#include <limits>

#include "sampling/granusolve.h"
#include "sampling/layer_kernels.h"
#include "sampling/rounding.h"

namespace granuscope {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

int GranusolveSampler::parent(const Arc& arc, int k) const {
  const int columns = lattice_.columns(), unwrapped = arc.first + arc.step * k;
  return unwrapped < 0 ? unwrapped + columns : unwrapped >= columns ? unwrapped - columns : unwrapped;
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

/// The next number of each parent from number `from` on, eight at a time.
void GranusolveSampler::take_numbers(const Arc& arc, int from) {
  constexpr int at_once = attempts_at_once;
  for (int begin = from; begin < arc.count; begin += at_once) {
    const int count = std::min(at_once, arc.count - begin);
    std::array<std::uint32_t, attempts_at_once> beads{}, attempts{};
    std::array<double, attempts_at_once> numbers{};
    for (int k = 0; k < count; ++k) {
      const auto here = static_cast<std::size_t>(k);
      const int bead = parent(arc, begin + k);
      beads[here] = static_cast<std::uint32_t>(bead);
      attempts[here] = ++state_.attempts[at(arc.layer - 1, bead)];
      if (!eight_at_once_) numbers[here] = key_.attempt(arc.layer - 1, bead, attempts[here]).first;
    }
    if (eight_at_once_) later_numbers(philox_keys_, key_.sample(), arc.layer - 1, beads, attempts, numbers);
    std::copy_n(numbers.begin(), count, numbers_.begin() + begin);
    counts_.uniforms += static_cast<std::uint64_t>(count);
  }
}

/// Given split_[from], draws split_[from - 1] .. split_[to], each uniformly on what the filter and the one drawn before
/// leave.
void GranusolveSampler::draw_backwards(int from, int to) {
  for (int k = from - 1; k >= to; --k) {
    const auto here = static_cast<std::size_t>(k);
    const Interval reach{split_[here + 1] + bands_[here].low, split_[here + 1] + bands_[here].high};
    // The filter holds a solution; only rounding can leave none. The bead below is then within rounding of its band.
    split_[here] = point_at(closed(intersection(filter_[here], reach)), numbers_[here]);
  }
}

/// Whether even the bead's own two parents, with all others let go, cannot help it: then every arc is hopeless.
bool GranusolveSampler::hopeless_alone(int layer, int bead) const {
  const Interval a = interval_of(layer - 1, lattice_.upper_left(layer, bead));
  const Interval b = interval_of(layer - 1, lattice_.upper_right(layer, bead));
  const Interval band = difference_band(layer, bead);
  // As the filter along the arc goes, which rounds otherwise the other way.
  return order_[static_cast<std::size_t>(layer)].direction > 0
             ? intersection(b, {a.low - band.high, a.high - band.low}).empty()
             : intersection(a, {b.low + band.low, b.high + band.high}).empty();
}

GranusolveSampler::ArcOutcome GranusolveSampler::mend_by_arc(int layer, int bead, int parents) {
  const int step = order_[static_cast<std::size_t>(layer)].direction;
  // The failed bead hangs below the arc's two middle parents.
  const int near = step > 0 ? lattice_.upper_left(layer, bead) : lattice_.upper_right(layer, bead);
  const int columns = lattice_.columns(), first = near - step * (parents / 2 - 1);
  const Arc arc{layer, first < 0 ? first + columns : first % columns, parents, step};
  const int last = parents - 1;
  const auto filtered = [&](std::size_t k) {
    const Interval before = filter_[k - 1], band = bands_[k - 1];
    return intersection(own_[k], {before.low - band.high, before.high - band.low});
  };
  // First as if nothing were held, and no farther than it goes.
  for (int k = 0; k < parents; ++k) {
    const auto here = static_cast<std::size_t>(k);
    own_[here] = interval_of(layer - 1, parent(arc, k));
    filter_[here] = k == 0 ? own_[here] : filtered(here);
    if (filter_[here].empty()) return ArcOutcome::hopeless;
    bands_[here] = step_band(arc, k, bead);
  }
  // The parents next to the arc are held: parent -1 through the band before the arc, parent `parents` through the last.
  const double before = state_.H_R[at(layer - 1, parent(arc, -1))];
  const double after = state_.H_R[at(layer - 1, parent(arc, parents))];
  const Interval band_before = step_band(arc, -1, bead), band_after = bands_[static_cast<std::size_t>(last)];
  filter_[0] = intersection(own_[0], {before - band_before.high, before - band_before.low});
  for (int k = 0; k < parents; ++k) {
    const auto here = static_cast<std::size_t>(k);
    if (k > 0) filter_[here] = filtered(here);
    if (k == last) filter_[here] = intersection(filter_[here], {after + band_after.low, after + band_after.high});
    if (filter_[here].empty()) return ArcOutcome::too_narrow;
  }
  ++counts_.arcs;
  take_numbers(arc, 0);
  split_[static_cast<std::size_t>(last)] =
      point_at(filter_[static_cast<std::size_t>(last)], numbers_[static_cast<std::size_t>(last)]);
  draw_backwards(last, 0);
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
  take_numbers(ring, 1);
  split_[wrap(last)] = point_at(filter_[wrap(last)], numbers_[wrap(last)]);
  draw_backwards(last, 1);
  for (int k = 0; k < columns; ++k) set_split(layer - 1, parent(ring, k), split_[wrap(k)]);
  set_rule(at(layer, bead), Rule::ring);
  for (int k = 0; k < columns; ++k) {
    if (const int child = child_after(ring, k); child != bead) renew_child(layer, child);
  }
  return true;
}

}  // namespace granuscope
