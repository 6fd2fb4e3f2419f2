#pragma once
#include <stdexcept>
#include <string>

#include "experiment/experiment_keys.h"

namespace granuscope {

/// Sets one key of an experiment by its path, as its file would; no range is checked.
inline void set_key(Experiment& experiment, const std::string& path, const KeyValue& value) {
  for (const Key& key : keys_of(experiment)) {
    if (key.path() == path) return key.set(value);
  }
  throw std::out_of_range(path);
}

/// Lists of numbers without their long type.
inline KeyValue numbers(std::vector<double> list) { return list; }
inline KeyValue whole_numbers(std::vector<std::int64_t> list) { return list; }

}  // namespace granuscope
