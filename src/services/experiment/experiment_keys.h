#pragma once
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "support/key.h"

namespace granuscope {
/// Every key of this experiment, in the order in which they are printed; the keys of one table stand together. They are
/// bound to its fields: it must outlive them and stay where it is.
std::vector<Key> keys_of(Experiment& experiment);
/// The same of one that is only read: none of them may be set.
inline std::vector<Key> keys_to_read(const Experiment& experiment) {
  return keys_of(const_cast<Experiment&>(experiment));
}

/// The path of the key of this name; of several the one nearest to the top, the likeliest; "" if there is none.
std::string nearest_to_top(const std::vector<Key>& keys, const std::string& name);

/// A value as an experiment file holds it.
std::string print_value(const KeyValue& value);

/// The table whose tables are pictures, each under a free name, and the keys of one of them, which the experiment must
/// have.
inline constexpr const char* pictures_table = "scenes.pictures";
std::vector<Key> picture_keys(Experiment& experiment, const std::string& name);

/// The table that maps claim ids to expected verdicts; its keys are free names.
inline constexpr const char* expected_verdicts_table = "gate.expect";
inline constexpr const char* expected_verdicts_meaning =
    "verdict expected of a claim (reproduced, not reproduced, not decided, not tested): --gate exits with 1 if another "
    "comes out";

}  // namespace granuscope
