// How granusolve changes more than two parents of a failing bead: arcs, and the whole ring.
#include <limits>

#include "sampling/granusolve.h"
#include "sampling/rounding.h"

namespace granuscope {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

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
  const double before = state_.H_R[at(layer - 1, parent(arc, -1))];
  const double after = state_.H_R[at(layer - 1, parent(arc, parents))];
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

}  // namespace granuscope
