#include "sampling/random_key.h"

#include <Random123/philox.h>

namespace granuscope {
namespace {

// The low byte of the last counter word tells the streams apart, the other 24 bits are the attempt.
enum Stream : std::uint32_t { first_attempt_stream = 0, later_attempt_stream = 1, order_stream = 2 };

r123::Philox4x32::ctr_type philox(std::uint64_t seed, std::uint32_t bead, int layer, std::uint32_t sample,
                                  std::uint32_t attempt, Stream stream) {
  const r123::Philox4x32::ctr_type counter{{bead, static_cast<std::uint32_t>(layer), sample, attempt << 8 | stream}};
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  return r123::Philox4x32()(counter, key);
}

double to_unit_interval(std::uint32_t low, std::uint32_t high) {
  const std::uint64_t bits = (static_cast<std::uint64_t>(high) << 32 | low) >> 11;
  return static_cast<double>(static_cast<std::int64_t>(bits)) * 0x1p-53;
}

}  // namespace

UniformPair RandomKey::attempt(int layer, int bead, std::uint32_t attempt) const {
  const auto words = philox(seed_, static_cast<std::uint32_t>(bead), layer, sample_, attempt, later_attempt_stream);
  return {to_unit_interval(words[0], words[1]), to_unit_interval(words[2], words[3])};
}

void RandomKey::first_attempts(int layer, std::span<double> uniforms) const {
  const std::size_t pairs = uniforms.size() / 2;
  for (std::size_t k = 0; k < pairs; ++k) {
    const auto words = philox(seed_, static_cast<std::uint32_t>(k), layer, sample_, 0, first_attempt_stream);
    uniforms[2 * k] = to_unit_interval(words[0], words[1]);
    uniforms[2 * k + 1] = to_unit_interval(words[2], words[3]);
  }
  if (uniforms.size() % 2 == 1) {
    const auto words = philox(seed_, static_cast<std::uint32_t>(pairs), layer, sample_, 0, first_attempt_stream);
    uniforms.back() = to_unit_interval(words[0], words[1]);
  }
}

RandomKey::Order RandomKey::layer_order(int layer, int columns) const {
  const auto words = philox(seed_, 0, layer, sample_ / 8, 0, order_stream);
  const auto first = static_cast<std::uint64_t>(words[0]) * static_cast<std::uint64_t>(columns) >> 32;
  return {static_cast<int>(first), (words[1] & 1) != 0 ? 1 : -1};
}

}  // namespace granuscope
