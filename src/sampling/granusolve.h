#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "model/equilibrium.h"
#include "model/friction_cone.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "sampling/uniform_bits.h"

namespace granuscope {

class GranusolveGroup;

/// The state of a pile that is being solved, and of the layer at its front: arrays of shape [layers, columns] and
/// [columns], of which every stride-th entry belongs to this pile. Piles side by side share the arrays.
struct GranusolveState {
  double *V_R, *V_L, *H_R;
  double* H_L;              ///< H - H_R; none if nobody reads it
  double* H;                ///< total horizontal force entering each bead
  std::uint32_t* attempts;  ///< attempts after the first
  std::uint8_t* unsolved;   ///< not 0 from a climb on until the bead is solved again
  std::uint8_t* rule;       ///< which rule gave the bead its value
  std::uint8_t* climbs;     ///< that set out from the bead, at most 255; it then counts as climbed
  double* first_uniform;    ///< of the front layer
  std::uint64_t* failing;   ///< front layer, a bit for each bead: its bulk draw does not hold (any more)
  std::uint64_t* changed;   ///< and the parents have changed since; none if nobody reads it
  std::size_t stride = 1, lane = 0;
};

/// The law "granusolve": layers are solved from top to bottom, each from a random bead in a random direction; every
/// bead draws H_R uniformly on its interval. A bead whose interval is empty makes the beads above it change the forces
/// they share with it (GranuSolve, Breton 2000, as described in the paper). The choices that shape the law:
///
///  1. pair: the split of H in its two parents is redrawn uniformly on what leaves this bead and the already solved
///     siblings solvable; then this bead and the siblings draw again.
///  2. arc: if that set is empty, the same for the 4, 8, 16, ... parents around the bead, parents outside held. A
///     filter of intervals runs along the arc in the layer's direction, then back along it each parent is uniform on
///     what the filter and the parent before it leave. If the arc is infeasible even without the held neighbours,
///     climb.
///  3. ring: if the arc would meet itself, all parents of the layer: two rounds of tightening both ways, one parent
///     drawn, the others as an arc between its two sides.
///  4. climb: the ancestors 2 + (climbs of this bead so far) layers up, and all their solved descendants, are unsolved
///     and solved again, topmost layer first; above the top layer the set widens sideways instead.
///
/// Beads of the layer whose turn has not come yet restrict nothing.
///
/// As long as no layer below it has been begun, nothing depends on the split of a bead; however often it draws again,
/// it may keep its first number, and does.
///
/// The effort counts a bead once when its layer is drawn, whatever changes above it before its turn has come, and then
/// each time it is tried again after a climb, or solved again after a change of its parents.
///
/// Solving again (draw_again), a bead draws another number than its own only where a mend changes its split, and at the
/// top of a climb.
class GranusolveSampler final : public Sampler {
 public:
  GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice);
  ~GranusolveSampler() override;
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override;
  /// Several piles side by side (granusolve_group.h): the same piles, several times as fast.
  std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                         std::span<const std::span<const double>> loads,
                                         std::span<std::optional<SamplingFailure>> failures) override;
  void keep_layers(std::span<const int> layers) override;

 private:
  friend class GranusolveGroup;

  /// Which rule gave a bead its value, for the counts.
  enum class Rule : std::uint8_t { first_draw, pair, arc, ring, climb };
  static constexpr std::size_t rules = 5;
  enum class Mend {
    done,
    climbed  ///< beads above have to be solved, and the bead tried again
  };
  enum class ArcOutcome { mended, too_narrow, hopeless };

  /// States of a bead that a climb has unsolved (0: it is solved). Those at the top of the climb draw new numbers in
  /// any case: the old ones led into a dead end.
  static constexpr std::uint8_t below_climb = 1, top_of_climb = 2;
  /// The numbers kept from a first solution came partly from its later attempts; those of the second solution start
  /// here, so that they are independent of them.
  static constexpr std::uint32_t attempts_before_solving_again = std::uint32_t{1} << 23;

  /// Neighbouring parents of one layer, first + k step for k = 0 .. count-1, changed together.
  struct Arc {
    int layer;  ///< of the beads below the parents
    int first, count, step;
  };

  /// Neighbouring beads of a layer, from left to right.
  struct Run {
    int first = 0, count = 0;
    /// The least run that holds this one and another.
    void include(int other, int others, int columns);
  };
  class InOrder;

  std::optional<SamplingFailure> solve_pile(std::uint64_t sample, std::span<const double> load, Pile& pile);
  void use_own_state(Pile& pile);
  void begin_pile(std::uint64_t sample, std::span<const double> load);
  void draw_layer_in_bulk(int layer);
  void keep_splits(int layer);
  void begin_layer(int layer);
  int find_failing_between(int low, int high, int direction) const;
  int next_failing();
  bool solve_failing(int bead, bool no_pair = false);
  std::optional<SamplingFailure> solve_layer(int layer);
  /// Solves everything that a climb has unsolved, topmost layer first. False if the effort ran out.
  bool solve_pending();
  bool solve_one_pending(int layer, int bead);
  bool solve_in_order(int layer);
  bool redraw_in_order(int layer);
  bool mends_pairs() const { return spec_.rules == MendingRules::all || spec_.rules == MendingRules::no_arcs; }
  void count_pile();
  void add_pile(const std::array<std::uint64_t, rules>& beads_by);
  void set_rule(std::size_t bead, Rule rule);

  Incoming incoming(int layer, int bead) const;
  Interval interval_of(int layer, int bead) const;
  Interval difference_band(int layer, int bead) const;
  bool solved(int layer, int bead) const;
  int position(int layer, int bead) const;

  double choose_split(int layer, int bead, Outgoing out, Interval interval);
  bool try_draw(int layer, int bead);
  Mend solve_bead(int layer, int bead);
  Mend solve_counted(int layer, int bead);
  Mend mend(int layer, int bead, bool no_pair = false);
  bool change_parents(int layer, int bead, bool no_pair);
  bool mend_by_pair(int layer, int bead);
  bool hopeless_alone(int layer, int bead) const;
  ArcOutcome mend_by_arc(int layer, int bead, int parents);
  bool mend_by_ring(int layer, int bead);
  Mend climb(int layer, int bead);
  void unsolve(int layer, int first, int count);

  int parent(const Arc& arc, int k) const;
  int child_after(const Arc& arc, int k) const;
  Interval step_band(const Arc& arc, int k, int failed) const;
  void take_numbers(const Arc& arc, int from);
  void draw_backwards(int from, int to);
  void set_split(int layer, int bead, double H_R);
  void renew_child(int layer, int bead);
  UniformPair next_uniforms(int layer, int bead, int used);
  /// From here on the bead at the cursor counts as solved.
  void step_cursor() {
    ++cursor_;
    cursor_bead_ = order_[static_cast<std::size_t>(front_)].direction > 0 ? lattice_.next(cursor_bead_)
                                                                          : lattice_.previous(cursor_bead_);
  }
  /// A bead of the front layer whose turn has not come will be solved singly.
  void forget_draw(int bead) {
    const std::size_t bit = at(bead) + state_.lane;
    state_.failing[bit / 64] |= std::uint64_t{1} << (bit % 64);
    if (state_.changed != nullptr) state_.changed[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  /// Such a bead has been drawn again as it is.
  void note_draw(int bead, bool fails) {
    const std::size_t bit = at(bead) + state_.lane;
    const std::uint64_t mask = std::uint64_t{1} << (bit % 64);
    std::uint64_t& failing = state_.failing[bit / 64];
    failing = fails ? failing | mask : failing & ~mask;
    if (state_.changed != nullptr) state_.changed[bit / 64] &= ~mask;
  }

  /// Index into the arrays of state_.
  std::size_t at(int layer, int bead) const { return lattice_.index(layer & layer_mask_, bead) * state_.stride; }
  std::size_t at(int bead) const { return static_cast<std::size_t>(bead) * state_.stride; }

  FrictionCone cone_;
  SamplerSpec spec_;
  PhiloxKeys philox_keys_;

  const Pile* first_ = nullptr;        ///< while a pile is solved again: its first solution
  std::vector<double> first_numbers_;  ///< and the numbers of that

  // State of the pile being drawn; arrays have shape [layers, columns].
  std::span<const double> load_;
  RandomKey key_{0, 0};
  bool eight_at_once_ = false;  ///< numbers of later attempts, where several are needed
  GranusolveState state_{};
  /// The state of the layers front_ - window_ + 1 .. front_ is kept, in the place of their number's last bits.
  int window_ = std::numeric_limits<int>::max(), layer_mask_ = std::numeric_limits<int>::max();
  bool beyond_window_ = false;                ///< a climb would have left the window: the pile is given up
  std::vector<RandomKey::Order> order_;       ///< per layer
  std::vector<Run> pending_;                  ///< per layer: all that a climb has unsolved is among these
  int topmost_pending_ = 0;                   ///< no layer above it has any
  int front_ = 0;                             ///< layer being solved
  int cursor_ = 0;                            ///< position in its order; beads from there on are not solved yet
  int cursor_bead_ = 0;                       ///< the bead at that position
  std::vector<double> slack_;                 ///< front layer: length of the interval of each bead, as drawn in bulk
  std::vector<double> half_load_, no_force_;  ///< what enters the top layer
  std::uint64_t solutions_ = 0, max_solutions_ = 0;

  // Work space of the arcs and the ring, one entry per parent.
  std::vector<Interval> own_, filter_, bands_;
  std::vector<double> split_, numbers_;

  // What state_ points to if the pile is solved by itself, apart from the pile's own forces.
  std::vector<double> own_H_, own_first_uniform_;
  std::vector<std::uint32_t> own_attempts_;
  std::vector<std::uint8_t> own_unsolved_, own_rule_, own_climbs_;
  std::vector<std::uint64_t> own_failing_;

  std::vector<std::unique_ptr<GranusolveGroup>> together_;  ///< made when they are first needed
  std::optional<Pile> lost_pile_;                           ///< where piles that these have lost are drawn
  std::optional<std::vector<int>> kept_layers_;             ///< none: all forces of all
};

}  // namespace granuscope
