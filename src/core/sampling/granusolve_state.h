#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "sampling/random_key.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// Which rule gave a bead its value, for the counts.
enum class GranusolveRule : std::uint8_t { first_draw, pair, arc, ring, backtrack };
inline constexpr std::size_t granusolve_rules = 5;

/// States of a bead that a backtrack has unsolved (0: it is solved). Those at the top of the backtrack draw new numbers
/// in any case: the old ones led into a dead end.
inline constexpr std::uint8_t below_backtrack = 1, top_of_backtrack = 2;

/// More layers than any lattice has, and a power of two.
inline constexpr int every_layer = 1 << 30;

/// Arrays of a pile that is being solved, of shape [window, columns], and of the layer at its front, [columns]; every
/// stride-th entry belongs to this pile. Piles side by side share the arrays. They belong to somebody else.
struct GranusolveArrays {
  double *V_R = nullptr, *V_L = nullptr, *H_R = nullptr;
  double* H_L = nullptr;               ///< H - H_R; none if nobody reads it
  double* H = nullptr;                 ///< total horizontal force entering each bead
  std::uint32_t* attempts = nullptr;   ///< attempts after the first
  std::uint8_t* unsolved = nullptr;    ///< not 0 from a backtrack on until the bead is solved again
  std::uint8_t* rule = nullptr;        ///< GranusolveRule, of those above backtrack
  std::uint8_t* backtracks = nullptr;  ///< that set out from the bead, at most 255; it then counts as backtracked
  double* first_uniform = nullptr;     ///< of the front layer
  std::uint64_t* failing = nullptr;    ///< front layer, a bit for each bead: its bulk draw does not hold (any more)
  std::uint64_t* changed = nullptr;    ///< and the parents have changed since; none if nobody reads it
  std::size_t stride = 1, lane = 0;    ///< entry of bead i in a row: stride i, from an array that begins at the lane
  int window = every_layer;            ///< layers held, a power of two: a layer's place is its number modulo this
};

/// Neighbouring beads of a layer, from left to right.
struct BeadRun {
  int first = 0, count = 0;
  /// The least run that holds this one and another.
  void include(int other, int others, int columns);
};

/// A pile of the law granusolve (granusolve.h) while it is solved: what is known of its beads, which layer is being
/// solved (the front), how far its order has come (the cursor: a position, and the bead there), and what a backtrack
/// has left to be solved again. Random numbers, counts and rules are not its business.
///
/// Who may write what, and when. The layer is begun by whoever draws it in bulk (GranusolveDraws::begin_layer for a
/// pile by itself, GranusolveGroup for eight); then only beads change that are solved singly: by the kernels of a group
/// (group_kernels.h, pairs at the front) and by GranusolveSolver.
///
///   V_R, V_L, H   of a bead, together, when it draws (GranusolveDraws::try_draw, redraw_row, the kernels). A solved
///                 bead hangs from its parents as they are now: H = H_R(A) + H_L(B), by 64 ulps at most another one
///                 (random_key.h), and V_R, V_L follow from it to the bit.
///   H_R, H_L      likewise, and by the rules that change the splits of parents, who afterwards renew both children of
///                 each such parent: a solved one draws again, one whose turn has not come is forgotten. A solved
///                 bead's split lies on its interval, up to rounding.
///   failing       of the front layer: set for all beads when it is begun; forget_draw() sets it for a bead whose turn
///                 has not come. Nobody clears it: behind the cursor it means nothing. From the cursor on, a bead that
///                 does not fail is as good as solved: its first number holds under its parents as they are now.
///   changed       goes with failing in a group: the bead failed, or was made to, for parents that have changed since
///                 it was drawn, so that it may have a solution as it is. Cleared when the layer is begun; changed
///                 implies failing.
///   unsolved      0 when a layer is begun; unsolve() sets it above the front and before the cursor, never from the
///                 cursor on (such beads are forgotten instead); who solves the bead clears it. What hangs below an
///                 unsolved bead is unsolved or forgotten.
///   pending       of each layer, a run that holds all its unsolved beads; written with them. topmost_pending() is
///                 above none of these layers, but for the one that GranusolveSolver::solve_pending is at. Nothing is
///                 pending between two beads of the front layer.
///   attempts      attempts_at_first when a layer is begun; one more for each further pair of numbers a bead is given
///                 (GranusolveDraws, redraw_row, the kernels), whatever becomes of them. Never less: no number is used
///                 twice.
///   rule          first_draw when a layer is begun, and whenever a bead is solved as it is; pair, arc or ring on the
///                 bead whose parents that rule has changed. Neighbours that draw again with it keep theirs.
///   backtracks    0 when a layer is begun; one more for each backtrack that sets out from the bead
///                 (GranusolveRules::backtrack).
///   cursor        the beads before it are solved or pending; those from it on restrict nothing. It only goes on.
///
/// check() verifies this where a layer has been solved, and check_run() what a backtrack has had solved again.
class GranusolveState {
 public:
  GranusolveState(const SamplerSpec& spec, const Lattice& lattice);

  const Lattice& lattice() const { return lattice_; }
  const FrictionCone& cone() const { return cone_; }
  DrawnVariable drawn() const { return drawn_; }
  const GranusolveArrays& arrays() const { return arrays_; }
  void use(const GranusolveArrays& arrays) {
    arrays_ = arrays;
    layer_mask_ = arrays.window - 1;
  }

  /// A pile under this load, which must outlive it; nothing of it is solved. Attempts are counted from there.
  void begin_pile(const RandomKey& key, LayerOrder order, std::span<const double> load,
                  std::uint32_t attempts_at_first = 0);
  std::span<const double> load() const { return load_; }
  const LoadLine& load_line() const { return load_line_; }
  /// Of each bead by itself.
  double half_weight() const { return half_weight_; }
  std::uint32_t attempts_at_first() const { return attempts_at_first_; }

  // -- where the pile has come to
  int front() const { return front_; }
  int cursor() const { return cursor_; }
  int cursor_bead() const { return cursor_bead_; }
  RandomKey::Order order(int layer) const { return order_[static_cast<std::size_t>(layer)]; }
  /// That bead stands at that position of the layer's order; -1 at the position after the last.
  void move_cursor(int layer, int position, int bead) {
    front_ = layer;
    cursor_ = position;
    cursor_bead_ = bead;
  }
  /// From here on the bead at the cursor counts as solved.
  void step_cursor() {
    ++cursor_;
    cursor_bead_ = order(front_).direction > 0 ? lattice_.next(cursor_bead_) : lattice_.previous(cursor_bead_);
  }
  /// Moves the cursor on to the next bead of the front layer that has to be solved singly; -1 if there is none.
  int next_failing();
  /// Place of a bead in the order of its layer.
  int position(int layer, int bead) const {
    const RandomKey::Order order = this->order(layer);
    const int distance = order.direction > 0 ? bead - order.first_bead : order.first_bead - bead;
    return distance < 0 ? distance + lattice_.columns() : distance;
  }
  /// A bead of the front layer whose turn has not come, or has just come.
  bool awaits_turn(int layer, int bead) const { return layer == front_ && position(layer, bead) >= cursor_; }
  bool solved(int layer, int bead) const { return arrays_.unsolved[at(layer, bead)] == 0 && !awaits_turn(layer, bead); }

  // -- beads
  /// Index into the arrays.
  std::size_t at(int layer, int bead) const { return lattice_.index(layer & layer_mask_, bead) * arrays_.stride; }
  std::size_t at(int bead) const { return static_cast<std::size_t>(bead) * arrays_.stride; }
  Incoming incoming(int layer, int bead) const {
    if (layer == 0) {
      return with_weight(top_load(load_[static_cast<std::size_t>(bead)], load_line_), half_weight_);
    }
    const std::size_t a = at(layer - 1, lattice_.upper_left(layer, bead));
    const std::size_t b = at(layer - 1, lattice_.upper_right(layer, bead));
    return with_weight({arrays_.V_R[a], arrays_.V_L[b], arrays_.H_R[a] + (arrays_.H[b] - arrays_.H_R[b])},
                       half_weight_);
  }
  /// Where a solved bead may move its H_R, whatever hangs below it.
  Interval interval_of(int layer, int bead) const;
  /// Band of H_R(P) - H_R(Q) that keeps the bead solvable, P and Q being its upper-left and upper-right parents: its
  /// H = H_R(P) + H(Q) - H_R(Q), while its V_UL and V_UR do not depend on the splits.
  Interval difference_band(int layer, int bead) const;
  /// H_R of a bead whose other forces are set, at a number of [0, 1), on its interval or a part of it.
  double split_on(int layer, int bead, Interval interval, double uniform) const {
    if (drawn_ == DrawnVariable::force) return point_at(interval, uniform);
    const std::size_t here = at(layer, bead);
    return split_at(drawn_, {arrays_.V_R[here], arrays_.V_L[here]}, arrays_.H[here], interval, uniform);
  }
  void set_split(int layer, int bead, double H_R) {
    const std::size_t here = at(layer, bead);
    arrays_.H_R[here] = H_R;
    if (arrays_.H_L != nullptr) arrays_.H_L[here] = arrays_.H[here] - H_R;
  }
  void set_rule(std::size_t at, GranusolveRule rule) { arrays_.rule[at] = static_cast<std::uint8_t>(rule); }

  // -- what has to be solved again
  /// A bead of the front layer whose turn has not come will be solved singly.
  void forget_draw(int bead) {
    const std::size_t bit = at(bead) + arrays_.lane;
    arrays_.failing[bit / 64] |= std::uint64_t{1} << (bit % 64);
    if (arrays_.changed != nullptr) arrays_.changed[bit / 64] |= std::uint64_t{1} << (bit % 64);
  }
  /// The beads `first` .. `first + count - 1` of a layer and all that hangs below them.
  void unsolve(int layer, int first, int count);
  const BeadRun& pending(int layer) const { return pending_[static_cast<std::size_t>(layer)]; }
  /// The layer, all of which is solved, has nothing pending any more.
  void clear_pending(int layer) { pending_[static_cast<std::size_t>(layer)].count = 0; }
  int topmost_pending() const { return topmost_pending_; }
  /// From here on topmost_pending() tells what will be pending from now on: lattice().layers() if nothing.
  void watch_pending() { topmost_pending_ = lattice_.layers(); }

  // -- invariants (above); both throw std::logic_error with what is broken and where
  /// Those of the cursor, of what is pending, and of the beads of the front layer and the one above it. To be called
  /// between two beads of the front layer.
  void check() const;
  /// That the beads of a run which have had their turn are solved, and hang from their parents as they are.
  void check_run(int layer, const BeadRun& run) const;

 private:
  int find_failing_between(int low, int high, int direction) const;
  bool bit_of(const std::uint64_t* bits, int bead) const {
    const std::size_t bit = at(bead) + arrays_.lane;
    return (bits[bit / 64] >> (bit % 64) & 1) != 0;
  }
  void check_row(int layer) const;
  void check_balance(int layer, int bead) const;

  Lattice lattice_;
  FrictionCone cone_;
  DrawnVariable drawn_;
  GranusolveArrays arrays_;
  int layer_mask_ = every_layer - 1;
  std::span<const double> load_;
  std::uint32_t attempts_at_first_ = 0;
  std::vector<RandomKey::Order> order_;  ///< per layer
  std::vector<BeadRun> pending_;         ///< per layer
  LoadLine load_line_;
  double half_weight_ = 0;
  int topmost_pending_ = 0;
  int front_ = 0, cursor_ = 0, cursor_bead_ = 0;
};

/// Whether the solver calls the checks above: not where assertions are off.
#ifdef NDEBUG
inline constexpr bool checks_granusolve_state = false;
#else
inline constexpr bool checks_granusolve_state = true;
#endif

}  // namespace granuscope
