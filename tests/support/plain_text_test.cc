#include "support/plain_text.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <string>

using namespace granuscope;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// What a reader of "0.0792(41)" or "3.21(14) × 10⁻⁷" takes it to mean.
struct Reading {
  double value = 0;
  double error = 0;
  double last_digit = 1;  ///< the unit of the value's last digit
};

Reading parse(std::string text) {
  replace_all(text, "\u2212", "-");
  replace_all(text, "\u207b", "-");
  const char* const superscripts[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                      "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  for (int digit = 0; digit < 10; ++digit) replace_all(text, superscripts[digit], std::to_string(digit));
  int exponent = 0;
  if (const std::size_t times = text.find(" \u00d7 10"); times != std::string::npos) {
    exponent = std::atoi(text.c_str() + times + std::string(" \u00d7 10").size());
    text.resize(times);
  }
  const std::size_t open = text.find('(');
  REQUIRE(open != std::string::npos);
  REQUIRE(text.back() == ')');
  const std::string number = text.substr(0, open);
  const std::string bracket = text.substr(open + 1, text.size() - open - 2);
  const std::size_t point = number.find('.');
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(number.size() - point - 1);
  const bool in_last_digits = bracket.find('.') == std::string::npos;
  const std::string power = "e" + std::to_string(exponent);
  Reading reading;
  reading.value = std::strtod((number + power).c_str(), nullptr);
  reading.last_digit = std::strtod(("1e" + std::to_string(exponent - decimals)).c_str(), nullptr);
  reading.error = in_last_digits ? std::strtod(bracket.c_str(), nullptr) * reading.last_digit
                                 : std::strtod((bracket + power).c_str(), nullptr);
  // 12300(680): the value's last digit is that of the error.
  if (decimals == 0 && exponent == 0) {
    double unit = 1;
    for (std::size_t i = 2; i < bracket.size(); ++i) unit *= 10;
    reading.last_digit = unit;
  }
  return reading;
}

}  // namespace

TEST_CASE("a value carries two digits of its error") {
  CHECK(value_with_error(0.07923, 0.0041) == "0.0792(41)");
  CHECK(value_with_error(0.5600, 0.0010) == "0.5600(10)");
  CHECK(value_with_error(0.57735026918962576451, 0.00012) == "0.57735(12)");
  CHECK(value_with_error(2.5, 0.25) == "2.50(25)");
  CHECK(value_with_error(2.5, 0.99) == "2.50(99)");
  CHECK(value_with_error(0, 0.0041) == "0.0000(41)");
}

TEST_CASE("an error below the resolution of a double is none") {
  CHECK(value_with_error(0.57735026918962606, 1.0e-17) == "0.577350");
  CHECK(value_with_error(0.57735026918962606, 6e-17) == "0.577350");
  CHECK(value_with_error(0.5, 3e-16) == "0.50000000000000000(30)");
}

TEST_CASE("One of what is counted is no several") {
  CHECK(how_many(1, "pile") == "1 pile");
  CHECK(how_many(0, "pile") == "0 piles");
  CHECK(how_many(1, "block is", "blocks are") == "1 block is");
  CHECK(how_many(2, "block is", "blocks are") == "2 blocks are");
}

TEST_CASE("text is taken apart between separators, without the blanks around") {
  CHECK(trimmed(" \t\r\n a b\n ") == "a b");
  CHECK(trimmed(" \t").empty());
  CHECK(parts_between("a :: b c::", "::") == std::vector<std::string>{"a", "b c", ""});
  CHECK(parts_between("", ",") == std::vector<std::string>{""});
}

TEST_CASE("an error of one or more is written out") {
  CHECK(value_with_error(123.4, 5.6) == "123.4(5.6)");
  CHECK(value_with_error(123.44, 1.0) == "123.4(1.0)");
  CHECK(value_with_error(123.4, 56) == "123(56)");
  CHECK(value_with_error(12345, 678) == "12340(680)");
  CHECK(value_with_error(12355, 678) == "12360(680)");
  CHECK(value_with_error(500000, 12345) == "500000(12000)");
}

TEST_CASE("rounding carries over") {
  CHECK(value_with_error(1.0, 0.0996) == "1.00(10)");
  CHECK(value_with_error(1.0, 0.0994) == "1.000(99)");
  CHECK(value_with_error(9.996, 0.12) == "10.00(12)");
  CHECK(value_with_error(0.9999, 0.012) == "1.000(12)");
  CHECK(value_with_error(3.0, 0.996) == "3.0(1.0)");
  CHECK(value_with_error(42, 9.96) == "42(10)");
  CHECK(value_with_error(999999.6, 0.99) == "999999.60(99)");
  CHECK(value_with_error(999999.9996, 0.012) == "1000000.000(12)");
  CHECK(value_with_error(0.00009999, 0.0000012) == "0.0001000(12)");
}

TEST_CASE("a value below its error keeps the error's digits") {
  CHECK(value_with_error(0.001, 0.5) == "0.00(50)");
  CHECK(value_with_error(0.004, 0.11) == "0.00(11)");
  CHECK(value_with_error(0.006, 0.11) == "0.01(11)");
  CHECK(value_with_error(0.06, 1.1) == "0.1(1.1)");
  CHECK(value_with_error(0.04, 1.1) == "0.0(1.1)");
  CHECK(value_with_error(4, 110) == "0(110)");
  CHECK(value_with_error(6, 110) == "10(110)");
}

TEST_CASE("minus is typographic, and nothing is not negative") {
  CHECK(value_with_error(-0.07923, 0.0041) == "\u22120.0792(41)");
  CHECK(value_with_error(-123.4, 5.6) == "\u2212123.4(5.6)");
  CHECK(value_with_error(-0.001, 0.5) == "0.00(50)");
  CHECK(value_with_error(-0.0, 0.5) == "0.00(50)");
  CHECK(significant(-2.5, 2) == "\u22122.5");
  CHECK(significant(-0.0, 2) == "0");
}

TEST_CASE("what is unknown is said to be so") {
  for (const double unknown : {not_a_number, infinity, -infinity}) {
    CHECK(value_with_error(unknown, 1) == "n/a");
    CHECK(value_with_error(1, unknown) == "n/a");
    CHECK(significant(unknown, 3) == "n/a");
  }
  CHECK(value_with_error(1, -0.1) == "n/a");
}

TEST_CASE("very small and very large numbers take a power of ten") {
  CHECK(value_with_error(3.21e-7, 1.4e-8) == "3.21(14) \u00d7 10\u207b\u2077");
  CHECK(value_with_error(-3.21e-7, 1.4e-8) == "\u22123.21(14) \u00d7 10\u207b\u2077");
  CHECK(value_with_error(1e-8, 5e-7) == "0.1(5.0) \u00d7 10\u207b\u2077");
  CHECK(value_with_error(3.2e-7, 1.4e-7) == "3.2(1.4) \u00d7 10\u207b\u2077");
  CHECK(value_with_error(0, 1.4e-8) == "0.0(1.4) \u00d7 10\u207b\u2078");
  CHECK(value_with_error(6.02214e23, 1.5e19) == "6.02214(15) \u00d7 10\u00b2\u00b3");
  CHECK(value_with_error(9.9999e-5, 1.2e-8) == "9.9999(12) \u00d7 10\u207b\u2075");
  CHECK(value_with_error(0.00012, 0.000011) == "0.000120(11)");
  CHECK(value_with_error(1e-300, 1e-310) == "1.00000000000(10) \u00d7 10\u207b\u00b3\u2070\u2070");
}

TEST_CASE("an exact value has the digits asked for") {
  CHECK(value_with_error(0.57735026918962576451, 0) == "0.577350");
  CHECK(value_with_error(0.57735026918962576451, 0, 3) == "0.577");
  CHECK(value_with_error(0, 0) == "0");
  CHECK(value_with_error(1, 1e-30) == "1.00000");
}

TEST_CASE("significant digits") {
  CHECK(significant(3.14159, 3) == "3.14");
  CHECK(significant(0.5, 3) == "0.500");
  CHECK(significant(9.996, 3) == "10.0");
  CHECK(significant(123456, 3) == "123000");
  CHECK(significant(1e6, 3) == "1000000");
  CHECK(significant(999999.9, 3) == "1000000");
  CHECK(significant(1.01e6, 3) == "1.01 \u00d7 10\u2076");
  CHECK(significant(1e-4, 2) == "0.00010");
  CHECK(significant(9.99e-5, 2) == "0.00010");
  CHECK(significant(3.2e-7, 2) == "3.2 \u00d7 10\u207b\u2077");
  CHECK(significant(3e-7, 1) == "3 \u00d7 10\u207b\u2077");
  CHECK(significant(5e-324, 2) == "4.9 \u00d7 10\u207b\u00b3\u00b2\u2074");
  CHECK(significant(12, 0) == "10");
}

TEST_CASE("the written form reads back to the value and its error") {
  std::mt19937_64 random(20020314);
  std::uniform_real_distribution<double> magnitude(-12, 9), ratio(-9, 2), mantissa(1, 10);
  for (int i = 0; i < 20'000; ++i) {
    const double value = mantissa(random) * std::pow(10, std::floor(magnitude(random))) * (i % 2 == 0 ? 1 : -1);
    const double error = std::abs(value) * std::pow(10, ratio(random));
    const std::string text = value_with_error(value, error);
    const Reading reading = parse(text);
    CAPTURE(value, error, text);
    // Half a unit of the last digit; the rest is the rounding of the parsed numbers themselves.
    REQUIRE(std::abs(reading.value - value) <= 0.5 * reading.last_digit * (1 + 1e-6) + 1e-15 * std::abs(value));
    REQUIRE(std::abs(reading.error - error) <= 0.0501 * error);
    REQUIRE(std::abs(reading.last_digit / reading.error) >= 0.00999);  // two digits: the error is 10 to 99 units
    REQUIRE(std::abs(reading.last_digit / reading.error) <= 0.1001);
  }
}

TEST_CASE("exact numbers read back bit by bit") {
  CHECK(exact(0.1) == "0.1");
  CHECK(exact(-0.0) == "-0");
  CHECK(exact(1e300) == "1e+300");
  CHECK(exact(not_a_number) == "nan");
  CHECK(exact(-not_a_number) == "nan");
  CHECK(exact(infinity) == "inf");
  CHECK(exact(-infinity) == "-inf");
  std::mt19937_64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const auto bits = random();
    double value = 0;
    static_assert(sizeof bits == sizeof value);
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    REQUIRE(std::strtod(exact(value).c_str(), nullptr) == value);
  }
}

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

TEST_CASE("sizes are told in megabytes, gigabytes and terabytes") {
  CHECK(describe_bytes(0) == "0.0 MB");
  CHECK(describe_bytes(2.5e6) == "2.5 MB");
  CHECK(describe_bytes(25.3e9) == "25.3 GB");
  CHECK(describe_bytes(1.58e14) == "158 TB");
  CHECK(describe_bytes(4.611686e20) == "4.61e+08 TB");
}

TEST_CASE("text of others becomes one line that moves no cursor") {
  CHECK(single_line("") == "");
  CHECK(single_line("plain μ ∝ text") == "plain μ ∝ text");
  CHECK(single_line("line 1: bad\n  ^ here\r\n\nmore\n") == "line 1: bad   ^ here more");
  CHECK(single_line("\033[31mred\033[0m\a") == "[31mred [0m");
  CHECK(single_line("a\xc2\x9b"
                    "31m") == "a 31m");  // the same in one character, U+009B
  CHECK(single_line(std::string_view("a\0b", 3)) == "a b");
  CHECK(single_line("rm \u202e\u2066x\u2069אב\u200f") == "rm x אב\u200f");  // turned, it would read otherwise
  CHECK(single_line("\xff\xfe") == "\xff\xfe");                             // bytes of a file's name stay what they are
}

TEST_CASE("a word for a shell is what it was, and moves no cursor") {
  CHECK(shell_word("out/a-b_1.5") == "out/a-b_1.5");
  CHECK(shell_word("a b's") == "'a b'\\''s'");
  const std::string odd = "a b\x1b[31m'\\\xe2\x80\xae";
  CHECK(shell_word(odd) == "$'a\\040b\\033[31m\\047\\134\\342\\200\\256'");
}

TEST_CASE("a long text is cut off between two characters") {
  CHECK(single_line("abcdef", 4) == "abcd …");
  CHECK(single_line("abcd", 4) == "abcd");
  CHECK(single_line("μμμ", 3) == "μμ …");
  CHECK(single_line(std::string(1000, 'x')).size() == 400 + std::string(" …").size());
}
