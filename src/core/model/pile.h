#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/lattice.h"

namespace granuscope {
/// The line along which the loads of a pile act.
struct LoadLine {
  double slope = 0;        ///< horizontal force over vertical force, to the right > 0
  double offset = 0;       ///< where it passes the bead's centre, to the right > 0, bead radii: the load's torque
  bool of_excess = false;  ///< so acts only what a load has beyond 1, less than 0 maybe; 1 is upright and central
  bool operator==(const LoadLine&) const = default;
};

/// One complete contact-force network. Forces are those a bead pushes onto the bead below it, V down > 0, H right > 0,
/// in units of the load on one ordinary top bead. All four arrays have shape [layers, columns], row-major, and hold the
/// contacts leaving bead (n, i): _R towards its lower-right, _L towards its lower-left neighbour.
struct Pile {
  explicit Pile(Lattice lattice_)
      : lattice(lattice_),
        V_R(lattice_.beads()),
        V_L(lattice_.beads()),
        H_R(lattice_.beads()),
        H_L(lattice_.beads()),
        load(static_cast<std::size_t>(lattice_.columns()), 1.0) {}

  Lattice lattice;
  std::vector<double> V_R, V_L, H_R, H_L;
  std::vector<double> load;  ///< vertical force on each top bead, shape [columns]
  LoadLine load_line;
  double bead_weight = 0;  ///< of each bead by itself, a vertical force through its centre; no part of `load`

  double mu = 0;           ///< friction coefficient
  std::string law;         ///< name of the law that drew it ("granusolve", "rejection", ...)
  std::uint64_t seed = 0;  ///< with `sample` the key of every random number in it
  std::uint64_t sample = 0;
};

/// Some layers and beads of a lattice: layers first_layer .. first_layer + layers - 1, and in each the beads
/// first_bead, first_bead + 1, ... around the ring, at most all of them once.
struct PileRange {
  int first_layer = 0, layers = 0;
  int first_bead = 0, beads = 0;
  bool horizontal = true;  ///< false: of their forces only the vertical parts; H_R and H_L are empty

  std::size_t size() const { return static_cast<std::size_t>(layers) * static_cast<std::size_t>(beads); }
};

inline PileRange whole_range(const Lattice& lattice) { return {0, lattice.layers(), 0, lattice.columns()}; }

/// A pile, or a part of one, to look at; it owns nothing. The arrays are those of Pile, of shape [range.layers,
/// range.beads].
struct PileView {
  Lattice lattice;  ///< of the whole pile
  PileRange range;
  std::span<const double> V_R, V_L, H_R, H_L;
  std::span<const double> load;  ///< of all columns
  LoadLine load_line;
  double bead_weight = 0;

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, sample = 0;

  /// Place of bead `bead` (0 .. columns - 1) of a layer, both inside the range.
  std::size_t index(int layer, int bead) const {
    const int place = bead >= range.first_bead ? bead - range.first_bead : bead - range.first_bead + lattice.columns();
    return static_cast<std::size_t>(layer - range.first_layer) * static_cast<std::size_t>(range.beads) +
           static_cast<std::size_t>(place);
  }
};

inline PileView view_of(const Pile& pile) {
  return {pile.lattice,   whole_range(pile.lattice), pile.V_R, pile.V_L, pile.H_R,  pile.H_L,   pile.load,
          pile.load_line, pile.bead_weight,          pile.mu,  pile.law, pile.seed, pile.sample};
}

/// A part of a pile that owns its forces.
struct PilePart {
  explicit PilePart(Lattice lattice_) : lattice(lattice_) {}

  Lattice lattice;  ///< of the whole pile
  PileRange range;
  std::vector<double> V_R, V_L, H_R, H_L;
  std::vector<double> load;  ///< of all columns
  LoadLine load_line;
  double bead_weight = 0;

  double mu = 0;
  std::string law;
  std::uint64_t seed = 0, sample = 0;
};

inline PileView view_of(const PilePart& part) {
  return {part.lattice,   part.range,       part.V_R, part.V_L, part.H_R,  part.H_L,   part.load,
          part.load_line, part.bead_weight, part.mu,  part.law, part.seed, part.sample};
}

/// The layers of a pile, some at a time: of one in memory, or of one that is read where it is looked at, so that memory
/// need not hold more of it than a band of layers.
class PileLayers {
 public:
  PileLayers() = default;
  PileLayers(const PileLayers&) = delete;
  PileLayers& operator=(const PileLayers&) = delete;
  virtual ~PileLayers() = default;

  /// The pile without its forces; `range`: what hold() may be asked for.
  virtual const PileView& about() const = 0;
  /// A view that has the layers first .. last, both in the range, and perhaps more. Valid until the next call.
  virtual const PileView& hold(int first, int last) = 0;
  /// Wall time that hold() has taken so far to bring layers that were not there.
  virtual double seconds_reading() const { return 0; }
};

/// Those of a view, whose arrays must outlive this.
class LayersInMemory : public PileLayers {
 public:
  explicit LayersInMemory(PileView view) : view_(std::move(view)) {}
  const PileView& about() const override { return view_; }
  const PileView& hold(int, int) override { return view_; }

 private:
  PileView view_;
};

/// What the sampler did over an ensemble, counted, never timed. Plain counts: merging is adding, which is +=.
struct SamplerCounts {
  std::uint64_t beads = 0;             ///< beads x samples that entered
  std::uint64_t uniforms = 0;          ///< uniform numbers drawn, abandoned tries included
  std::uint64_t tries = 0;             ///< piles begun (differs from samples for the rejection law)
  std::uint64_t repaired_by_pair = 0;  ///< beads whose final value came from the pair rule
  std::uint64_t repaired_by_arc = 0;   ///< ... from an arc of 4 or more parents
  std::uint64_t repaired_by_ring = 0;  ///< ... from the whole ring
  std::uint64_t backtracked = 0;       ///< beads that had to backtrack at least once
  std::uint64_t pairs = 0, arcs = 0, rings = 0, backtracks = 0;  ///< how often each rule was entered and applied
  std::uint64_t rounded = 0;                                     ///< beads put onto a band's end by the 64-ulp rule
  std::uint64_t redrawn_layers = 0;  ///< eloy-clement: layers drawn, apart from the first time each
  std::uint64_t moves = 0;           ///< polytope: moves proposed, burn-in included
  std::uint64_t accepted_moves = 0;  ///< polytope: moves made
  std::uint64_t chains = 0;          ///< polytope: chains begun
  std::uint64_t burn_in = 0;         ///< polytope: sweeps before a chain's first pile, summed over the chains
  std::uint64_t thinning = 0;        ///< polytope: sweeps from one of its piles to the next, summed over the chains

  SamplerCounts& operator+=(const SamplerCounts& other);
};

/// Every counter by its name, in the order in which they are stored.
using SamplerCounter = std::pair<const char*, std::uint64_t SamplerCounts::*>;
inline constexpr std::array<SamplerCounter, 18> sampler_counters = {
    SamplerCounter{"beads", &SamplerCounts::beads},
    {"uniforms", &SamplerCounts::uniforms},
    {"tries", &SamplerCounts::tries},
    {"repaired_by_pair", &SamplerCounts::repaired_by_pair},
    {"repaired_by_arc", &SamplerCounts::repaired_by_arc},
    {"repaired_by_ring", &SamplerCounts::repaired_by_ring},
    {"backtracked", &SamplerCounts::backtracked},
    {"pairs", &SamplerCounts::pairs},
    {"arcs", &SamplerCounts::arcs},
    {"rings", &SamplerCounts::rings},
    {"backtracks", &SamplerCounts::backtracks},
    {"rounded", &SamplerCounts::rounded},
    {"redrawn_layers", &SamplerCounts::redrawn_layers},
    {"moves", &SamplerCounts::moves},
    {"accepted_moves", &SamplerCounts::accepted_moves},
    {"chains", &SamplerCounts::chains},
    {"burn_in", &SamplerCounts::burn_in},
    {"thinning", &SamplerCounts::thinning}};
static_assert(sizeof(SamplerCounts) == sampler_counters.size() * sizeof(std::uint64_t),
              "a counter is missing from the list");

inline SamplerCounts& SamplerCounts::operator+=(const SamplerCounts& other) {
  for (const auto& [name, count] : sampler_counters) this->*count += other.*count;
  return *this;
}

}  // namespace granuscope
