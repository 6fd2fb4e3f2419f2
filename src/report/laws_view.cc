#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plot/figure_words.h"
#include "report/number_text.h"
#include "report/reason_notes.h"
#include "report/report_view.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// "24.3 / 36" as cells; an empty object where the line was not tested.
Json line_cells(const Json& summary, const std::string& pointer) {
  const Json& line = summary.at(Json::json_pointer(pointer));
  if (!line.at("chi2").is_number()) return Json::object();
  Json cells;
  cells["chi2"] = fixed_cell(summary, pointer + "/chi2", 1);
  cells["degrees_of_freedom"] = number_cell(summary, pointer + "/degrees_of_freedom");
  return cells;
}

/// Whether c or D is unknown for the same reason, which then stands below their table already.
bool told_with_slopes(const Json& result, const Json& estimate) {
  if (!estimate.contains("reason")) return false;
  const auto tells = [&](const char* slope) {
    return result.at(slope).contains("reason") && result.at(slope).at("reason") == estimate.at("reason");
  };
  return tells("c") || tells("D");
}

}  // namespace

Json laws_view(const Json& summary) {
  Json rows = Json::array(), notes = Json::array();
  std::vector<std::string> told;
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].at("exact") == true) continue;
    const std::string pointer = fmt::format("/results/{}", i);
    Json row;
    row["mu"] = number_cell(summary, pointer + "/mu");
    for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
      row[name] = number_cell(summary, fmt::format("{}/exponents/{}", pointer, name));
      const std::string mu = row["mu"]["text"].get<std::string>();
      if (told_with_slopes(results[i], results[i].at("exponents").at(name))) {
        if (told.empty() || told.back() != mu) told.push_back(mu);
      } else {
        add_reason(notes, summary, fmt::format("{}/exponents/{}", pointer, name), "", "at μ = " + mu);
      }
    }
    row["position_line"] = line_cells(summary, pointer + "/position_line");
    row["width_line"] = line_cells(summary, pointer + "/width_line");
    rows.push_back(row);
  }
  Json view;
  view["laws"] = rows;
  view["has_laws"] = !rows.empty();
  finish_notes(notes);
  view["law_notes"] = notes;
  view["some_told"] = !told.empty();
  view["told_mus"] = enumeration(told);
  for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
    view["mean_laws"][name] = number_cell(summary, fmt::format("/mean_exponents/{}", name));
  }
  return view;
}

}  // namespace granuscope
