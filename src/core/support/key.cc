#include "support/key.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>

#include "support/plain_text.h"

namespace granuscope {
namespace {

int to_int(std::int64_t number) {
  if (number < std::numeric_limits<int>::min() || number > std::numeric_limits<int>::max()) {
    constexpr double bytes_per_bead = 96;  // four forces, and what a solver keeps beside them
    throw InputError(
        "{} is beyond what this key can hold ({} at most; so many beads in a row would need {} of memory); give a "
        "smaller number",
        number, std::numeric_limits<int>::max(),
        describe_bytes(bytes_per_bead * std::abs(static_cast<double>(number))));
  }
  return static_cast<int>(number);
}

bool is_inside(double number, const KeyRange& range) {
  if (range.or_zero && number == 0) return true;
  return number >= range.least && number <= range.most && !(range.beyond_least && number == range.least) &&
         !(range.short_of_most && number == range.most) && std::isfinite(number);
}

/// "0.01 to 0.99", "more than 0 and at most 0.6", "at least 4".
std::string describe_numbers(const KeyRange& range) {
  const bool low = std::isfinite(range.least), high = std::isfinite(range.most);
  std::string text;
  if (low && high && !range.beyond_least && !range.short_of_most) {
    text = fmt::format("{:.10g} to {:.10g}", range.least, range.most);
  } else {
    if (low) text += fmt::format("{} {:.10g}", range.beyond_least ? "more than" : "at least", range.least);
    if (low && high) text += " and ";
    if (high) text += fmt::format("{} {:.10g}", range.short_of_most ? "less than" : "at most", range.most);
  }
  return range.or_zero && !text.empty() ? "0, or " + text : text;
}

std::string because(const KeyRange& range) { return range.why.empty() ? "" : ": " + range.why; }

Problem out_of_range(const std::string& key, const std::vector<double>& numbers, const KeyRange& range) {
  return problem(key, "{} {} out of range{}; give {}", fmt::join(numbers, " and "), numbers.size() > 1 ? "are" : "is",
                 because(range),
                 std::isfinite(range.least) || std::isfinite(range.most) ? describe_numbers(range) : "a finite number");
}

Problem find_number_problem(const std::string& key, double number, const KeyRange& range) {
  return is_inside(number, range) ? Problem() : out_of_range(key, {number}, range);
}

template <class Number>
Problem find_list_problem(const std::string& key, const std::vector<Number>& numbers, const KeyRange& range) {
  if (numbers.size() < range.fewest || numbers.size() > range.longest) {
    // Where the numbers have limits, the reason is that of the limits.
    const std::string reason = describe_numbers(range).empty() ? because(range) : "";
    if (numbers.empty())
      return problem(key, "the list is empty{}; give {} to {} values", reason, range.fewest, range.longest);
    return problem(key, "{}{}; give {} to {}", how_many(numbers.size(), "value"), reason, range.fewest, range.longest);
  }
  std::vector<double> outside;
  std::ranges::copy_if(numbers, std::back_inserter(outside), [&](double number) { return !is_inside(number, range); });
  outside.resize(std::min<std::size_t>(outside.size(), 5));  // enough to be told
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    if (!is_inside(static_cast<double>(numbers[k]), range)) return out_of_range(key, outside, range);
    if (range.ascending && k > 0 && numbers[k] <= numbers[k - 1]) {
      return numbers[k] == numbers[k - 1]
                 ? problem(key, "{} stands in the list twice; remove one{}", numbers[k],
                           std::is_same_v<Number, double> && std::fmod(numbers[k], 1) == 0
                               ? ", or write points where these are decimal commas"
                               : "")
                 : problem(key, "{} follows {}, but the list must ascend; sort it", numbers[k], numbers[k - 1]);
    }
  }
  return {};
}

struct RangeCheck {
  const std::string& key;
  const KeyRange& range;

  Problem operator()(bool) const { return {}; }
  Problem operator()(std::int64_t number) const { return find_number_problem(key, static_cast<double>(number), range); }
  Problem operator()(double number) const { return find_number_problem(key, number, range); }
  Problem operator()(const std::string& name) const {
    if (range.names.empty() || std::ranges::find(range.names, name) != range.names.end()) return {};
    return problem(key, "\"{}\" is none of its names{}; write one of {}", name, because(range),
                   fmt::join(range.names, ", "));
  }
  Problem operator()(const std::vector<std::int64_t>& numbers) const { return find_list_problem(key, numbers, range); }
  Problem operator()(const std::vector<double>& numbers) const { return find_list_problem(key, numbers, range); }
  Problem operator()(const NumberPairs& pairs) const {
    for (const auto& pair : pairs) {
      if (auto found = find_list_problem(key, std::vector<double>(pair.begin(), pair.end()), range)) return found;
    }
    return {};
  }
};

}  // namespace

std::string kind_of(const KeyValue& value) {
  static constexpr const char* kinds[] = {"true or false",
                                          "a whole number",
                                          "a number",
                                          "a string",
                                          "a list of whole numbers",
                                          "a list of numbers",
                                          "a list of pairs of numbers"};
  static_assert(std::size(kinds) == std::variant_size_v<KeyValue>);
  return kinds[value.index()];
}

KeyRange KeyRange::within(double low, double high) && {
  least = low;
  most = high;
  return std::move(*this);
}

KeyRange KeyRange::above(double low) && {
  least = low;
  beyond_least = true;
  return std::move(*this);
}

KeyRange KeyRange::below(double high) && {
  most = high;
  short_of_most = true;
  return std::move(*this);
}

std::string describe(const KeyRange& range, const KeyValue& like) {
  if (!range.names.empty()) return fmt::format("{}", fmt::join(range.names, ", "));
  if (std::holds_alternative<bool>(like)) return "true, false";
  const bool list = std::holds_alternative<std::vector<std::int64_t>>(like) ||
                    std::holds_alternative<std::vector<double>>(like) || std::holds_alternative<NumberPairs>(like);
  std::string numbers = describe_numbers(range);
  if (!list || range.longest == KeyRange{}.longest) return numbers;
  return fmt::format("{} to {} values{}", range.fewest, range.longest, numbers.empty() ? "" : ", each " + numbers);
}

Problem find_range_problem(const Key& key) { return find_range_problem(key, key.get()); }

Problem find_range_problem(const Key& key, const KeyValue& value) {
  return std::visit(RangeCheck{key.path(), key.range}, value);
}

Problem find_range_problem(const std::vector<Key>& keys, std::initializer_list<std::string_view> but) {
  for (const Key& key : keys) {
    if (std::ranges::find(but, key.name) != but.end()) continue;
    if (auto found = std::visit(RangeCheck{key.name, key.range}, key.get())) return found;
  }
  return {};
}

const Key* find_key(const std::vector<Key>& keys, std::string_view name) {
  const auto found = std::ranges::find_if(keys, [&](const Key& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

bool counts(const Key& key, const std::vector<Key>& keys) {
  const std::vector<std::string>& names = key.only.names;
  return names.empty() || std::ranges::find(names, find_key(keys, key.only.of)->text()) != names.end();
}

Problem find_idle_problem(const std::vector<Key>& keys, const std::vector<Key>& usual) {
  for (const Key& key : keys) {
    if (key.only.elsewhere == Elsewhere::ignored || counts(key, keys)) continue;
    if (key.text() == find_key(usual, key.name)->text()) continue;
    return problem(key.name,
                   "it belongs to the {} {} and would change nothing under {}; leave it out, or choose that {}",
                   key.only.of, fmt::join(key.only.names, " or "), find_key(keys, key.only.of)->text(), key.only.of);
  }
  return {};
}

std::string flag_of(const Key& key) {
  std::string flag = "--" + key.name;
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

namespace key_fields {

KeyValue to_value(const std::vector<int>& field) { return std::vector<std::int64_t>(field.begin(), field.end()); }
KeyValue to_value(const std::array<double, 2>& field) { return std::vector<double>(field.begin(), field.end()); }

void from_value(int& field, const KeyValue& value) { field = to_int(std::get<std::int64_t>(value)); }

void from_value(std::uint64_t& field, const KeyValue& value) {
  const auto number = std::get<std::int64_t>(value);
  if (number < 0) throw InputError("{} is negative; give 0 or more", number);
  field = static_cast<std::uint64_t>(number);
}

void from_value(std::vector<double>& field, const KeyValue& value) {
  field = std::get<std::vector<double>>(value);
  for (double& number : field) number += 0.0;  // -0.0 becomes 0, whose sign no file name should show
}

void from_value(std::vector<int>& field, const KeyValue& value) {
  std::vector<int> numbers;
  for (const auto number : std::get<std::vector<std::int64_t>>(value)) numbers.push_back(to_int(number));
  field = std::move(numbers);
}

void from_value(std::array<double, 2>& field, const KeyValue& value) {
  const auto& numbers = std::get<std::vector<double>>(value);
  if (numbers.size() != 2) {
    throw InputError("a window needs two ends, not {}; write [low, high]", how_many(numbers.size(), "number"));
  }
  field = {numbers[0], numbers[1]};
}

std::string to_text(double field) { return exact(field); }

namespace {

constexpr const char* whole = "a whole number";

/// Without what a number of an experiment file may have, too: a plus, _ between digits, blanks around.
std::string plain_number(std::string_view given) {
  std::string text(trimmed(given));
  if (text.find("__") == std::string::npos && !text.starts_with('_') && !text.ends_with('_')) std::erase(text, '_');
  if (text.starts_with('+') && text.find_first_of("+-", 1) != 1) text.erase(0, 1);
  return text;
}

template <class Number>
Number read_number(const std::string& given, const char* kind) {
  const std::string text = plain_number(given);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size()) return number;
  if constexpr (std::is_integral_v<Number>) {  // 1e3 and 64.0 are whole, too
    constexpr double most = 9007199254740992;  // up to which each whole number is a double
    double real = 0;
    const bool is_whole = read_whole(text, real) && real == std::floor(real);
    if (is_whole && std::abs(real) <= most && (real >= 0 || std::is_signed_v<Number>)) return static_cast<Number>(real);
    const int base = text.starts_with("0x") ? 16 : text.starts_with("0o") ? 8 : text.starts_with("0b") ? 2 : 0;
    if (base != 0 && read_whole(std::string_view(text).substr(2), number, base)) return number;
  }
  const std::string shown = single_line(given);
  if (std::is_unsigned_v<Number> && text.starts_with('-')) throw InputError(shown + " is negative; give 0 or more");
  if (error == std::errc::result_out_of_range)
    throw InputError("{} is too large; give at most {}", shown, std::numeric_limits<Number>::max());
  throw InputError("{} is not {}; write it {}", shown, kind,
                   has_decimal_comma(shown) && !std::is_integral_v<Number> ? "with a decimal point" : "in digits");
}

}  // namespace

void from_text(bool& field, const std::string& text) {
  if (text != "true" && text != "false") throw InputError(single_line(text) + " is neither true nor false; write one");
  field = text == "true";
}

void from_text(int& field, const std::string& text) { field = to_int(read_number<std::int64_t>(text, whole)); }
void from_text(std::uint64_t& field, const std::string& text) { field = read_number<std::uint64_t>(text, whole); }
void from_text(double& field, const std::string& text) { field = read_number<double>(text, "a number"); }

}  // namespace key_fields
}  // namespace granuscope
