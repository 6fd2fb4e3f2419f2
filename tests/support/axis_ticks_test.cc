#include "support/plain_text.h"

#include <catch2/catch.hpp>
#include <cmath>

using namespace granuscope;

TEST_CASE("A round step is the smallest that is large enough") {
  CHECK(round_step_at_least(3, 0).size() == 5);
  CHECK(round_step_at_least(3, 0, {1, 2, 3, 5}).size() == 3);
  CHECK(round_step_at_least(6, 0).size() == 10);
  CHECK(round_step_at_least(0.01, 0).size() == 1);  // the lowest power allowed
  CHECK(round_step_at_least(0.15, -1).size() == 0.2);
  CHECK(round_step_at_least(0.1 + 0.2 - 0.1, -1).size() == 0.2);  // 0.20000000000000004
}

TEST_CASE("A round step leaves few enough marks, and the next smaller one would not") {
  for (const double low : {0.0, -0.11, 0.5489, 17.0}) {
    for (const double length : {0.03, 1.0, 160.0, 2.5e6}) {
      for (const int most : {2, 4, 7}) {
        const double high = low + length;
        const RoundStep step = round_step_with_at_most(most, low, high);
        CHECK(multiples_within(low, high, step).size() <= static_cast<std::size_t>(most));
        const RoundStep smaller = step.digit == 1   ? RoundStep{5, step.exponent - 1}
                                  : step.digit == 2 ? RoundStep{1, step.exponent}
                                                    : RoundStep{2, step.exponent};
        CHECK(multiples_within(low, high, smaller).size() > static_cast<std::size_t>(most));
      }
    }
  }
}

TEST_CASE("Multiples include the ends and hold no negative zero") {
  CHECK(multiples_within(0.1, 0.3, {1, -1}).size() == 3);  // 0.3 / 0.1 is 2.9999999999999996
  const std::vector<double> marks = multiples_within(-0.4, 0.4, {5, -1});
  REQUIRE(marks.size() == 1);
  CHECK_FALSE(std::signbit(marks[0]));
  CHECK(multiples_within(0.21, 0.29, {1, -1}).empty());
}

TEST_CASE("Logarithmic marks are the whole multiples of the powers of ten") {
  const std::vector<LogMark> marks = log_marks_within(0.3, 2);
  REQUIRE(marks.size() == 9);
  CHECK(marks.front().value() == Approx(0.3));
  CHECK(marks[6].value() == Approx(0.9));
  CHECK(marks[7].digit == 1);
  CHECK(marks[7].exponent == 0);
  CHECK(marks.back().value() == 2);
}
