#pragma once
#include <nlohmann/json_fwd.hpp>

#include "report/report_data.h"

namespace granuscope {

/// What templates/studies/ asks for beside summary.json, as overlays (report/page_scope.h) of "/side".
nlohmann::ordered_json law_comparison_overlay(const nlohmann::ordered_json& summary, const ReportData& data);
nlohmann::ordered_json rejection_thrust_overlay(const nlohmann::ordered_json& summary);
nlohmann::ordered_json law_responses_overlay(const nlohmann::ordered_json& summary);
nlohmann::ordered_json law_rules_overlay(const nlohmann::ordered_json& summary);

}  // namespace granuscope
