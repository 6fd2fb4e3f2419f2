#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_overlay.h"

namespace granuscope {

using Json = nlohmann::ordered_json;

namespace {

/// A claim keeps its number and the standard error side by side: two cells, the number with the decimals of its error.
void add_measured(Json& row, const Json& claim, const std::string& pointer) {
  if (!claim.at("measured").is_number() || !claim.at("stderr").is_number()) return;
  const auto value = claim.at("measured").get<double>(), error = claim.at("stderr").get<double>();
  if (!(error > 0)) return;
  const std::string both = plain_value_with_error(value, error);  // "2.538(81)"
  const std::string number = both.substr(0, both.find('('));
  const std::size_t point = number.find('.');
  const std::size_t decimals = point == std::string::npos ? 0 : number.size() - point - 1;
  row["measured"] = {{"key", pointer + "/measured"}, {"text", number}};
  row["error"] = {{"key", pointer + "/stderr"},
                  {"text", format_number(claim.at("stderr"), fmt::format("fixed {}", decimals))}};
}

}  // namespace

std::string look_of(const std::string& verdict) {
  return verdict == "reproduced" ? "yes" : verdict == "not reproduced" ? "no" : "open";
}

void add_claims(Json& overlay, const Json& summary) {
  Json rows = Json::array();
  int reproduced = 0, not_reproduced = 0, undetermined = 0, unmeasured = 0;
  for (const Json& claim : summary.at("claims")) {
    const auto verdict = claim.at("verdict").get<std::string>();
    Json row = {{"look", look_of(verdict)},
                {"in_doubt", verdict != "reproduced"},
                {"differs", claim.at("expected").is_string() && claim.at("expected") != verdict}};
    add_measured(row, claim, fmt::format("/claims/{}", rows.size()));
    rows.push_back(row);
    ++(verdict == "reproduced" ? reproduced : verdict == "not reproduced" ? not_reproduced : undetermined);
    if (verdict == "undetermined" && claim.at("measured").is_null()) ++unmeasured;
  }
  overlay["claim_counts"] = {{"all", rows.size()},
                             {"reproduced", reproduced},
                             {"not_reproduced", not_reproduced},
                             {"undetermined", undetermined},
                             {"unmeasured", unmeasured}};
  overlay["has_claims"] = !rows.empty();
  overlay["claims"] = rows;
}

}  // namespace granuscope
