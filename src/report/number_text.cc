#include "report/number_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* unknown = "n/a";

/// Four significant digits, without the zeros that only fill them up: 0.3 is a setting, not 0.3000, and 10⁻⁹ no
/// 1.000 × 10⁻⁹.
std::string plain_number(double value) {
  std::string text = significant(value, 4);
  const std::size_t times = text.find(" × ");
  std::string digits = text.substr(0, times);
  if (digits.find('.') == std::string::npos) return text;
  while (digits.back() == '0') digits.pop_back();
  if (digits.back() == '.') digits.pop_back();
  return times == std::string::npos ? digits : digits + text.substr(times);
}

std::string fixed_number(double number, int decimals) {
  std::string text = fmt::format("{:.{}f}", std::abs(number), decimals);
  if (number < 0 && text.find_first_not_of("0.") != std::string::npos) text.insert(0, "−");
  return text;
}

/// 2, of "fixed 2".
int digits_of(std::string_view format) {
  const std::string digits(format.substr(format.find(' ') + 1));
  if (digits.empty() || digits.size() > 2 || digits.find_first_not_of("0123456789") != std::string::npos) {
    throw std::logic_error(fmt::format("\"{}\" does not say how many digits", format));
  }
  return std::stoi(digits);
}

}  // namespace

std::string format_number(const Json& value, std::string_view format) {
  if (value.is_null()) return unknown;
  if (value.is_string()) return value.get<std::string>();
  const bool estimate = value.is_object() && value.contains("value") && value.contains("stderr");
  if (!value.is_number() && !estimate) throw std::logic_error("neither a number nor a text: " + value.dump());
  if (estimate) {
    if (value["value"].is_null() || value["stderr"].is_null()) return unknown;
    const auto number = value["value"].get<double>(), error = value["stderr"].get<double>();
    if (format == "plain") return plain_value_with_error(number, error);
    if (format.empty()) return value_with_error(number, error);
  } else if (format.starts_with("fixed ")) {
    return fixed_number(value.get<double>(), digits_of(format));
  } else if (format.starts_with("significant ")) {
    return significant(value.get<double>(), digits_of(format));
  } else if (format.empty() || format == "plain") {
    if (value.is_number_unsigned()) return std::to_string(value.get<std::uint64_t>());
    if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
    return plain_number(value.get<double>());
  }
  throw std::logic_error(fmt::format("{} is not written in the format \"{}\"", value.dump(), format));
}

std::string plain_value_with_error(double value, double standard_error) {
  constexpr int digits_if_exact = 6, smallest_exponent = -12;
  return value_with_error(value, standard_error, digits_if_exact, smallest_exponent);
}

}  // namespace granuscope
