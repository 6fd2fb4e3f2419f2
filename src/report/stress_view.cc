#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_view.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

Json stress_view(const Json& summary) {
  Json view, rows = Json::array();
  const Json& trials = summary.at("side").at("stress");
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const std::string pointer = fmt::format("/side/stress/{}", i);
    const bool solved = trials[i].at("outcome") == "solved";
    Json row;
    for (const char* name : {"mu", "columns", "layers", "load", "outcome"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    row["solved"] = solved;
    for (const char* name : {"residual", "rounded_per_bead"}) {
      row[name] = solved ? number_cell(summary, fmt::format("{}/{}", pointer, name)) : Json::object();
    }
    if (solved) row["residual"]["text"] = significant(trials[i].at("residual").get<double>(), 2);
    rows.push_back(row);
  }
  view["stress_rows"] = rows;
  view["has_stress_rows"] = !rows.empty();
  return view;
}

}  // namespace granuscope
