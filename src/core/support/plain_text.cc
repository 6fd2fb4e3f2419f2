#include "support/plain_text.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

namespace granuscope {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";  // U+FFFD

bool continues(std::string_view text, std::size_t at) {
  return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0U) == 0x80U;
}

/// Length of the well-formed multi-byte character at the start of `text`, or 0 (Unicode 15, table 3-7: no overlong
/// forms, no surrogates, nothing beyond U+10FFFF).
std::size_t character_length(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (!continues(text, 1)) return 0;
  const auto second = static_cast<unsigned char>(text[1]);
  if (first >= 0xC2 && first <= 0xDF) return 2;
  if (!continues(text, 2)) return 0;
  if (first == 0xE0) return second >= 0xA0 ? 3 : 0;
  if (first == 0xED) return second <= 0x9F ? 3 : 0;
  if (first > 0xE0 && first <= 0xEF) {
    const bool noncharacter = first == 0xEF && second == 0xBF && static_cast<unsigned char>(text[2]) >= 0xBE;
    return noncharacter ? 0 : 3;  // U+FFFE and U+FFFF are not allowed in XML
  }
  if (!continues(text, 3)) return 0;
  if (first == 0xF0) return second >= 0x90 ? 4 : 0;
  if (first == 0xF4) return second <= 0x8F ? 4 : 0;
  return first > 0xF0 && first < 0xF4 ? 4 : 0;
}

}  // namespace

std::string clean_text(std::string_view bytes) {
  std::string text;
  text.reserve(bytes.size());
  for (std::size_t at = 0; at < bytes.size();) {
    const auto byte = static_cast<unsigned char>(bytes[at]);
    if (byte >= 0x80) {
      const std::size_t length = character_length(bytes.substr(at));
      // U+0080 to U+009F are control characters too.
      const bool control = length == 2 && byte == 0xC2 && static_cast<unsigned char>(bytes[at + 1]) < 0xA0;
      text += length == 0 || control ? replacement : bytes.substr(at, length);
      at += length == 0 ? 1 : length;
      continue;
    }
    if (byte == '\r') {
      if (at + 1 >= bytes.size() || bytes[at + 1] != '\n') text += '\n';
    } else if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7F) {
      text += replacement;
    } else {
      text += bytes[at];
    }
    ++at;
  }
  return text;
}

std::string xml_comment(std::string_view text) {
  std::string said = clean_text(text);
  for (std::size_t at = 0; (at = said.find("--", at)) != std::string::npos;) said.replace(at, 2, "- ");
  return "<!-- " + said + " -->";
}

bool is_plain(std::string_view text, std::string_view signs) {
  return !text.empty() && std::ranges::all_of(text, [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || signs.find(c) != signs.npos;
  });
}

std::string replaced(std::string_view text, std::initializer_list<std::pair<char, std::string_view>> signs) {
  std::string result;
  result.reserve(text.size());
  for (const char c : text) {
    const auto* const sign = std::ranges::find(signs, c, [](const auto& one) { return one.first; });
    result += sign == signs.end() ? std::string_view(&c, 1) : sign->second;
  }
  return result;
}

std::string backslashed(std::string_view text, std::string_view signs) {
  std::string result;
  for (const char c : text) result.append(signs.find(c) == std::string_view::npos ? 0 : 1, '\\') += c;
  return result;
}

std::string percent_encoded(std::string_view text, std::string_view signs) {
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte > ' ' && byte != 0x7F && signs.find(c) == std::string_view::npos;
    result += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return result;
}

std::string escape_markup(std::string_view text) {
  return replaced(text, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}, {'\'', "&#39;"}});
}

std::string pdf_string(std::string_view bytes) {
  const std::string text = clean_text(bytes);
  const bool plain = std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
  if (plain) return "(" + backslashed(text, "()\\") + ")";
  std::string string = "<FEFF";
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const int more = first < 0x80U ? 0 : first < 0xE0U ? 1 : first < 0xF0U ? 2 : 3;
    std::uint32_t code = more == 0 ? first : first & (0x3FU >> static_cast<unsigned>(more));
    for (int k = 1; k <= more; ++k) {
      code = (code << 6U) | (static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]) & 0x3FU);
    }
    i += static_cast<std::size_t>(more) + 1;
    if (code >= 0x10000U) {
      code -= 0x10000U;
      string += fmt::format("{:04X}", 0xD800U + (code >> 10U));
      code = 0xDC00U + (code & 0x3FFU);
    }
    string += fmt::format("{:04X}", code);
  }
  return string + ">";
}

namespace {

/// Marks that turn the direction of what follows (U+202A to U+202E, U+2066 to U+2069): a text would read otherwise than
/// it is.
bool turns_direction(std::string_view text) {
  if (text.size() < 3 || text[0] != '\xE2') return false;
  const auto last = static_cast<unsigned char>(text[2]);
  return (text[1] == '\x80' && last >= 0xAA && last <= 0xAE) || (text[1] == '\x81' && last >= 0xA6 && last <= 0xA9);
}

bool continues_a_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

}  // namespace

std::string single_line(std::string_view text, std::size_t most) {
  std::string line;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (line.size() >= most && !continues_a_character(text[at])) return line + " …";
    const auto byte = static_cast<unsigned char>(text[at]);
    const bool control = byte < 0x20 || byte == 0x7F;
    // U+0080 to U+009F are control characters too, written as C2 80 to C2 9F.
    const bool control_of_two_bytes = byte == 0xC2 && at + 1 < text.size() && continues_a_character(text[at + 1]) &&
                                      static_cast<unsigned char>(text[at + 1]) < 0xA0;
    const bool turns = turns_direction(text.substr(at));
    if (!control && !control_of_two_bytes && !turns) {
      line += text[at];
      continue;
    }
    at += turns ? 2 : control_of_two_bytes ? 1 : 0;
    if (!line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string> parts_between(std::string_view text, std::string_view separator) {
  std::vector<std::string> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.emplace_back(trimmed(text.substr(start, end - start)));
    start = end + separator.size();
  }
  return parts;
}

std::string how_many(std::int64_t number, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", number, number == 1 ? one : many.empty() ? one + "s" : many);
}

bool has_decimal_comma(std::string_view text) {
  const auto digit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  for (std::size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',', comma + 1)) {
    if (comma > 0 && digit(comma - 1) && digit(comma + 1)) return true;
  }
  return false;
}

std::string shallow_json(std::string text, const std::string& source) {
  constexpr int most_levels = 100;
  int level = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\') ++at;
    if (quoted) continue;
    if (c == ']' || c == '}') --level;
    if ((c == '[' || c == '{') && ++level > most_levels) {
      throw InputError(
          "{}: JSON that nests deeper than {} levels is none that granuscope writes; take the file from a backup, or "
          "make it again",
          source, most_levels);
    }
  }
  return text;
}

std::string aligned(std::string_view text) {
  const auto letters = [](std::string_view cell) {
    return static_cast<std::size_t>(
        std::ranges::count_if(cell, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  };
  std::string result;
  std::vector<std::vector<std::string_view>> block;
  const auto put = [&] {
    std::vector<std::size_t> widths;
    for (const auto& row : block) {
      widths.resize(std::max(widths.size(), row.size()));
      for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], letters(row[k]));
    }
    for (const auto& row : block) {
      std::string line;
      for (std::size_t k = 0; k < row.size(); ++k) {
        line += row[k];
        if (k + 1 < row.size()) line.append(widths[k] - letters(row[k]) + 2, ' ');
      }
      result += line.substr(0, line.find_last_not_of(' ') + 1) + '\n';
    }
    block.clear();
  };
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    std::vector<std::string_view> cells;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t end = std::min(line.find('\t', from), line.size());
      cells.push_back(line.substr(from, end - from));
      from = end + 1;
    }
    if (cells.size() == 1) put();
    block.push_back(std::move(cells));
    if (block.back().size() == 1) put();
  }
  put();
  return result;
}

std::string lower_case(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

std::string suffix_of(const std::filesystem::path& file) { return lower_case(file.extension().string()); }

std::string shell_word(const std::string& word) {
  if (is_plain(word, "_-./+,=@")) return word;
  const bool odd = single_line(word, word.size()) != word;  // it would move a terminal's cursor
  std::string text = odd ? "$'" : "'";
  for (const char c : word) {
    const bool in_octal = odd && (c == '\\' || c == '\'' || c <= ' ' || c == 0x7F);  // bytes above it are below 0, too
    text += in_octal    ? fmt::format("\\{:03o}", static_cast<unsigned char>(c))
            : c == '\'' ? std::string("'\\''")
                        : std::string(1, c);
  }
  return text + "'";
}

std::string describe_bytes(double bytes) {
  if (bytes < 1e9) return fmt::format("{:.1f} MB", bytes / 1e6);
  if (bytes < 1e12) return fmt::format("{:.1f} GB", bytes / 1e9);
  return fmt::format("{:.3g} TB", bytes / 1e12);
}

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
  if (standard_error <= std::abs(value) * 1.1e-16) return significant(value, digits_if_exact);

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

namespace {

/// Quoted where a comma, a quote or the end of a line would end it.
std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  return '"' + replaced(text, {{'"', "\"\""}}) + '"';
}

}  // namespace

CsvTable::CsvTable(const std::vector<std::string>& columns) : columns_(columns.size()) {
  std::vector<std::string> names, units;
  for (const std::string& column : columns) {
    const std::size_t at = column.find(": ");
    names.push_back(column.substr(0, at));
    if (at != std::string::npos) units.push_back(column.substr(at + 2));
  }
  if (!units.empty() && units.size() != names.size())
    throw std::logic_error("a column of " + names[0] + " has no unit");
  add_cells(names);
  if (!units.empty()) {
    units.front().insert(0, "#");
    add_cells(units);
  }
  rows_ = 0;
}

void CsvTable::add_row(const std::vector<double>& numbers) {
  std::vector<std::string> cells;
  cells.reserve(numbers.size());
  for (const double number : numbers) cells.push_back(std::isfinite(number) ? exact(number) : "NaN");
  add_cells(cells);
}

void CsvTable::add_cells(const std::vector<std::string>& cells) {
  if (cells.size() != columns_) throw std::logic_error("a row of a table has other cells than it has columns");
  for (std::size_t i = 0; i < cells.size(); ++i) text_ += (i > 0 ? "," : "") + csv_cell(cells[i]);
  text_ += '\n';
  ++rows_;
}

}  // namespace granuscope
