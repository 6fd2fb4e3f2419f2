#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_view.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

Json redrawn_rows(const Json& summary) {
  Json rows = Json::array();
  const Json& measured = summary.at("side").at("redrawn_beads");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const std::string pointer = fmt::format("/side/redrawn_beads/{}", i);
    Json row;
    for (const char* name : {"mu", "columns", "layers", "samples", "failed"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    row["whole_pile"] = plain_cell(summary, pointer + "/whole_pile");
    row["below_overload"] = plain_cell(summary, pointer + "/below_overload");
    rows.push_back(row);
  }
  return rows;
}

Json chain_rows(const Json& summary) {
  Json rows = Json::array();
  const Json& measured = summary.at("side").at("chain_share");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const std::string pointer = fmt::format("/side/chain_share/{}", i);
    Json row;
    for (const char* name : {"mu", "columns", "layers", "samples", "half_width", "c", "share"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    row["even_share"] = fixed_cell(summary, pointer + "/even_share", 2);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

Json side_view(const Json& summary) {
  Json view;
  view["redrawn_beads"] = redrawn_rows(summary);
  view["has_redrawn_beads"] = !view["redrawn_beads"].empty();
  view["chain_share"] = chain_rows(summary);
  view["has_chain_share"] = !view["chain_share"].empty();
  view["has_side"] = view["has_redrawn_beads"] == true || view["has_chain_share"] == true;
  return view;
}

}  // namespace granuscope
