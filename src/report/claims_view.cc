#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/clean_text.h"
#include "report/number_text.h"
#include "report/report_view.h"
#include "report/unbroken_text.h"

namespace granuscope {

using Json = nlohmann::ordered_json;

namespace {

/// A claim keeps its number and the standard error side by side: two cells, the number with the decimals of its error.
Json measured_cells(const Json& summary, const std::string& claim) {
  Json cells;
  cells["value"] = number_cell(summary, claim + "/measured");
  cells["error"] = Json::object();
  const Json& place = summary.at(Json::json_pointer(claim));
  if (!place.at("measured").is_number() || !place.at("stderr").is_number()) return cells;
  const auto value = place.at("measured").get<double>();
  const auto error = place.at("stderr").get<double>();
  if (!(error > 0)) return cells;
  const std::string both = plain_value_with_error(value, error);  // "2.538(81)"
  const std::string number = both.substr(0, both.find('('));
  const std::size_t point = number.find('.');
  const auto decimals = point == std::string::npos ? 0 : static_cast<int>(number.size() - point - 1);
  cells["value"]["text"] = number;
  cells["error"] = fixed_cell(summary, claim + "/stderr", decimals);
  return cells;
}

/// A cell of words as HTML, in which no formula is broken over two lines.
void keep_formulae_whole(Json& cell) {
  cell["html"] = unbroken_formulae(clean_text(cell.at("text").get<std::string>()));
}

}  // namespace

Json verdict_cell(const Json& summary, const std::string& claim_id) {
  const Json& claims = summary.at("claims");
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].at("id") != claim_id) continue;
    Json verdict = number_cell(summary, fmt::format("/claims/{}/verdict", i));
    const auto word = claims[i].at("verdict").get<std::string>();
    verdict["reproduced"] = word == "reproduced";
    verdict["not_reproduced"] = word == "not reproduced";
    verdict["undetermined"] = word != "reproduced" && word != "not reproduced";
    return verdict;
  }
  return Json::object();
}

Json claims_view(const Json& summary) {
  Json rows = Json::array();
  const Json& claims = summary.at("claims");
  for (std::size_t i = 0; i < claims.size(); ++i) {
    const std::string pointer = fmt::format("/claims/{}", i);
    Json row;
    for (const char* name : {"id", "statement", "explanation", "quantity"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    for (const char* name : {"statement", "explanation"}) keep_formulae_whole(row[name]);
    // Empty where there is nothing to show.
    const auto optional = [&](const char* name, const Json& cell) {
      const Json& value = claims[i].at(name);
      const bool nothing = value.is_null() || (value.is_string() && value.get_ref<const std::string&>().empty());
      row[name] = nothing ? Json::object() : cell;
    };
    optional("remarks", number_cell(summary, pointer + "/remarks"));
    if (!row["remarks"].empty()) keep_formulae_whole(row["remarks"]);
    optional("paper", number_cell(summary, pointer + "/paper"));
    optional("z_score", fixed_cell(summary, pointer + "/z_score", 1));
    row["verdict"] = verdict_cell(summary, claims[i].at("id"));
    row["measured"] = claims[i].at("measured").is_null() ? Json::object() : measured_cells(summary, pointer);
    row["in_doubt"] = claims[i].at("verdict") != "reproduced";
    // As an anchor: claim ids are plain words with hyphens.
    row["anchor"] = "claim-" + claims[i].at("id").get<std::string>();
    row["differs"] = claims[i].at("expected").is_string() && claims[i].at("expected") != claims[i].at("verdict");
    row["expected"] = row["differs"] == true ? number_cell(summary, pointer + "/expected") : Json::object();
    row["reason"] = claims[i].contains("reason") && claims[i].at("measured").is_null()
                        ? number_cell(summary, pointer + "/reason")
                        : Json::object();
    rows.push_back(row);
  }
  return rows;
}

Json claim_counts(const Json& summary) {
  int reproduced = 0, not_reproduced = 0, undetermined = 0, unmeasured = 0;
  for (const Json& claim : summary.at("claims")) {
    const auto& verdict = claim.at("verdict");
    ++(verdict == "reproduced" ? reproduced : verdict == "not reproduced" ? not_reproduced : undetermined);
    if (verdict == "undetermined" && claim.at("measured").is_null()) ++unmeasured;
  }
  Json counts;
  counts["all"] = std::to_string(summary.at("claims").size());
  counts["reproduced"] = std::to_string(reproduced);
  counts["not_reproduced"] = std::to_string(not_reproduced);
  counts["undetermined"] = std::to_string(undetermined);
  counts["unmeasured"] = std::to_string(unmeasured);
  counts["some_unmeasured"] = unmeasured > 0;
  return counts;
}

}  // namespace granuscope
