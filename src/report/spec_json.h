#pragma once
#include <nlohmann/json.hpp>

#include "ensemble/response_spec.h"

namespace granuscope {

/// {"estimator", "overload"}, or {"estimator": "multiplexed" or "fluctuation", and its options}.
nlohmann::ordered_json to_json(const ResponseSpec& response);

}  // namespace granuscope
