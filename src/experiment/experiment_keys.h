#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "experiment/experiment.h"

namespace granuscope {

using NumberPairs = std::vector<std::array<double, 2>>;

/// A value as an experiment file holds it.
using KeyValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<std::int64_t>, std::vector<double>, NumberPairs>;

/// "a whole number", "a list of numbers", ...: what messages call the alternative that `value` holds.
std::string kind_of(const KeyValue& value);

/// One key of the experiment file. The table of all keys drives reading, the check for unknown keys, printing with
/// comments and the reference in README.
struct ExperimentKey {
  std::string table;    ///< "lattice", "figures.response_profiles"
  std::string name;     ///< "columns"
  std::string unit;     ///< "beads"; "" for a pure number, a name or a switch
  std::string meaning;  ///< one sentence
  std::function<KeyValue(const Experiment&)> get;
  /// `value` holds the alternative that get() returns. Throws InputError (without the key's name) if the field cannot
  /// hold it.
  std::function<void(Experiment&, const KeyValue&)> set;

  std::string path() const { return table + "." + name; }
};

/// Every key, in the order in which they are printed; the keys of one table stand together.
const std::vector<ExperimentKey>& experiment_keys();

/// The table whose tables are pictures, each under a free name, and the keys of one of them, which the experiment must
/// have.
inline constexpr const char* pictures_table = "scenes.pictures";
std::vector<ExperimentKey> picture_keys(const std::string& name);

/// The table that maps claim ids to expected verdicts; its keys are free names.
inline constexpr const char* expected_verdicts_table = "gate.expect";
inline constexpr const char* expected_verdicts_meaning =
    "verdict expected of a claim (reproduced, not reproduced, undetermined): --gate exits with 1 if another comes out";

}  // namespace granuscope
