#pragma once
#include <nlohmann/json.hpp>

#include "figure.h"

namespace granuscope {

/// The results as they stand in summary.json.
nlohmann::ordered_json models_json(const MeasuredModels& measured);

/// What the sentences of page 1 need beside these: series by the number of their peaks, exponents that are known, and
/// the smallest and largest known share of the slowing that a mean explains.
nlohmann::ordered_json models_page_1(const nlohmann::ordered_json& results);

}  // namespace granuscope
