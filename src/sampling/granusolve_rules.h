#pragma once
#include <cstdint>
#include <vector>

#include "sampling/granusolve_draws.h"
#include "sampling/granusolve_state.h"
#include "sampling/sampler_spec.h"

namespace granuscope {

/// How a bead, a layer's run of beads, or a pile came out that was to be solved.
enum class SolveResult : std::uint8_t {
  solved,
  unsolved_above,  ///< beads above have to be solved first, and then this tried again
  out_of_effort,
  beyond_window  ///< a backtrack would have left the layers that are held: the pile must be solved by itself
};

/// What granusolve (granusolve.h) does for a bead that has no solution as it is: it changes the splits of the bead's
/// parents, so that it has one, or backtracks. The rules pair, arc and ring change splits and renew the other children
/// of the parents; the bead itself is then drawn by whoever called.
class GranusolveRules {
 public:
  GranusolveRules(RepairRules rules, GranusolveState& state, GranusolveDraws& draws, GranusolveWork& work);

  /// Tries the rules from the pair on (`no_pair`: it is known not to help); whether one of them helped.
  bool change_parents(int layer, int bead, bool no_pair);
  /// Unsolves what the bead hangs from: unsolved_above, or beyond_window with nothing changed.
  SolveResult backtrack(int layer, int bead);

 private:
  enum class ArcOutcome : std::uint8_t { repaired, too_narrow, infeasible };

  bool repair_by_pair(int layer, int bead);
  bool infeasible_alone(int layer, int bead) const;
  ArcOutcome repair_by_arc(int layer, int bead, int parents);
  bool repair_by_ring(int layer, int bead);

  int parent(const ParentArc& arc, int k) const { return parent_of(state_.lattice(), arc, k); }
  int child_after(const ParentArc& arc, int k) const;
  Interval step_band(const ParentArc& arc, int k, int failed) const;
  void draw_backwards(int from, int to);
  void set_splits(const ParentArc& arc, int bead, GranusolveRule rule);

  bool pairs_, arcs_;  ///< which rules are in use
  GranusolveState& state_;
  GranusolveDraws& draws_;
  GranusolveWork& work_;
  // Work space of the arcs and the ring, one entry per parent.
  std::vector<Interval> own_, filter_, bands_;
  std::vector<double> split_, numbers_;
};

}  // namespace granuscope
