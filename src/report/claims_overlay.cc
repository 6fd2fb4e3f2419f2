#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_overlay.h"
#include "support/number_format.h"

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

namespace {

constexpr double strip_reach = 10;  ///< pulls that the strip shows; beyond, an arrow at its end

/// The pull as a place on a strip, clipped with an arrow.
void add_pull(Json& row, const Json& claim) {
  if (!claim.at("z_score").is_number()) return;
  const double pull = claim.at("z_score").get<double>();
  row["pull"] = {{"at", fmt::format("{:.2f}", std::clamp(pull, -strip_reach, strip_reach))},
                 {"beyond_right", pull > strip_reach},
                 {"beyond_left", pull < -strip_reach},
                 {"inside", std::abs(pull) <= strip_reach}};
}

/// Error and tolerance of the paper's number together.
void add_allowed(Json& row, const Json& claim) {
  if (!claim.at("paper").is_number()) return;
  const double allowed = std::hypot(claim.at("paper_stderr").get<double>(), claim.at("tolerance").get<double>());
  if (allowed > 0) row["allowed"] = significant(allowed, 2);
}

}  // namespace

std::string look_of(const std::string& verdict) {
  return verdict == "reproduced"       ? "yes"
         : verdict == "not reproduced" ? "no"
         : verdict == "not tested"     ? "untested"
                                       : "open";
}

void add_claims(Json& overlay, const Json& summary) {
  Json rows = Json::array();
  std::map<std::string, int> counts;
  for (const Json& claim : summary.at("claims")) {
    const auto verdict = claim.at("verdict").get<std::string>();
    Json row = {{"look", look_of(verdict)},
                {"tested", verdict != "not tested"},
                {"pull", nullptr},
                {"allowed", ""},
                {"rival_off", claim.at("rival").is_object() && claim.at("rival").at("distance").is_number()
                                  ? fmt::format("{:.1f}", std::abs(claim.at("rival").at("distance").get<double>()))
                                  : ""},
                {"excludes", claim.at("rival").is_object() && claim.at("paper").is_null()},
                {"differs", claim.at("expected").is_string() && claim.at("expected") != verdict}};
    add_measured(row, claim, fmt::format("/claims/{}", rows.size()));
    add_pull(row, claim);
    add_allowed(row, claim);
    rows.push_back(row);
    ++counts[verdict];
  }
  overlay["claim_counts"] = {{"all", rows.size()},
                             {"reproduced", counts["reproduced"]},
                             {"not_reproduced", counts["not reproduced"]},
                             {"not_decided", counts["not decided"]},
                             {"not_tested", counts["not tested"]}};
  overlay["has_claims"] = !rows.empty();
  std::vector<std::string> untested;
  for (const Json& claim : summary.at("claims")) {
    if (claim.at("verdict") == "not tested") untested.push_back(claim.at("id"));
  }
  overlay["any_tested"] = untested.size() < rows.size();
  overlay["untested_list"] = fmt::format("{}", fmt::join(untested, ", "));
  overlay["claims"] = rows;
}

}  // namespace granuscope
