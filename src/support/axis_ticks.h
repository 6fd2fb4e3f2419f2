#pragma once
#include <initializer_list>
#include <vector>

namespace granuscope {

/// A step between the marks of an axis: a digit times a power of ten.
struct RoundStep {
  int digit = 1;
  int exponent = 0;

  double size() const;
};

/// The smallest step of these digits, in rising order, times 10^k, k >= lowest_exponent, that is at least `wanted`.
RoundStep round_step_at_least(double wanted, int lowest_exponent, std::initializer_list<int> digits = {1, 2, 5});

/// The smallest step of 1, 2 or 5 times a power of ten with at most `most` (at least 1) multiples from `low` to `high`.
RoundStep round_step_with_at_most(int most, double low, double high);

/// The multiples of a step from `low` to `high`, in rising order; the ends count with room for rounding. 0 is never −0.
std::vector<double> multiples_within(double low, double high, const RoundStep& step);

/// Of a logarithmic axis: digit × 10^exponent.
struct LogMark {
  int digit = 1;
  int exponent = 0;

  double value() const;
};

/// The whole multiples of powers of ten, 1 to 9 of each, from `low` > 0 to `high`; the ends count with room for
/// rounding.
std::vector<LogMark> log_marks_within(double low, double high);

}  // namespace granuscope
