#pragma once
#include <nlohmann/json.hpp>

#include "ensemble/response_spec.h"

namespace granuscope {

/// {"estimator", "overload"}, or {"estimator": "multiplexed", "epsilon" and its options}.
nlohmann::ordered_json to_json(const ResponseSpec& response);

}  // namespace granuscope
