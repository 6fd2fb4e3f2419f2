#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "measure.h"

namespace granuscope {

/// The members "laws", "responses" and "costs".
nlohmann::ordered_json laws_json(const ComparedLaws& measured);

// What the parts of the report need beside these `results`, which stand at `base` of summary.json: overlays of `base`
// (report/page_scope.h).
nlohmann::ordered_json laws_overlay(const nlohmann::ordered_json& results, const std::string& base);
nlohmann::ordered_json law_responses_overlay(const nlohmann::ordered_json& results);
nlohmann::ordered_json law_rules_overlay(const nlohmann::ordered_json& results, const std::string& base);
/// Of the sentences of page 1, over all studies; null where fewer than two laws were compared.
nlohmann::ordered_json laws_page_1(const nlohmann::ordered_json& results, const std::string& base);

}  // namespace granuscope
