#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {

using NumberPairs = std::vector<std::array<double, 2>>;

/// A value as an experiment file holds it.
using KeyValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<std::int64_t>, std::vector<double>, NumberPairs>;

/// "a whole number", "a list of numbers", ...: what messages call the alternative that `value` holds.
std::string kind_of(const KeyValue& value);

/// The values that a key may take, told once: checked when it is read, shown in the reference.
struct KeyRange {
  double least = -std::numeric_limits<double>::infinity();  ///< of a number, or of each number of a list
  double most = std::numeric_limits<double>::infinity();
  bool beyond_least = false, short_of_most = false;  ///< the end itself is outside
  bool or_zero = false;                              ///< 0 is allowed, too: it switches something off
  std::size_t fewest = 0;                            ///< numbers in a list
  std::size_t longest = 1000;
  bool ascending = false;               ///< a list of distinct numbers, sorted when it is read
  std::vector<std::string> names = {};  ///< of a name: one of these; empty: any
  std::string why = {};                 ///< what is wrong with a value outside; a clause without a full stop

  KeyRange within(double low, double high) &&;
  KeyRange above(double low) &&;  ///< and not `low` itself
  KeyRange below(double high) &&;
};

/// What a key means where the choice is not made under which alone it counts.
enum class Elsewhere {
  refused,   ///< it must be left as it is by default
  left_out,  ///< the same, and stored configurations do not have it
  ignored,   ///< it changes nothing, and stored configurations have 0
};

/// The choice under which alone a key counts: {"estimator", {"point", "paired"}}. Without names it always does.
struct OnlyUnder {
  std::string of;
  std::vector<std::string> names = {};
  Elsewhere elsewhere = Elsewhere::refused;
};

/// One key of an experiment file, bound to the field that it sets: that field must outlive it. The keys of an
/// experiment drive reading, the check for unknown keys and of ranges, printing with comments, and the reference.
struct Key {
  std::string table;    ///< "lattice", "figures.response_profiles"
  std::string name;     ///< "columns"
  std::string unit;     ///< "beads"; "" for a pure number, a name or a switch
  std::string meaning;  ///< one sentence
  KeyRange range;
  std::function<KeyValue()> get;
  /// `value` holds the alternative that get() returns. Throws InputError (without the key's name) if the field cannot
  /// hold it.
  std::function<void(const KeyValue&)> set;
  /// The field in words, on a command line and in stored configurations: no list. What text() returns, read() takes
  /// exactly; it throws InputError (without the key's name).
  std::function<std::string()> text = {};
  std::function<void(const std::string&)> read = {};
  OnlyUnder only = {};

  std::string path() const { return table + "." + name; }
  Key only_under(std::string of, std::vector<std::string> names, Elsewhere elsewhere = Elsewhere::refused) && {
    only = {std::move(of), std::move(names), elsewhere};
    return std::move(*this);
  }
};

/// The key of this name; nullptr: there is none.
const Key* find_key(const std::vector<Key>& keys, std::string_view name);

/// Whether the choice is made under which alone the key counts; `keys`: those that stand beside it.
bool counts(const Key& key, const std::vector<Key>& keys);

/// The first key that was given, for it differs from `usual` (the same keys), where it would change nothing.
Problem find_idle_problem(const std::vector<Key>& keys, const std::vector<Key>& usual);

/// "--sign-run".
std::string flag_of(const Key& key);

/// "0.01 to 0.99", "at least 4", "0 or 8 to 256", "1 to 6 of 0.01 to 100", "point, paired or multiplexed"; empty where
/// everything is allowed.
std::string describe(const KeyRange& range, const KeyValue& like);

/// The first value of the key that lies outside its range; or that would, if the key had this one.
Problem find_range_problem(const Key& key);
Problem find_range_problem(const Key& key, const KeyValue& value);
/// Of all keys but those of these names, told by its name without the table.
Problem find_range_problem(const std::vector<Key>& keys, std::initializer_list<std::string_view> but = {});

namespace key_fields {

// Between a field and its value in a file. The plain alternatives need no conversion.
inline KeyValue to_value(bool field) { return field; }
inline KeyValue to_value(int field) { return std::int64_t{field}; }
inline KeyValue to_value(std::uint64_t field) { return static_cast<std::int64_t>(field); }
inline KeyValue to_value(double field) { return field; }
inline KeyValue to_value(const std::string& field) { return field; }
inline KeyValue to_value(const std::vector<double>& field) { return field; }
inline KeyValue to_value(const NumberPairs& field) { return field; }
KeyValue to_value(const std::vector<int>& field);
KeyValue to_value(const std::array<double, 2>& field);

template <class Field>
void from_value(Field& field, const KeyValue& value) {
  field = std::get<Field>(value);
}
void from_value(int& field, const KeyValue& value);
void from_value(std::uint64_t& field, const KeyValue& value);
void from_value(std::vector<double>& field, const KeyValue& value);
void from_value(std::vector<int>& field, const KeyValue& value);
void from_value(std::array<double, 2>& field, const KeyValue& value);

std::string to_text(double field);
inline std::string to_text(bool field) { return field ? "true" : "false"; }
inline std::string to_text(int field) { return std::to_string(field); }
inline std::string to_text(std::uint64_t field) { return std::to_string(field); }
void from_text(bool& field, const std::string& text);
void from_text(int& field, const std::string& text);
void from_text(std::uint64_t& field, const std::string& text);
void from_text(double& field, const std::string& text);

}  // namespace key_fields

/// A key for a number, a switch, a text or a list of these.
template <class Field>
Key make_key(std::string table, std::string name, std::string unit, std::string meaning, Field& field,
             KeyRange range = {}) {
  Key key{std::move(table),
          std::move(name),
          std::move(unit),
          std::move(meaning),
          std::move(range),
          [&field] { return key_fields::to_value(field); },
          [&field](const KeyValue& value) { key_fields::from_value(field, value); }};
  if constexpr (std::is_arithmetic_v<Field>) {
    key.text = [&field] { return key_fields::to_text(field); };
    key.read = [&field](const std::string& text) { key_fields::from_text(field, text); };
  }
  return key;
}

/// A key for one of several names; `named` throws InputError naming them all.
template <class Field, class Named>
Key make_name_key(std::string table, std::string name, std::string meaning, Field& field, Named named) {
  return {std::move(table),
          std::move(name),
          "",
          std::move(meaning),
          {},
          [&field] { return KeyValue{name_of(field)}; },
          [&field, named](const KeyValue& value) { field = named(std::get<std::string>(value)); },
          [&field] { return name_of(field); },
          [&field, named](const std::string& text) { field = named(text); }};
}

template <class Field, std::size_t count>
Key make_name_key(std::string table, std::string name, std::string meaning, Field& field,
                  const Names<Field, count>& names, const char* what) {
  const auto named = [&names, what](const std::string& text) { return named_in(names, text, what); };
  return make_name_key(std::move(table), std::move(name), std::move(meaning), field, named);
}

}  // namespace granuscope
