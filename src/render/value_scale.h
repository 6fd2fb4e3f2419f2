#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace granuscope {

enum class Sign { one, both };

/// The scale of a scene: values as levels, whole numbers that fit a byte. One-signed: level 0 at `low` and below,
/// most_levels at `high` and above. Both signs (low = -high): twice the steps from 0, the last bit telling the
/// negative ones, so that the stronger one has the higher level.
struct ValueScale {
  double low = 0, high = 1;
  Sign sign = Sign::one;
  int most_levels = 255;  ///< fewer if levels are kept for lines over the picture

  std::uint8_t level(double value) const;
  /// -1 .. 1: the place of a level on the scale.
  double strength(std::uint8_t level) const;
};

/// The ends of a scale that somebody asked for. Throws InputError unless they are numbers in ascending order, and for
/// both signs symmetric about 0.
std::array<double, 2> checked_range(const std::array<double, 2>& range, Sign sign);

/// How values are distributed, at a relative resolution of 2^-9 and in memory that does not grow with their number.
class MagnitudeHistogram {
 public:
  MagnitudeHistogram();
  void add(double magnitude);  ///< finite, at least 0
  /// A number that at least this share of the magnitudes do not exceed; 0 if there are none.
  double quantile(double share) const;

 private:
  std::vector<std::uint64_t> counts_;
  std::uint64_t total_ = 0;
};

/// The next number upwards at which a scale ends well: 1, 1.2, 1.5, ... times a power of ten.
double round_up(double value);

}  // namespace granuscope
