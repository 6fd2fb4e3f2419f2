#include "render/value_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "support/error.h"

namespace granuscope {
namespace {

/// Leading bits of a single-precision number (no sign: magnitudes) that choose its bin: exponent and 9 of mantissa.
constexpr unsigned mantissa_bits_dropped = 23 - 9;
constexpr std::size_t bins = std::size_t{1} << (31 - mantissa_bits_dropped);

/// Ends of a scale that divide into few round steps.
constexpr std::array<double, 14> round_ends = {1, 1.2, 1.5, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 8, 10};

}  // namespace

std::uint8_t ValueScale::level(double value) const {
  if (sign == Sign::one) {
    const double strength = std::clamp((value - low) / (high - low), 0.0, 1.0);
    // Not lround, whose call would take longer than all the rest; nothing here is negative or near the limit of a byte.
    return static_cast<std::uint8_t>(strength * most_levels + 0.5);  // NOLINT(bugprone-incorrect-roundings)
  }
  const double steps = (most_levels - 1) / 2;  // NOLINT(bugprone-integer-division): whole steps are meant
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): as above
  const auto step = static_cast<int>(std::min(std::abs(value) / high, 1.0) * steps + 0.5);
  return static_cast<std::uint8_t>(step == 0 ? 0 : 2 * step + (value < 0 ? 1 : 0));
}

double ValueScale::strength(std::uint8_t level) const {
  if (sign == Sign::one) return static_cast<double>(level) / most_levels;
  const int steps = (most_levels - 1) / 2;
  const int step = level / 2;
  const double magnitude = static_cast<double>(step) / steps;
  return level % 2 == 1 ? -magnitude : magnitude;
}

std::array<double, 2> checked_range(const std::array<double, 2>& range, Sign sign) {
  const std::string given = fmt::format("the range {},{} of the colour scale", range[0], range[1]);
  if (!std::isfinite(range[0]) || !std::isfinite(range[1]) || !std::isfinite(range[1] - range[0])) {
    throw InputError(given + " is not made of numbers; give LOW,HIGH in units of what the scene shows");
  }
  if (!(range[0] < range[1])) throw InputError(given + " is empty, so all would look alike; it needs LOW < HIGH");
  if (sign == Sign::both && range[0] != -range[1]) {
    throw InputError(given + " is not symmetric, but the middle of a diverging map means 0; give -X,X");
  }
  return range;
}

MagnitudeHistogram::MagnitudeHistogram() : counts_(bins) {}

void MagnitudeHistogram::add(double magnitude) {
  ++counts_[std::bit_cast<std::uint32_t>(static_cast<float>(magnitude)) >> mantissa_bits_dropped];
  ++total_;
}

double MagnitudeHistogram::quantile(double share) const {
  const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(total_));
  std::uint64_t below = 0;
  for (std::size_t bin = 0; bin < counts_.size(); ++bin) {
    below += counts_[bin];
    if (below == 0 || below < wanted) continue;
    // The bin's upper end, unless it holds nothing but zeros.
    return bin == 0 ? 0 : std::bit_cast<float>(static_cast<std::uint32_t>(bin + 1) << mantissa_bits_dropped);
  }
  return 0;
}

double round_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  // A histogram tells a value to 2^-9 only; a scale that ends so little below it is as good.
  constexpr double slack = 1.0 / 256;
  for (const double end : round_ends) {
    if (end * power >= value * (1 - slack)) return end * power;
  }
  return 10 * power;
}

}  // namespace granuscope
