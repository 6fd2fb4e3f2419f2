#include "support/number_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>

namespace granuscope {
namespace {

constexpr const char* minus = "\u2212";
constexpr const char* unknown = "n/a";

/// A non-negative decimal number: the integer written in `digits`, times 10^place. No leading zeros but for "0".
struct Decimal {
  std::string digits;
  int place = 0;

  bool zero() const { return digits == "0"; }
  int exponent() const { return static_cast<int>(digits.size()) - 1 + place; }
};

/// |value| rounded to `digits` significant digits, exactly: the text comes from the correctly rounded printf form.
Decimal round_to_digits(double value, int digits) {
  const std::string text = fmt::format("{:.{}e}", std::abs(value), digits - 1);
  const std::size_t mark = text.find('e');
  Decimal result;
  for (const char letter : text.substr(0, mark)) {
    if (letter != '.') result.digits += letter;
  }
  result.place = std::atoi(text.c_str() + mark + 1) - (digits - 1);  // NOLINT(cert-err34-c): printed two lines above
  return result;
}

/// |value| rounded to a whole multiple of 10^place.
Decimal round_to_place(double value, int place) {
  Decimal zero{"0", place};
  if (value == 0) return zero;
  // 18 digits tell on which side of a power of ten a double lies.
  const Decimal full = round_to_digits(value, 18);
  const int digits = full.exponent() - place + 1;
  if (digits < 0) return zero;
  if (digits == 0) return full.digits[0] >= '5' ? Decimal{"1", place} : zero;
  Decimal result = round_to_digits(value, digits);
  // A carry (9.99 -> 10.0) moves the last digit one place up.
  result.digits.append(static_cast<std::size_t>(result.place - place), '0');
  result.place = place;
  return result;
}

/// The number with its decimal point, times 10^-shift.
std::string positional(const Decimal& number, int shift) {
  std::string text = number.digits;
  const int place = number.place - shift;
  if (place >= 0) return number.zero() ? text : text + std::string(static_cast<std::size_t>(place), '0');
  const auto decimals = static_cast<std::size_t>(-place);
  if (text.size() <= decimals) text.insert(0, decimals + 1 - text.size(), '0');
  return text.insert(text.size() - decimals, ".");
}

/// What stands behind a number that is written with a power of ten.
std::string times_power_of_ten(int exponent) { return " \u00d7 " + power_of_ten(exponent); }

/// Whether a number whose first digit stands at 10^exponent is written without a power of ten: from 1e-4 to 1e6.
bool reads_well_plain(int exponent, const Decimal& number, int lowest_exponent = -4) {
  if (exponent == 6) return number.digits.find_first_not_of('0', 1) == std::string::npos && number.digits[0] == '1';
  return exponent >= lowest_exponent && exponent < 6;
}

std::string sign_of(double value, const Decimal& rounded) { return value < 0 && !rounded.zero() ? minus : ""; }

}  // namespace

std::string power_of_ten(int exponent) {
  static constexpr std::array<const char*, 10> superscripts = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                                               "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text = "10";
  if (exponent < 0) text += "\u207b";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += superscripts[static_cast<std::size_t>(digit - '0')];
  return text;
}

std::string significant(double value, int digits) {
  if (!std::isfinite(value)) return unknown;
  if (value == 0) return "0";
  const Decimal number = round_to_digits(value, std::clamp(digits, 1, 17));
  const int exponent = number.exponent();
  if (reads_well_plain(exponent, number)) return sign_of(value, number) + positional(number, 0);
  return sign_of(value, number) + positional(number, exponent) + times_power_of_ten(exponent);
}

std::string value_with_error(double value, double standard_error, int digits_if_exact, int lowest_plain_exponent) {
  if (!std::isfinite(value) || !std::isfinite(standard_error) || standard_error < 0) return unknown;
  // Below the resolution of a double the digits would be those of the binary number, not of a measurement.
  if (standard_error <= std::abs(value) * 1e-17) return significant(value, digits_if_exact);

  const Decimal error = round_to_digits(standard_error, 2);
  const Decimal number = round_to_place(value, error.place);
  const bool value_leads = !number.zero() && number.exponent() >= error.exponent();
  const Decimal& leading = value_leads ? number : error;
  const int exponent = leading.exponent();
  const bool plain = reads_well_plain(exponent, leading, lowest_plain_exponent);
  const int shift = plain ? 0 : exponent;

  // 0.0792(41) counts the error in units of the last digit; from 1 on it is written out: 123.4(5.6).
  const bool error_below_one = error.exponent() < shift;
  const std::string in_brackets = error_below_one ? error.digits : positional(error, shift);
  return sign_of(value, number) + positional(number, shift) + "(" + in_brackets + ")" +
         (plain ? std::string() : times_power_of_ten(shift));
}

std::string exact(double value) {
  if (std::isnan(value)) return "nan";  // to_chars shows the sign bit of a NaN, which means nothing
  std::array<char, 32> text = {};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() ? std::string(text.data(), end) : fmt::format("{:.17g}", value);
}

}  // namespace granuscope
