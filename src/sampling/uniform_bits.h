#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace granuscope {

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

}  // namespace granuscope
