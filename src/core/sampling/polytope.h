#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "sampling/sampler_spec.h"

namespace granuscope {
/// The null move of bead o: the change of 12 contacts by t that keeps every balance. l, r: its lower-left and
/// lower-right neighbour, products compose; what would lie below the last layer is left out:
///
///   H_R: +t of o, -t of l, -t of lr, +t of llr          H_L: -t of o, +t of r, +t of lr, -t of lrr
///   V_R: cot t (+ of r, - of l, - of lr, + of ll)       V_L: cot t (- of r, + of l, + of rr, - of lr)
struct NullMove {
  NullMove(const Lattice& lattice, int layer, int bead);

  std::size_t o, l, r, ll, lr, rr, llr, lrr;  ///< as indices; beads below the last layer stand for none
  int layers_below;                           ///< 0 to 3 of the three below the bead

  /// Adds the move to these forces; shift = cot(angle) t.
  void add_to(Pile& forces, double t, double shift) const;
};

/// Moves of the chain at lambda = 0 along bumps of all sizes.
///
/// A bump of radius r (a whole number) is the sum of the null moves by (r - d) t of all beads o nearer than r to its
/// centre, d being how many steps from neighbour to neighbour lead to o: the amounts form a pyramid on a hexagon. Null
/// moves by amounts that are linear in the place of o add up to nothing, so that only the contacts along the edges
/// change, some 24 r of them. Balances hold since those of null moves do. t is drawn uniformly on the whole interval
/// that the cones of the changed contacts allow, which leaves the flat measure as it is. A bump may stand at the bottom
/// with only its upper part in the pile, and no bead of it lies above the top layer.
///
/// The radii are (columns - 4)/2, at most the number of layers, and its halves down to 4; a ring of fewer than 12 beads
/// has no bumps. The narrowest of some 24 r contacts bounds a bump, so that it moves a wave of its length by 1/r of
/// what that fluctuates: r^2 bumps at each place let it decay. With centres sqrt(r) apart that takes about r sweeps;
/// null moves take r^4.
class BumpMoves {
 public:
  BumpMoves(const FrictionCone& cone, const Lattice& lattice);

  /// Whether there is a bump on this lattice.
  static bool fit(const Lattice& lattice) { return largest_radius(lattice) >= least_radius; }

  struct Counts {
    std::uint64_t moves = 0, accepted = 0;
  };
  /// For each radius one bump at each place of a grid that is shifted at random. Uniforms(scale, number) returns a pair
  /// of numbers in [0, 1): number 0 shifts the grid, down and to the right; the first of the others are for the bumps.
  template <class Uniforms>
  Counts sweep(Pile& pile, const Uniforms& uniforms) const {
    Counts counts;
    const int columns = lattice_.columns();
    for (std::size_t s = 0; s < scales_.size(); ++s) {
      const Scale& scale = scales_[s];
      const int here = static_cast<int>(s);
      const UniformPair shift = uniforms(here, 0);
      const int right = static_cast<int>(shift.second * columns);
      int number = 0;
      for (int layer = scale.highest + static_cast<int>(shift.first * scale.step); layer <= scale.lowest;
           layer += scale.step) {
        for (int k = 0; k < scale.around_ring; ++k) {
          const int column = (right + k * columns / scale.around_ring) % columns;
          ++counts.moves;
          counts.accepted +=
              move(pile, scale.shapes[layer % 2 == 0 ? 0 : 1], layer, column, uniforms(here, ++number).first);
        }
      }
    }
    return counts;
  }

 private:
  static constexpr int least_radius = 4;
  static int largest_radius(const Lattice& lattice) { return std::min((lattice.columns() - 4) / 2, lattice.layers()); }

  /// A bead so many columns to the right of the centre, around the ring; index: what it has above the centre's, with no
  /// regard to the ring's end.
  struct Place {
    int index, right;
  };
  /// Right or left contacts that change alike, from the top down.
  struct Edge {
    bool right;
    double V, H;                ///< growth of their forces at t = 1
    double per_low, per_high;   ///< 1/(growth of h - t- V and of t+ V - h), h being outwards; 0 where neither grows
    std::vector<Place> places;  ///< of their beads
  };
  using Shape = std::vector<Edge>;
  struct Scale {
    std::array<Shape, 2> shapes;  ///< for centres in even and in odd layers
    int highest, lowest;          ///< layers where centres may lie, some of them below the last one
    int step, around_ring;        ///< of the grid: layers between its rows, centres in each
  };

  Shape shape(int radius, int parity) const;
  bool move(Pile& pile, const Shape& shape, int layer, int column, double u) const;

  FrictionCone cone_;
  Lattice lattice_;
  std::vector<Scale> scales_;
};

/// A Markov chain on the admissible piles under one load, with density prod length^-lambda over all beads, length being
/// that of the interval of a bead's split. lambda = 0: every admissible pile alike; lambda = 1: the law "rejection".
///
/// A null move (NullMove) is drawn uniformly on the interval that its 12 cones allow, and accepted with prod
/// (old/new length)^lambda over the seven beads l, r, ll, lr, rr, llr, lrr. The ring move adds t to every H_R of a
/// layer and takes it from every H_L: no V, no total H and no length changes, so that it is always accepted. Without it
/// the thrust of a layer is slow. Where the chain is made for lambda = 0, bumps move many beads together, without which
/// long waves are slow.
class PolytopeChain {
 public:
  /// `lambda` is that of the law: 0 adds bumps.
  PolytopeChain(const FrictionCone& cone, const Lattice& lattice, double lambda);

  /// Starts, or goes on, from an admissible pile.
  void set(const Pile& pile);
  /// The forces, recomputed from the splits layer by layer so that the rounding of many moves does not add up. The
  /// chain itself goes on from them.
  void store(Pile& pile);

  /// One null move for each bead and one ring move for each layer, then the bumps. Uniforms(layer, bead) returns a pair
  /// of numbers in [0, 1); `bead` = columns stands for the ring, and beyond it `layer` is the number of a radius and
  /// `bead` = columns + 1 + number that of a bump (BumpMoves::sweep).
  template <class Uniforms>
  void sweep(const Uniforms& uniforms) {
    for (int layer = 0; layer < lattice_.layers(); ++layer) {
      for (int bead = 0; bead < lattice_.columns(); ++bead) null_move(layer, bead, uniforms(layer, bead));
      ring_move(layer, uniforms(layer, lattice_.columns()).first);
    }
    if (!bumps_) return;
    const auto of_bumps = [&](int radius, int number) { return uniforms(radius, lattice_.columns() + 1 + number); };
    const BumpMoves::Counts counts = bumps_->sweep(pile_, of_bumps);
    moves_ += counts.moves;
    accepted_ += counts.accepted;
    for (std::size_t k = 0; k < lattice_.beads(); ++k) H_[k] = pile_.H_R[k] + pile_.H_L[k];
  }
  /// Of the sweeps that follow: 0 leaves corners of vanishing length at once.
  void set_lambda(double lambda);

  const Pile& pile() const { return pile_; }
  std::uint64_t moves() const { return moves_; }
  std::uint64_t accepted_moves() const { return accepted_; }

 private:
  struct Contact {
    double V, h;  ///< h: the horizontal force outwards, H_R or -H_L
  };

  void null_move(int layer, int bead, UniformPair u);
  bool accept_lengths(const NullMove& at, double t, double shift, double u);
  void ring_move(int layer, double u);
  double length(double V_R, double V_L, double H) const;

  Contact right(std::size_t bead) const { return {pile_.V_R[bead], pile_.H_R[bead]}; }
  Contact left(std::size_t bead) const { return {pile_.V_L[bead], -pile_.H_L[bead]}; }

  FrictionCone cone_;
  Lattice lattice_;
  double lambda_;
  Pile pile_;
  std::vector<double> H_;           ///< total horizontal force entering each bead
  std::vector<double> length_;      ///< of each bead's interval; kept while lambda > 0
  std::optional<BumpMoves> bumps_;  ///< where the law has lambda = 0
  // Reciprocal speeds at which the slack of a contact shrinks with t: see null_move.
  double per_V_low_, per_V_high_, per_both_low_, per_both_high_;
  std::uint64_t moves_ = 0, accepted_ = 0;
};

/// The law "polytope": a Markov chain on the set of admissible piles, see polytope.h. The choices that shape it:
///
///  1. every group of eight consecutive samples has a chain of its own, independent of all others: it starts from the
///     pile that the law "granusolve" gives the group's first sample;
///  2. flat_sweeps sweeps at lambda = 0 lead away from corners where a length vanishes, then burn_in sweeps follow;
///  3. the group's samples are the piles after burn_in, burn_in + thinning, ... sweeps; they are correlated among each
///     other, which is why statistical blocks consist of whole groups.
///
/// A sample can thus be drawn alone at the cost of at most burn_in + 7 thinning sweeps. Samples asked for in order cost
/// burn_in / 8 + thinning sweeps each: the chain is kept from one to the next, which changes no byte.
class PolytopeSampler final : public Sampler {
 public:
  PolytopeSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;

  static constexpr std::uint64_t group = 8;  ///< samples of a chain

 private:
  std::optional<SamplingFailure> begin_chain(std::uint64_t sample, std::span<const double> load);
  void run(std::uint64_t sweeps);

  SamplerSpec spec_;
  SamplerSpec measured_;            ///< spec_ with burn_in and thinning for load_
  std::unique_ptr<Sampler> start_;  ///< draws the piles that chains start from
  PolytopeChain chain_;

  // Where the chain stands.
  std::vector<double> load_;
  std::optional<std::uint64_t> chain_group_;
  std::uint64_t in_group_ = 0;  ///< number of the group's sample it has reached
  RandomKey key_{0, 0};
  std::uint32_t sweeps_ = 0;
};

/// How long the chains of the law "polytope" run.
struct ChainPlan {
  std::uint64_t burn_in = 0;        ///< sweeps before the first pile
  std::uint64_t thinning = 0;       ///< sweeps from a pile to the next
  double autocorrelation_time = 0;  ///< sweeps that weigh as much as one independent pile, of the slowest observable
  std::uint64_t pilot_sweeps = 0;   ///< over which it was measured
};

/// Sweeps at lambda = 0 with which every chain begins: they lead away from corners where a length vanishes, which a
/// sweep at lambda = 1 would hardly ever leave.
inline constexpr std::uint64_t flat_sweeps = 8;

/// Burn-in and thinning in units of the autocorrelation time of the slowest observable. That time is about twice the
/// one in which it decays by e: what the start leaves behind is e^-8 of its distance from the law.
inline constexpr double burn_in_times = 4, thinning_times = 0.5;

/// Runs a pilot chain (keyed by the seed alone) until it is a hundred times as long as the autocorrelation time of its
/// slowest observable: the thrusts of up to eight layers, and the excess of the weight on one half of each of them over
/// the other half, the halves being cut at two places a quarter apart. A pure function of its arguments.
/// Throws InputError if the chain is still too short after 2^22 sweeps: the pile is too large for this law, or the
/// pilot could not be started.
ChainPlan plan_chain(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load);

/// How long chains would run, and how quickly, from the beginning of the pilot alone.
struct ChainForecast {
  ChainPlan plan;                ///< as plan_chain would give it, about; pilot_sweeps is 0 where nothing is measured
  double seconds_per_sweep = 0;  ///< of processor time, on this machine
  bool known = false;            ///< false: time ran out before the pilot was long enough to tell; more may be needed
};

/// Runs at most so many seconds of the pilot (of processor time; at least some sweeps). Where burn_in and thinning are
/// both stated, only the speed is measured. Throws InputError if the pilot could not be started.
ChainForecast estimate_chain_time(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load,
                                  double seconds);

/// The spec with burn_in and thinning measured where they are 0, for the law "polytope" at mu > 0; otherwise as it is.
/// The piles are the same; what is saved is one pilot for every sampler made. What was measured is remembered for as
/// long as the program runs.
SamplerSpec with_measured_chain(SamplerSpec spec, const Lattice& lattice, std::span<const double> load);

/// Whether every admissible pile is alike under the law, which can be tested.
inline bool is_flat(const SamplerSpec& spec) {
  return spec.law == Law::polytope && spec.lambda == 0 && spec.mu > 0 && spec.model.is_beads();
}

/// What has the mean 0 under the flat law, whatever the load, and is measured of each layer:
///
///   position, position_squared   P_1 and P_2 of x, mean over the null moves of the layer's beads. x is where the pile
///                                stands between the two ends, -1 and 1, of the line along which the cones allow the
///                                move. Given the line, a flat law is uniform on it (hit-and-run: Smith, Operations
///                                Research 32, 1296 (1984)), so that no Legendre polynomial has another mean;
///   thrust_drift, weight_drift, wave_drift
///                                thrust, mean square of w - 1 and power of the longest waves, times the rank of the
///                                pile in its chain, -1 to 1. The sum over a chain is 0 on average once it has
///                                forgotten its start (Geweke, in: Bayesian Statistics 4, 169 (1992)); for whole
///                                chains.
///
/// Ends are found from forces and cones by themselves: a chain that draws from wrong intervals is seen, too.
inline constexpr std::array<const char*, 5> flat_tests = {"position", "position_squared", "thrust_drift",
                                                          "weight_drift", "wave_drift"};
/// Of a single pile as a group, of which all forces of all layers are kept (std::logic_error otherwise).
std::array<double, flat_tests.size()> measure_flatness(const PileGroup& pile, int layer);

/// The law "granusolve", without what belongs to the chain alone: it draws the piles that chains start from.
SamplerSpec start_of_chain(const SamplerSpec& spec);

/// 1 + 2 (sum of the autocorrelations of a stationary series): how many of its entries weigh as much as one independent
/// one. The sum ends at the first lag beyond six times half the result (Madras and Sokal, J. Stat. Phys. 50, 109,
/// 1988). Never below 1; 1 for a series that scatters less than rounding does in numbers of size `scale`.
double autocorrelation_time(const std::vector<double>& series, double scale);

}  // namespace granuscope
