#include "sampling/random_key.h"

#include <Random123/philox.h>

#include "sampling/uniform_bits.h"

namespace granuscope {
namespace {

// The low byte of the last counter word tells the streams apart, the other 24 bits are the attempt.
// Stream 0 belongs to the first attempts (layer_kernels.cc), stream 1 to the later ones.
enum Stream : std::uint32_t { order_stream = 2, chain_stream = 3, pilot_stream = 4, load_stream = 8 };

r123::Philox4x32::ctr_type philox(std::uint64_t seed, std::uint32_t bead, int layer, std::uint32_t sample,
                                  std::uint32_t attempt, std::uint32_t stream) {
  const r123::Philox4x32::ctr_type counter{{bead, static_cast<std::uint32_t>(layer), sample, attempt << 8 | stream}};
  const r123::Philox4x32::key_type key{{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  return r123::Philox4x32()(counter, key);
}

UniformPair to_pair(const r123::Philox4x32::ctr_type& words) {
  return {to_unit_interval(words[0], words[1]), to_unit_interval(words[2], words[3])};
}

}  // namespace

UniformPair RandomKey::attempt(int layer, int bead, std::uint32_t attempt) const {
  return to_pair(philox(seed_, static_cast<std::uint32_t>(bead), layer, sample_, attempt, later_attempt_stream));
}

UniformPair RandomKey::chain_move(int layer, int bead, std::uint32_t sweep) const {
  return to_pair(philox(seed_, static_cast<std::uint32_t>(bead), layer, sample_, sweep, chain_stream));
}

UniformPair RandomKey::pilot_move(int layer, int bead, std::uint32_t sweep) const {
  return to_pair(philox(seed_, static_cast<std::uint32_t>(bead), layer, 0, sweep, pilot_stream));
}

RandomKey::Order RandomKey::layer_order(int layer, int columns) const {
  const auto words = philox(seed_, 0, layer, sample_ / 8, 0, order_stream);
  const auto first = static_cast<std::uint64_t>(words[0]) * static_cast<std::uint64_t>(columns) >> 32;
  return {static_cast<int>(first), (words[1] & 1) != 0 ? 1 : -1};
}

bool RandomKey::load_bit(int bead) const {
  const auto at = static_cast<std::uint32_t>(bead);
  const auto words = philox(seed_, at / 128, 0, sample_, 0, load_stream);
  return (words[at / 32 % 4] >> (at % 32) & 1) != 0;
}

}  // namespace granuscope
