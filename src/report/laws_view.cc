#include <fmt/format.h>

#include <nlohmann/json.hpp>

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

}  // namespace

Json laws_view(const Json& summary) {
  Json rows = Json::array(), notes = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].at("exact") == true) continue;
    const std::string pointer = fmt::format("/results/{}", i);
    Json row;
    row["mu"] = number_cell(summary, pointer + "/mu");
    for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
      row[name] = number_cell(summary, fmt::format("{}/exponents/{}", pointer, name));
      add_reason(notes, summary, fmt::format("{}/exponents/{}", pointer, name), "",
                 "at μ = " + row["mu"]["text"].get<std::string>());
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
  for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
    view["mean_laws"][name] = number_cell(summary, fmt::format("/mean_exponents/{}", name));
  }
  return view;
}

}  // namespace granuscope
