#pragma once
#include <nlohmann/json.hpp>

#include "analysis/side_measurements.h"

namespace granuscope {

/// The object "side" of summary.json: one list per kind of side measurement, empty where it was not asked for.
nlohmann::ordered_json to_json(const SideMeasurements& side);

}  // namespace granuscope
