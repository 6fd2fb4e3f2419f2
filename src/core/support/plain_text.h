#pragma once
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/error.h"

namespace granuscope {
/// `bytes` as valid UTF-8 that every reader of XML, HTML and JSON accepts: each malformed sequence and each control
/// character other than tab and line feed becomes U+FFFD; carriage returns become line feeds.
std::string clean_text(std::string_view bytes);

/// Whether text has ASCII letters and digits, and else these signs alone; not if it is empty.
bool is_plain(std::string_view text, std::string_view signs);

/// Text in which some signs are replaced by what stands beside them.
std::string replaced(std::string_view text, std::initializer_list<std::pair<char, std::string_view>> signs);
/// Text with a backslash before each of these signs.
std::string backslashed(std::string_view text, std::string_view signs);
/// Text with %XX for these signs, blanks and control characters.
std::string percent_encoded(std::string_view text, std::string_view signs);

/// Text for HTML and XML, in content or in a quoted attribute: & < > " ' escaped.
std::string escape_markup(std::string_view text);

/// Text as a comment of XML, in which no two hyphens may follow each other.
std::string xml_comment(std::string_view text);

/// Text as a PDF string: as it is where it is ASCII, else UTF-16.
std::string pdf_string(std::string_view text);

/// Text of others (a file name, what another program printed) as a part of a message: line ends, other control
/// characters and marks of direction become single spaces, so that it can neither break the line nor move a terminal's
/// cursor; after `most` bytes it is cut off with an ellipsis, between two characters.
std::string single_line(std::string_view text, std::size_t most = 400);

/// "1 pile" or "2 piles"; `many` where an s behind `one` is not it: of "is missing", say.
std::string how_many(std::int64_t number, const std::string& one, const std::string& many = "");

/// Whether a comma stands between two digits, as in 0,25.
bool has_decimal_comma(std::string_view text);

/// The same text, to be parsed as JSON: throws InputError, which names `source`, if it nests deeper than any file of
/// this program, which would end in a signal where what was read is gone through.
std::string shallow_json(std::string text, const std::string& source = "this text");

/// Text in which tabs part columns, with each column of neighbouring lines as wide as its widest cell, for a terminal.
std::string aligned(std::string_view text);

/// Text without the blanks, tabs and line ends around it.
std::string_view trimmed(std::string_view text);
/// What stands between separators, trimmed; at least one part.
std::vector<std::string> parts_between(std::string_view text, std::string_view separator);

/// Text as one word of a shell command that is printed to be pasted: in quotes where it needs them.
std::string shell_word(const std::string& word);
/// Text with the letters A to Z as small ones.
std::string lower_case(std::string text);
/// Of a file, in small letters and with its point: ".png" of a.PNG.
std::string suffix_of(const std::filesystem::path& file);

/// "12.3 MB", "25.3 GB", "4.61e+08 TB": decimal prefixes, three digits, never less than a megabyte.
std::string describe_bytes(double bytes);

/// A number with its standard error as physicists write it: value_with_error(0.07923, 0.0041) = "0.0792(41)". Always
/// with two significant digits of the error, in units of the value's last digit; an error of 1 or more is written out:
/// "123.4(5.6)". Below 1e-4 and above 1e6: "3.21(14) × 10⁻⁷". A zero error (or one below the resolution of a double)
/// gives the value with `digits_if_exact` significant digits. Unknown (not finite, negative error): "n/a". Minus signs
/// are the typographic U+2212.
std::string value_with_error(double value, double standard_error, int digits_if_exact = 6,
                             int lowest_plain_exponent = -4);

/// The value rounded to `digits` significant digits, with a typographic minus; never in exponent form for 1e-4..1e6,
/// "3.2 × 10⁻⁷" beyond. Not finite: "n/a".
std::string significant(double value, int digits);

/// "10⁻⁷".
std::string power_of_ten(int exponent);

/// `value` in the shortest form that reads back to the same double (std::to_chars); for scripts and data files.
std::string exact(double value);

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

/// Every CSV file of the program: a line of names, one of units that begins with #, then rows. So pandas reads it with
/// comment="#", numpy.loadtxt with delimiter="," and skiprows=1, numpy.genfromtxt with names=True.
class CsvTable {
 public:
  /// Columns as "name: unit", "dimensionless" if they have none; names alone, and no line of units, for a table of
  /// texts.
  explicit CsvTable(const std::vector<std::string>& columns);
  /// Unknown numbers are written as NaN, which gnuplot leaves out; all others in the shortest form that reads back to
  /// the same double.
  void add_row(const std::vector<double>& numbers);
  void add_cells(const std::vector<std::string>& cells);
  bool empty() const { return rows_ == 0; }
  const std::string& text() const { return text_; }

 private:
  std::size_t columns_;
  std::size_t rows_ = 0;
  std::string text_;
};

/// Whether the whole text is this number, which is then set (std::from_chars).
template <class Number, class... Base>
bool read_whole(std::string_view text, Number& number, Base... base) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base...);
  return error == std::errc() && end == text.data() + text.size();
}

/// The names of an enumeration, as files and command lines have them.
template <class Choice, std::size_t count>
using Names = std::array<std::pair<Choice, const char*>, count>;

template <class Choice, std::size_t count>
std::string name_in(const Names<Choice, count>& names, Choice choice) {
  for (const auto& [one, name] : names) {
    if (one == choice) return name;
  }
  return {};
}

/// "granusolve, eloy-clement, rejection and polytope".
template <class Choice, std::size_t count>
std::string all_names(const Names<Choice, count>& names) {
  std::string all;
  for (std::size_t k = 0; k < count; ++k)
    all += (k == 0 ? "" : k + 1 == count ? " and " : ", ") + std::string(names[k].second);
  return all;
}

/// Throws InputError "there is no law ...", which names them all; `what`: "law".
template <class Choice, std::size_t count>
Choice named_in(const Names<Choice, count>& names, const std::string& wanted, const char* what) {
  for (const auto& [one, name] : names) {
    if (name == wanted) return one;
  }
  throw InputError("there is no {} \"{}\": known are {}; choose one", what, wanted, all_names(names));
}

}  // namespace granuscope
