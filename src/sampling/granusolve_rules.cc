#include "sampling/granusolve_rules.h"

#include <algorithm>
#include <limits>

#include "sampling/truncated_pair.h"

namespace granuscope {
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
  const UniformPair u = draws_.next_uniforms(layer, bead, 2);
  const auto drawn = draw_truncated_pair(a, b, band, u.first, u.second);
  if (!drawn) return false;
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

}  // namespace granuscope
