#pragma once
#include <hwy/aligned_allocator.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/audit.h"
#include "model/equilibrium.h"
#include "model/lattice.h"
#include "model/pile.h"

namespace granuscope {
/// Piles that are solved side by side, one to a vector lane: bead i of pile k is entry 8 i + k of a row.
inline constexpr std::size_t group_lanes = 8;

/// Memory that vectors of any width may be read from and written to.
template <typename T>
using AlignedArray = hwy::AlignedFreeUniquePtr<T[]>;

/// Throws std::bad_alloc where there is not so much memory.
template <typename T>
AlignedArray<T> aligned_array(std::size_t size) {
  AlignedArray<T> array = hwy::AllocateAligned<T>(size);
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

/// What piles drawn side by side spend their time on.
enum class Phase : std::uint8_t {
  first_draws,  ///< of whole layers
  search,       ///< for beads without solution, and beads that are solved as they are after all
  pairs,        ///< repairs by the pair rule, all piles at once
  one_by_one,   ///< arcs, rings, backtracks, the ends of a layer's order
  finishing     ///< identities, counts, what is kept of layers
};
inline constexpr std::size_t phases = 5;

/// While one lives, piles drawn side by side in this thread note how long each phase takes. Reading the clock twice a
/// repair slows them down, so that only the shares mean something.
class PhaseTimes {
 public:
  PhaseTimes();
  ~PhaseTimes();
  PhaseTimes(const PhaseTimes&) = delete;
  PhaseTimes& operator=(const PhaseTimes&) = delete;

  /// Of the time noted so far; all 0 if there is none.
  std::array<double, phases> shares() const;

  /// That of this thread, if one lives.
  static PhaseTimes* current();
  void begin();
  /// What has passed since begin() or the last end() belongs to `phase`.
  void end(Phase phase);

 private:
  PhaseTimes* outer_;
  std::uint64_t last_ = 0;
  std::array<std::uint64_t, phases> ticks_{};
};

/// Forces of a row of beads: entry 0 is the first bead of the first pile.
struct ForceRow {
  const double *V_R, *V_L, *H_R, *H_L;
  bool totals = false;  ///< H_L is the H that enters each bead instead, of which H_L is what H_R leaves
};

/// What is measured of a layer: sums over its beads, for each pile.
struct LayerMoments {
  std::array<double, group_lanes> thrust{};    ///< of H_R - H_L
  std::array<double, group_lanes> variance{};  ///< of (w - mean)^2, w = V_R + V_L
};

/// The moments of a row of `beads` beads of 1 or group_lanes piles (`stride`), summed bead by bead in their order. One
/// pile gives H_L, not totals. `mean`: of w, exactly known. Writes the weight w of each entry to `weight`, if that is
/// not null.
LayerMoments measure_row(const ForceRow& row, std::size_t beads, std::size_t stride, double mean, double* weight);

/// Where a pile could not be completed within the stated effort.
struct SamplingFailure {
  int layer;
};

/// The layers that whoever measures piles reads, ascending, and what of them.
struct KeptLayers {
  std::vector<int> layers;
  bool horizontal = false;  ///< the horizontal force of each bead as well as its weight
  bool forces = false;      ///< instead of both, all forces of its contacts, of a model that has them
};

/// Mean weight that leaves the beads of a layer under loads of mean 1.
inline double mean_weight(double bead_weight, int layer) { return 1 + bead_weight * (layer + 1); }

/// Piles that were drawn together, to be measured where they lie; it owns nothing. Arrays have the shape [kept layers,
/// columns, stride]: bead i of pile k is entry row(layer) + stride i + k.
struct PileGroup {
  Lattice lattice;
  std::size_t stride = 1;                                                       ///< 1 or group_lanes
  std::size_t piles = 1;                                                        ///< at most stride
  const double *V_R = nullptr, *V_L = nullptr, *H_R = nullptr, *H_L = nullptr;  ///< all forces, as in Pile; or none
  const double* weights = nullptr;        ///< then, instead of them: V_R + V_L of each bead
  const double* horizontal = nullptr;     ///< and, where asked for, H_R + H_L
  std::span<const LayerMoments> moments;  ///< of each kept layer, where they were found while the piles were drawn
  std::span<const int> kept;              ///< place of each layer among the kept ones, -1: none; empty: all are kept
  std::span<const std::span<const double>> loads;  ///< of each pile
  LoadLine load_line = {};                         ///< of all of them
  double bead_weight = 0;                          ///< of each bead by itself
  std::span<const IdentityResiduals> residuals;    ///< of each pile, where they were found while it was drawn

  /// What a model counts beside the moments, [kept layers, names, group_lanes]: means over a layer's beads.
  std::span<const char* const> extra_names = {};
  const double* extras = nullptr;

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, first_sample = 0;
  std::uint64_t sample_step = 1;  ///< from pile to pile; 0: one sample under several loads

  /// Entry of pile 0's first bead of a kept layer. Throws std::logic_error if the layer was not kept.
  std::size_t row(int layer) const { return lattice.index(place_of(layer), 0) * stride; }
  /// What the weights of the beads of a layer and of those above it come to, per bead of the layer.
  double weight_of_beads(int layer) const { return bead_weight * (layer + 1); }
  /// Of the bead at an entry.
  double weight(std::size_t entry) const { return weights != nullptr ? weights[entry] : V_R[entry] + V_L[entry]; }
  /// Likewise the horizontal force that it hands down; of a group that keeps all forces or has been asked for it.
  double H(std::size_t entry) const { return horizontal != nullptr ? horizontal[entry] : H_R[entry] + H_L[entry]; }
  /// Of a kept layer, where all forces are kept.
  ForceRow forces(int layer) const {
    const std::size_t at = row(layer);
    return {V_R + at, V_L + at, H_R + at, H_L + at};
  }
  /// Those of a kept layer.
  LayerMoments moments_of(int layer) const;
  /// Extra number `which` of pile k in a kept layer.
  double extra(int layer, std::size_t which, std::size_t k) const {
    return extras[(static_cast<std::size_t>(place_of(layer)) * extra_names.size() + which) * group_lanes + k];
  }

 private:
  int place_of(int layer) const;
};

/// A single pile as a group of one; `load` holds the pile's load while the group is in use.
PileGroup group_of(const Pile& pile, const std::span<const double>& load);

/// Finds the residuals of model/audit.h for up to eight piles at once, with the widest vectors the machine has,
/// layer by layer from the top on.
class GroupIdentities {
 public:
  /// Begins with the top layer of piles under these loads.
  void begin(const Lattice& lattice, std::size_t stride, std::span<const std::span<const double>> loads,
             double bead_weight);
  /// The next layer, with the two above it; the top two layers read none or one of these.
  void add_layer(const ForceRow& here, const ForceRow& above, const ForceRow& two_above);
  /// Of each pile so far.
  const std::array<IdentityResiduals, group_lanes>& residuals() const { return worst_; }

 private:
  using Lanes = std::array<double, group_lanes>;

  Lattice lattice_{{4, 1}};
  std::size_t stride_ = 1, piles_ = 0;
  double bead_weight_ = 0;
  int layer_ = 0;
  Lanes loads_{}, largest_above_{}, largest_middle_{}, largest_H_{};
  std::array<IdentityResiduals, group_lanes> worst_{};
};

/// The residuals of a group of which all forces of all layers are kept. Throws std::logic_error if they are not.
std::array<IdentityResiduals, group_lanes> identity_residuals(const PileGroup& group);

/// Throws std::logic_error if an identity of a pile that did not fail is broken. `failures` has an entry per pile.
void assert_identities(const PileGroup& group, std::span<const std::optional<SamplingFailure>> failures);

/// The number in [0, 1] that each bead's split stands for, shape [layers, columns]:
///   u = (H_R - lo)/(hi - lo),   [lo, hi] being the interval of its final state; 1/2 where that is a single point.
void read_split_uniforms(const Pile& pile, std::vector<double>& numbers);

/// The split of bead `at` that keeps its number of the pile `first`, in a state with these forces and this interval
/// (not empty). The very split of `first` where the forces are the same: forces as a function of the numbers are
/// chaotic, and rounding alone would make two piles differ from some depth on.
inline double kept_split(const Pile& first, std::size_t at, double number, Outgoing out, Interval interval) {
  return out.V_R == first.V_R[at] && out.V_L == first.V_L[at] ? first.H_R[at] : point_at(interval, number);
}

/// Which beads of a pile solved again do not stand where their numbers of the pile `first` put them, up to rounding,
/// that is which had to draw another number: 1, otherwise 0. Shape [layers, columns].
void find_redrawn(const Pile& first, const Pile& again, std::vector<unsigned char>& redrawn);

}  // namespace granuscope
