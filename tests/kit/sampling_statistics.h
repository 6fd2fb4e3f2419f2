#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "kit/sanitized.h"

namespace granuscope::test {

/// Fewer samples under the sanitizers, and bounds on the errors that follow the number.
inline constexpr int share_of_samples = sanitized ? 16 : 1;

/// A measured mean and its standard error.
struct Estimated {
  double value = 0, error = 0;
};

/// Mean of independent numbers and its standard error.
class RunningMean {
 public:
  void add(double x) {
    ++count_;
    const double step = x - mean_;
    mean_ += step / static_cast<double>(count_);
    squares_ += step * (x - mean_);
  }
  std::uint64_t count() const { return count_; }
  double variance() const { return count_ > 1 ? squares_ / static_cast<double>(count_ - 1) : 0; }
  /// An infinite error below 100 samples: they say nothing.
  Estimated estimate() const {
    return {mean_, count_ < 100 ? INFINITY : std::sqrt(variance() / static_cast<double>(count_))};
  }

 private:
  std::uint64_t count_ = 0;
  double mean_ = 0, squares_ = 0;
};

/// Two-sided tail of the normal distribution beyond five standard deviations: the error rate of a whole test.
inline double five_sigma_tail() { return std::erfc(5 / std::sqrt(2.0)); }

/// How many standard deviations one of `comparisons` may be off so that all together err as rarely as one at five
/// sigma (Bonferroni).
inline double sigma_bound(std::size_t comparisons) {
  const double tail = five_sigma_tail() / static_cast<double>(comparisons);
  double low = 5, high = 40;
  for (int k = 0; k < 100; ++k) {
    const double middle = (low + high) / 2;
    (std::erfc(middle / std::sqrt(2.0)) > tail ? low : high) = middle;
  }
  return high;
}

/// Deviation in standard errors; 0 where both are exactly equal.
inline double sigmas(Estimated a, Estimated b) {
  const double difference = a.value - b.value;
  return difference == 0 ? 0 : difference / std::hypot(a.error, b.error);
}

/// Chi-squared as a number of standard deviations (Wilson and Hilferty 1931).
inline double chi_squared_sigmas(double chi_squared, double degrees) {
  const double c = 2 / (9 * degrees);
  return (std::cbrt(chi_squared / degrees) - (1 - c)) / std::sqrt(c);
}

/// Pearson's chi-squared of counts that should all be equally likely.
inline double chi_squared_of_equal(const std::vector<std::uint64_t>& counts) {
  double total = 0, sum = 0;
  for (auto count : counts) total += static_cast<double>(count);
  const double expected = total / static_cast<double>(counts.size());
  for (auto count : counts) sum += (static_cast<double>(count) - expected) * (static_cast<double>(count) - expected);
  return sum / expected;
}

}  // namespace granuscope::test
