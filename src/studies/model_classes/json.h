#pragma once
#include <nlohmann/json.hpp>
#include <vector>

#include "figure.h"

namespace granuscope {

/// The results as they stand in summary.json.
nlohmann::ordered_json models_json(const std::vector<ModelSeries>& measured,
                                   const std::vector<TractionDepth>& tractions);

/// What the sentences of page 1 need beside these: series by the number of their peaks, exponents that are known, and
/// the smallest and largest known share of the slowing that a mean explains.
nlohmann::ordered_json models_page_1(const nlohmann::ordered_json& results);

}  // namespace granuscope
