#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "support/error.h"

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

/// One key of an experiment file, bound to the field that it sets: that field must outlive it. The keys of an
/// experiment drive reading, the check for unknown keys and of ranges, printing with comments, and the reference.
struct Key {
  std::string table;    ///< "lattice", "figures.response_profiles"
  std::string name;     ///< "columns"
  std::string unit;     ///< "beads"; "" for a pure number, a name or a switch
  std::string meaning;  ///< one sentence
  KeyRange range;
  std::string formerly;  ///< path, or name in any table, under which older files have it: refused with the path of now
  std::function<KeyValue()> get;
  /// `value` holds the alternative that get() returns. Throws InputError (without the key's name) if the field cannot
  /// hold it.
  std::function<void(const KeyValue&)> set;

  std::string path() const { return table + "." + name; }
  Key formerly_at(std::string old_path) && {
    formerly = std::move(old_path);
    return std::move(*this);
  }
};

/// "0.01 to 0.99", "at least 4", "0 or 8 to 256", "1 to 6 of 0.01 to 100", "point, paired or multiplexed"; empty where
/// everything is allowed.
std::string describe(const KeyRange& range, const KeyValue& like);

/// The first value of the key that lies outside its range.
Problem find_range_problem(const Key& key);

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

}  // namespace key_fields

/// A key for a number, a switch, a text or a list of these.
template <class Field>
Key make_key(std::string table, std::string name, std::string unit, std::string meaning, Field& field,
             KeyRange range = {}) {
  return {std::move(table),
          std::move(name),
          std::move(unit),
          std::move(meaning),
          std::move(range),
          {},
          [&field] { return key_fields::to_value(field); },
          [&field](const KeyValue& value) { key_fields::from_value(field, value); }};
}

/// A key for one of several names; `named` throws InputError naming them all.
template <class Field>
Key make_name_key(std::string table, std::string name, std::string meaning, Field& field,
                  Field (*named)(const std::string&)) {
  return {std::move(table),
          std::move(name),
          "",
          std::move(meaning),
          {},
          {},
          [&field] { return KeyValue{name_of(field)}; },
          [&field, named](const KeyValue& value) { field = named(std::get<std::string>(value)); }};
}

}  // namespace granuscope
