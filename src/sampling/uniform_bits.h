#pragma once
#include <cstdint>

namespace granuscope {

/// The upper 53 of 64 random bits as a multiple of 2^-53 in [0, 1).
inline double to_unit_interval(std::uint32_t low, std::uint32_t high) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-53;
}

}  // namespace granuscope
