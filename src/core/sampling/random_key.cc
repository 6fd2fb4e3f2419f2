#include "sampling/random_key.h"

#include <Random123/philox.h>

#include <cmath>

namespace granuscope {
namespace {

// The low byte of the last counter word tells the streams apart, the other 24 bits are the attempt.
// Stream 0 belongs to the first attempts (layer_kernels.cc), stream 1 to the later ones.
enum Stream : std::uint32_t { order_stream = 2, chain_stream = 3, pilot_stream = 4, place_stream = 7, load_stream = 8 };

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

int RandomKey::loaded_bead(int beads) const {
  const auto words = philox(seed_, 0, 0, sample_, 0, place_stream);
  return static_cast<int>(static_cast<std::uint64_t>(words[0]) * static_cast<std::uint64_t>(beads) >> 32);
}

std::optional<PairDraw> draw_truncated_pair(Interval A, Interval B, Interval D, double u_difference, double u_chord) {
  if (A.empty() || B.empty()) return std::nullopt;
  const auto trapezoid = scalar::cut_trapezoid(A, B, D);
  const double low = trapezoid.low, high = trapezoid.high;
  if (low > high) return std::nullopt;
  const double difference =
      trapezoid.area > 0 ? scalar::difference_at(trapezoid, u_difference) : low + u_difference * (high - low);
  return scalar::pair_apart(A, B, scalar::clamped(difference, low, high), u_chord);
}

namespace {

constexpr double ln2 = 0.69314718055994530942, half_sqrt2 = 0.70710678118654752440;

/// Natural logarithm: base = m 2^e with m in [sqrt(1/2), sqrt(2)), ln m = 2 artanh((m - 1)/(m + 1)) by its series.
double portable_log(double base) {
  int exponent = 0;
  double mantissa = std::frexp(base, &exponent);  // exact
  if (mantissa < half_sqrt2) {
    mantissa *= 2;
    --exponent;
  }
  const double s = (mantissa - 1) / (mantissa + 1), square = s * s;  // square < 0.0295
  double series = 0;
  for (int power = 21; power >= 3; power -= 2) series = (series + 1.0 / power) * square;
  return exponent * ln2 + 2 * s * (1 + series);
}

/// e^y: y = k ln 2 + f with |f| <= ln 2 / 2, e^f by its series.
double portable_exp(double y) {
  const double k = std::floor(y / ln2 + 0.5), f = y - k * ln2;
  double series = 1;
  for (int term = 17; term >= 1; --term) series = 1 + series * f / term;
  return std::ldexp(series, static_cast<int>(k));  // exact unless it leaves the range of normal numbers
}

}  // namespace

double portable_power(double base, double exponent) {
  if (exponent == 0) return 1;
  if (exponent == 1 || std::isinf(base)) return base;
  return portable_exp(exponent * portable_log(base));
}

}  // namespace granuscope
