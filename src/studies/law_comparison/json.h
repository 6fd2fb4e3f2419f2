#pragma once
#include <nlohmann/json_fwd.hpp>

#include "measure.h"

namespace granuscope {

/// The members "laws", "law_responses" and "law_costs" of "side" in summary.json.
void write_laws(const ComparedLaws& measured, nlohmann::ordered_json& side);

// What the parts of the report need beside "side", which write_laws has filled: overlays of "/side"
// (report/page_scope.h). What drawing took is no part of summary.json, which holds no times.
nlohmann::ordered_json laws_overlay(const ComparedLaws& measured, const nlohmann::ordered_json& side);
nlohmann::ordered_json law_responses_overlay(const nlohmann::ordered_json& side);
nlohmann::ordered_json law_rules_overlay(const nlohmann::ordered_json& side);

}  // namespace granuscope
