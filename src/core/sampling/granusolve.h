#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sampling/granusolve_solver.h"
#include "sampling/group_kernels.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"

namespace granuscope {

class GranusolveGroup;

/// What a GranusolveSolver works on where a pile is solved by itself, apart from the pile's own forces.
class GranusolveMemory {
 public:
  /// The arrays of a pile of this memory's lattice, which must hold as long. Each layer is cleared when it is begun.
  GranusolveArrays arrays(Pile& pile);
  /// How many beads were solved by each rule.
  std::array<std::uint64_t, granusolve_rules> beads_by() const;

 private:
  std::vector<double> H_, first_uniform_;
  std::vector<std::uint32_t> attempts_;
  std::vector<std::uint8_t> unsolved_, rule_, backtracks_;
  std::vector<std::uint64_t> failing_;
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
///     backtrack.
///  3. ring: if the arc would meet itself, all parents of the layer: two rounds of tightening both ways, one parent
///     drawn, the others as an arc between its two sides.
///  4. backtrack: the ancestors 2 + (backtracks of this bead so far) layers up, and all their solved descendants, are
///     unsolved and solved again, topmost layer first; above the top layer the set widens sideways instead.
///
/// Beads of the layer whose turn has not come yet restrict nothing.
///
/// As long as no layer below it has been begun, nothing depends on the split of a bead; however often it draws again,
/// it may keep its first number, and does.
///
/// The effort counts a bead once when its layer is drawn, whatever changes above it before its turn has come, and then
/// each time it is tried again after a backtrack, or solved again after a change of its parents.
///
/// Solving again (draw_again), a bead draws another number than its own only where a repair changes its split, and at
/// the top of a backtrack.
///
/// Where what stands: the state of a pile and its invariants in granusolve_state.h, the numbers that beads draw,
/// the rules and the order of it all in granusolve_solver.h, eight piles side by side in GranusolveGroup.
class GranusolveSampler final : public Sampler {
 public:
  GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice);
  ~GranusolveSampler() override;
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override;
  /// Several piles side by side (GranusolveGroup): the same piles, several times as fast.
  std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                         std::span<const std::span<const double>> loads,
                                         std::span<std::optional<SamplingFailure>> failures) override;
  void keep_layers(const KeptLayers& kept) override;

  /// Room for one pile, for groups that have to draw one by itself.
  Pile& spare_pile();

 private:
  std::optional<SamplingFailure> solve_pile(std::uint64_t sample, std::span<const double> load, const Pile* first,
                                            Pile& pile);

  SamplerSpec spec_;
  GranusolveSolver solver_;
  GranusolveMemory memory_;
  std::vector<std::unique_ptr<GranusolveGroup>> together_;  ///< made when they are first needed
  std::optional<Pile> spare_pile_;
  std::optional<KeptLayers> kept_layers_;  ///< none: all forces of all
};

/// Eight piles of the law granusolve side by side, one to a vector lane, in memory that interleaves them. They share
/// the order in which the beads of a layer are solved (RandomKey::layer_order), so that a layer is drawn in bulk and
/// its failing beads are repaired by the pair rule in all piles at once (group_kernels.h). What that cannot solve
/// (arcs, rings, backtracks, rounding) is done for one pile by a GranusolveSolver that works on the same memory. The
/// piles are those of GranusolveSampler::draw, bit for bit.
///
/// Of the layers above the front only a window is held: a backtrack hardly ever reaches farther up, and the memory of
/// whole piles does not fit the caches. A layer that leaves the window is checked, its rules are counted, and if it is
/// to be kept, what is measured of it is. A pile whose backtrack would leave the window is evicted, and drawn anew by
/// itself; it is the same pile.
///
/// Where the time goes: `granuscope bench sampler`. At mu = 0.3 two positions of three have a failing pile, 1.5 of the
/// eight on average; pairs and the search take two thirds of all time. At mu = 0.1 a backtrack costs as much as seventy
/// beads; deep piles backtrack half as often again as shallow ones. What did not help: a place of its own in the layer
/// for each pile (gathers, or copies to and from eight lanes, cost more than the empty lanes); asking for memory ahead,
/// of the next layer, of the rows of a backtrack, or of the layers that are checked; whole-vector instead of masked
/// stores; drawing the bead ahead as it is within the repair, while the splits above it are at hand (too few registers:
/// 4 to 8 % slower); a window of 16 layers; huge pages; in backtracks: no data-dependent branches, the numbers of the
/// next row found with those of this one (2 % slower), or those of a repair all at once (0), attempts gathered with
/// vectors (3 %), few numbers without vectors, whole rows and their pairs in vectors, from memory and back (2 %); after
/// a backtrack, giving the bead that set out back to the vectors of all piles; copying kept forces with vectors, or
/// past the caches. What helped little: backtracks of two or three layers drawn in registers from end to end gain 5 %
/// at 0.1 for 500 lines; two groups in turn gain 8 % at mu = 0.15 and 0.3 and 13 % at 0.8; at 0.1 they gain 1 to 3 % in
/// piles of up to 500 columns and lose 2 % in 1000. Layers finished four or eight at a time, so that their memory is
/// read once, gain 1 to 2 % at 0.1 and lose as much at 0.3 in piles of 1000 columns. Repairs that tell infeasible beads
/// from those that arcs may help gain 0.7 % at 0.1 and lose 1.5 % at 0.3; the solver of one pile tells them in little
/// time.
class GranusolveGroup {
 public:
  /// `kept`: what is to be kept for whoever measures the piles; none: all forces of all layers. `alone` draws the piles
  /// that are evicted, and counts them.
  GranusolveGroup(const SamplerSpec& spec, const Lattice& lattice, const std::optional<KeptLayers>& kept,
                  GranusolveSampler& alone);

  /// Whether groups of this size should be drawn side by side; the largest piles need too much memory for it.
  static bool fits(const Lattice& lattice, const KeptLayers* kept = nullptr);
  /// Of a group that keeps what is told of these layers, or the weights of all, in bytes. One that keeps all forces
  /// takes four times as much.
  static double memory(const Lattice& lattice, const KeptLayers* kept = nullptr);

  /// At most eight piles that share the order of their layers: what draw() of this group, or of two at once, is to
  /// draw. They are consecutive samples, or the same one under several loads.
  void prepare(std::uint64_t first_sample, bool same_sample, std::span<const std::span<const double>> loads,
               std::span<std::optional<SamplingFailure>> failures);

  /// Draws the piles last prepared.
  void draw();
  /// Draws those of two groups, whose repairs are done two at a time.
  static void draw(GranusolveGroup& a, GranusolveGroup& b);

  PileGroup piles() const;
  /// What was done since the last call.
  SamplerCounts take_counts();

 private:
  void lap(Phase phase) {
    if (front_.times != nullptr) front_.times->end(phase);
  }
  GroupRow row(int layer) const;
  void draw_layer_in_bulk();
  void begin_layer(int layer);
  void end_layer();
  bool layer_is_solved() const { return front_.position == front_.columns; }
  void solve_rest_of_layer();
  void solve_singly();
  void note(std::size_t lane, SolveResult result);
  void hand_over_counts(std::size_t lane);
  void finish_layer(int layer);
  ForceRow forces(int layer) const;
  void draw_evicted_piles();
  void keep_evicted_layer(const Pile& pile, int layer, std::size_t lane);
  void finish();

  GroupFront front_;
  GranusolveSampler& alone_;
  std::span<const std::span<const double>> loads_;  ///< of the piles being drawn
  std::span<std::optional<SamplingFailure>> failures_;
  // State of the layers in the window, [window, columns, 8]; a layer's place is its number modulo the window.
  AlignedArray<double> V_R_, V_L_, H_, H_R_;
  AlignedArray<std::uint32_t> attempts_;
  AlignedArray<std::uint8_t> unsolved_, rule_, backtracks_;
  bool keeps_forces_;
  std::vector<int> kept_;                                           ///< place of each layer among those kept, or -1
  AlignedArray<double> kept_weights_;                               ///< [kept layers, columns, 8]; or none, and instead
  AlignedArray<double> kept_H_;                                     ///< of the same shape, or none
  AlignedArray<double> kept_V_R_, kept_V_L_, kept_H_R_, kept_H_L_;  ///< all forces, of the same shape
  std::vector<LayerMoments> moments_;                               ///< [kept layers]
  AlignedArray<double> first_uniform_, half_load_;                  ///< [columns, 8]
  AlignedArray<std::uint64_t> failing_, changed_;                   ///< [columns] bytes and padding
  FrictionCone cone_;
  std::array<std::unique_ptr<GranusolveSolver>, group_lanes> solvers_;
  SamplerSpec spec_;
  std::array<IdentityResiduals, group_lanes> residuals_{};
  RuleCounts beads_by_{};  ///< of the layers that have left the window
  GroupIdentities identities_;
  unsigned evicted_ = 0;  ///< those a backtrack of which has left the window
  int finished_ = 0;      ///< layers above it are final
  Lattice lattice_;
};

}  // namespace granuscope
