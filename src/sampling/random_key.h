#pragma once
#include <cstdint>

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

}  // namespace granuscope
