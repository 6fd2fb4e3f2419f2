#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/estimate.h"

namespace granuscope {

/// The number, or null: NaN and infinity never appear in a file.
nlohmann::ordered_json finite_or_null(double number);

/// The reason, or that none was recorded.
std::string stated(const std::string& reason);

/// {"value", "stderr"}, or nulls beside a "reason".
nlohmann::ordered_json to_json(const Estimate& estimate);

}  // namespace granuscope
