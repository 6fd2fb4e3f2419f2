#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sampling/granusolve_solver.h"
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
/// the rules and the order of it all in granusolve_solver.h, eight piles side by side in granusolve_group.h.
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

}  // namespace granuscope
