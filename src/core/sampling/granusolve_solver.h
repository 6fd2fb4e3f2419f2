#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "model/pile.h"
#include "sampling/granusolve_state.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// What is counted while a pile is solved, and how much may be done.
struct GranusolveWork {
  SamplerCounts counts;
  std::uint64_t solutions = 0, max_solutions = 0;
  bool exhausted() const { return solutions > max_solutions; }
};

/// Neighbouring parents of one layer, first + k step for k = 0 .. count-1, changed together.
struct ParentArc {
  int layer;  ///< of the beads below the parents
  int first, count, step;
};

/// How beads of a GranusolveState draw their splits: which number each uses, and what becomes of it. As long as no
/// layer below it has been begun, nothing depends on the split of a bead; however often it draws again, it may keep its
/// first number, and does. Solving again, a bead keeps the number of its first solution.
class GranusolveDraws {
 public:
  GranusolveDraws(std::uint64_t seed, GranusolveState& state, GranusolveWork& work);

  /// The numbers of a sample; `first`, if it is solved again, must outlive the pile. Returns where attempts are counted
  /// from.
  std::uint32_t begin_pile(std::uint64_t sample, const Pile* first);
  const RandomKey& key() const { return key_; }
  const PhiloxKeys& philox_keys() const { return philox_keys_; }
  /// Whether numbers of later attempts are drawn eight at a time where several are needed.
  bool eight_at_once() const { return eight_at_once_; }

  /// Begins a layer of a pile by itself: its arrays are cleared, it is drawn in bulk, and beads that fail are noted.
  void begin_layer(int layer);

  /// Takes the forces from above and draws the split; false if the interval is empty beyond rounding.
  bool try_draw(int layer, int bead);
  /// A bead below a changed parent: a solved one draws again, and what was solved below it is unsolved; one whose turn
  /// has not come forgets what was drawn for it in bulk.
  void renew_child(int layer, int bead);

  /// Those of the bead's next attempt, of which `used` are used.
  UniformPair next_uniforms(int layer, int bead, int used) {
    work_.counts.uniforms += static_cast<std::uint64_t>(used);
    return key_.attempt(layer, bead, ++state_.arrays().attempts[state_.at(layer, bead)]);
  }
  /// The next number of each parent of an arc from number `from` on: entries from .. arc.count - 1 of `numbers`.
  void next_numbers(const ParentArc& arc, int from, std::vector<double>& numbers);

 private:
  void draw_in_bulk(int layer);
  void keep_splits(int layer);
  void draw_other_variable(int layer);
  double choose_split(int layer, int bead, Outgoing out, Interval interval);

  GranusolveState& state_;
  GranusolveWork& work_;
  RandomKey key_;
  PhiloxKeys philox_keys_;
  bool eight_at_once_ = false;
  const Pile* first_ = nullptr;        ///< while a pile is solved again: its first solution
  std::vector<double> first_numbers_;  ///< and the numbers of that
  std::vector<double> slack_;          ///< front layer: length of the interval of each bead, as drawn in bulk
  std::vector<double> from_left_, from_right_, half_across_;  ///< what enters the top layer
};

/// Parent k of an arc; one beyond its ends may be asked for.
inline int parent_of(const Lattice& lattice, const ParentArc& arc, int k) {
  const int columns = lattice.columns(), unwrapped = arc.first + arc.step * k;
  return unwrapped < 0 ? unwrapped + columns : unwrapped >= columns ? unwrapped - columns : unwrapped;
}

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
  bool keeps_pair(int layer, int bead, const PairDraw& pair);
  bool infeasible_alone(int layer, int bead) const;
  ArcOutcome repair_by_arc(int layer, int bead, int parents);
  bool repair_by_ring(int layer, int bead);

  int parent(const ParentArc& arc, int k) const { return parent_of(state_.lattice(), arc, k); }
  int child_after(const ParentArc& arc, int k) const;
  Interval step_band(const ParentArc& arc, int k, int failed) const;
  void draw_backwards(const ParentArc& arc, int from, int to);
  void set_splits(const ParentArc& arc, int bead, GranusolveRule rule);

  bool pairs_, arcs_;  ///< which rules are in use
  GranusolveState& state_;
  GranusolveDraws& draws_;
  GranusolveWork& work_;
  // Work space of the arcs and the ring, one entry per parent.
  std::vector<Interval> own_, filter_, bands_;
  std::vector<double> split_, numbers_;
};

/// Solves piles of the law granusolve (granusolve.h) bead by bead, in arrays that belong to somebody else: in which
/// order, what a backtrack has unsolved first, and within the effort. A layer is either solved here as a whole, or by a
/// GranusolveGroup that asks for single beads.
class GranusolveSolver {
 public:
  GranusolveSolver(const SamplerSpec& spec, const Lattice& lattice);
  GranusolveSolver(const GranusolveSolver&) = delete;
  GranusolveSolver& operator=(const GranusolveSolver&) = delete;

  void use(const GranusolveArrays& arrays) { state_.use(arrays); }
  /// Begins a pile, which counts as a try. `first`: its first solution, if it is solved again. `load` and `first` must
  /// outlive the pile.
  void begin_pile(std::uint64_t sample, std::span<const double> load, const Pile* first = nullptr);
  /// Draws a layer in bulk and solves what fails: solved, out_of_effort or beyond_window.
  SolveResult solve_layer(int layer);

  // -- for whoever draws layers of several piles in bulk, and repairs pairs there
  RandomKey::Order order(int layer) const { return state_.order(layer); }
  /// Solves the bead at this position of its layer, which becomes the front; `no_pair` says that it has no solution as
  /// it is, nor by the pair rule.
  SolveResult solve_at(int layer, int position, int bead, bool no_pair);
  /// A layer has been drawn elsewhere, or so many beads of it repaired by the pair rule.
  void count_bulk_draw();
  void count_pairs(std::uint64_t beads);
  /// Every bead of the layer has been solved.
  SolveResult end_layer(int layer);

  /// All of it is solved; so many beads by each rule.
  void count_pile(const std::array<std::uint64_t, granusolve_rules>& beads_by);
  /// What was done since the counts were last taken.
  SamplerCounts take_counts() { return std::exchange(work_.counts, {}); }
  const GranusolveState& state() const { return state_; }

 private:
  SolveResult solve_failing(int bead, bool no_pair = false);
  SolveResult solve_bead(int layer, int bead);
  /// solve_bead without counting: a bead of the front layer whose turn has come was counted when the layer was drawn.
  SolveResult solve_counted(int layer, int bead) {
    if (!draws_.try_draw(layer, bead)) return repair(layer, bead);
    state_.set_rule(state_.at(layer, bead), GranusolveRule::first_draw);
    return SolveResult::solved;
  }
  SolveResult repair(int layer, int bead, bool no_pair = false);
  SolveResult solve_pending();
  SolveResult solve_row(int layer);
  SolveResult redraw_row(int layer);
  SolveResult solve_one_pending(int layer, int bead);

  LayerOrder layer_order_;
  GranusolveState state_;
  GranusolveWork work_;
  GranusolveDraws draws_;
  GranusolveRules rules_;
};

}  // namespace granuscope
