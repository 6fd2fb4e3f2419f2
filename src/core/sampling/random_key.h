#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "model/equilibrium.h"

namespace granuscope {
/// Two uniform numbers in [0, 1), multiples of 2^-53.
struct UniformPair {
  double first, second;
};

/// Every random number of a pile is a pure function of (seed, sample, layer, bead, attempt), through Philox4x32-10
/// (Salmon et al., SC 2011). Nothing depends on the order in which numbers are asked for.
/// Counter words: bead, layer, sample, attempt and stream; key: the seed. Samples are numbered below 2^32. First
/// attempts come a layer at a time: see layer_kernels.h.
class RandomKey {
 public:
  RandomKey(std::uint64_t seed, std::uint64_t sample) : seed_(seed), sample_(static_cast<std::uint32_t>(sample)) {}

  /// The numbers of a later attempt (1, 2, ...) of one bead.
  UniformPair attempt(int layer, int bead, std::uint32_t attempt) const;

  /// First bead and direction (+1 or -1) in which a layer is solved. Eight consecutive samples share them, so that
  /// they can be solved side by side.
  struct Order {
    int first_bead;
    int direction;
  };
  Order layer_order(int layer, int columns) const;

  /// A fair bit for each top bead, for loads that are themselves random.
  bool load_bit(int bead) const;
  /// One of the first `beads` top beads, each as likely, for a load that stands anywhere.
  int loaded_bead(int beads) const;

  /// The numbers of one move of the chain that belongs to this key, `bead` being any number the chain gives to a move.
  UniformPair chain_move(int layer, int bead, std::uint32_t sweep) const;
  /// The same for the chain that measures how long the others must be; it belongs to the seed, not to a sample.
  UniformPair pilot_move(int layer, int bead, std::uint32_t sweep) const;

  std::uint64_t seed() const { return seed_; }
  std::uint32_t sample() const { return sample_; }

 private:
  std::uint64_t seed_;
  std::uint32_t sample_;
};

/// Largest number of samples that one seed can name.
inline constexpr std::uint64_t max_samples = std::uint64_t{1} << 32;

/// The upper 53 of 64 random bits as a multiple of 2^-53 in [0, 1).
inline double to_unit_interval(std::uint32_t low, std::uint32_t high) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-53;
}

/// The low byte of Philox's last counter word, which tells the stream of later attempts apart; the rest is the attempt.
inline constexpr std::uint32_t later_attempt_stream = 1;

/// What Philox4x32-10 adds in each round, from a seed; each 32-bit word stands in 64 bits, ready for vector lanes.
struct PhiloxKeys {
  static constexpr std::size_t rounds = 10;
  std::array<std::uint64_t, rounds> word0{}, word1{};

  explicit PhiloxKeys(std::uint64_t seed = 0) {
    auto key0 = static_cast<std::uint32_t>(seed), key1 = static_cast<std::uint32_t>(seed >> 32);
    for (std::size_t round = 0; round < rounds; ++round) {
      word0[round] = key0;
      word1[round] = key1;
      key0 += 0x9E3779B9U;
      key1 += 0xBB67AE85U;
    }
  }
};

/// An H that misses its solvable band by at most this many units in the last place of the forces summed is put onto the
/// band's end: the splits above were chosen inside the band, and only their rounding carried H out of it.
inline constexpr double rounding_ulps = 64;

namespace scalar {
#include "sampling/pair_formulas.inc"
}  // namespace scalar
using scalar::nearest_solvable;

/// Whether a bead without solution is so by rounding only.
inline bool misses_by_rounding(const FrictionCone& cone, Incoming in) { return !scalar::misses_band(cone, in); }

/// An interval that is empty by rounding only, as the point it stands for.
inline Interval closed(Interval interval) {
  if (!interval.empty()) return interval;
  const double middle = interval.low + (interval.high - interval.low) / 2;
  return {middle, middle};
}

using PairDraw = scalar::PairOf<double>;

/// Draws (a, b) uniformly on the polygon { a in A, b in B, a - b in D } from two uniform numbers in [0, 1).
/// The difference d = a - b has the density of a trapezoid (the length of the polygon's chord at d), cut to D; its
/// distribution is piecewise quadratic and is inverted in closed form, then a is uniform on the chord.
/// None if the polygon is empty. A polygon without area (a segment, a point) is sampled along its length.
std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord);

/// base^exponent for base > 0 (finite or infinite) and 0 <= exponent <= 1, to about 1e-15 relative, from additions,
/// multiplications and divisions alone: the bytes are the same with every mathematical library, as those of its pow()
/// are not.
double portable_power(double base, double exponent);

}  // namespace granuscope
