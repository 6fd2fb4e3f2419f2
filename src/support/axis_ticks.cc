#include "support/axis_ticks.h"

#include <algorithm>
#include <cmath>

namespace granuscope {

namespace {

constexpr double rounding = 1e-9;  ///< of the quotients below, which decimal fractions do not hit exactly

double first_multiple(double low, double step) { return std::ceil(low / step - rounding); }
double last_multiple(double high, double step) { return std::floor(high / step + rounding); }

}  // namespace

double RoundStep::size() const { return digit * std::pow(10, exponent); }

double LogMark::value() const { return digit * std::pow(10, exponent); }

RoundStep round_step_at_least(double wanted, int lowest_exponent, std::initializer_list<int> digits) {
  for (int exponent = lowest_exponent;; ++exponent) {
    for (const int digit : digits) {
      const RoundStep step{digit, exponent};
      if (step.size() >= wanted * (1 - rounding)) return step;
    }
  }
}

RoundStep round_step_with_at_most(int most, double low, double high) {
  RoundStep step{1, static_cast<int>(std::floor(std::log10((high - low) / most))) - 1};
  while (last_multiple(high, step.size()) - first_multiple(low, step.size()) + 1 > most) {
    step.digit = step.digit == 1 ? 2 : step.digit == 2 ? 5 : 1;
    if (step.digit == 1) ++step.exponent;
  }
  return step;
}

std::vector<double> multiples_within(double low, double high, const RoundStep& step) {
  std::vector<double> values;
  const double first = first_multiple(low, step.size()), last = last_multiple(high, step.size());
  const auto count = static_cast<int>(std::max(0.0, last - first + 1));
  for (int i = 0; i < count; ++i) {
    const double k = first + i;
    values.push_back(k == 0 ? 0 : k * step.size());
  }
  return values;
}

std::vector<LogMark> log_marks_within(double low, double high) {
  std::vector<LogMark> marks;
  for (int exponent = static_cast<int>(std::floor(std::log10(low))); std::pow(10, exponent) <= high; ++exponent) {
    for (int digit = 1; digit <= 9; ++digit) {
      const LogMark mark{digit, exponent};
      if (mark.value() >= low * (1 - rounding) && mark.value() <= high * (1 + rounding)) marks.push_back(mark);
    }
  }
  return marks;
}

}  // namespace granuscope
