#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "analysis/estimate.h"
#include "analysis/scaling_fit.h"
#include "analysis/thrust_at_depth.h"

namespace granuscope {

/// The number, or null: NaN and infinity never appear in a file.
nlohmann::ordered_json finite_or_null(double number);

/// The reason, or that none was recorded.
std::string stated(const std::string& reason);

/// {"value", "stderr"}, or nulls beside a "reason".
nlohmann::ordered_json to_json(const Estimate& estimate);

/// {"layer", "z", "thrust_ratio", "weight_variance"}.
nlohmann::ordered_json to_json(const ThrustAtDepth& depth);

/// {"chi2", "degrees_of_freedom", "points"}.
nlohmann::ordered_json to_json(const LineTest& test);

/// {"at_low": {"value", "stderr", "at"}, "at_high", "about_law"}.
nlohmann::ordered_json to_json(const RunningExponent& running);

}  // namespace granuscope
