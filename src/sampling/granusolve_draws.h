#pragma once
#include <cstdint>
#include <vector>

#include "model/pile.h"
#include "sampling/granusolve_state.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "sampling/uniform_bits.h"

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

}  // namespace granuscope
