#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>

#include "sampling/granusolve_draws.h"
#include "sampling/granusolve_rules.h"
#include "sampling/granusolve_state.h"
#include "sampling/sampler.h"

namespace granuscope {

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
