#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "plot/figure_captions.h"
#include "report/number_text.h"
#include "report/reason_notes.h"
#include "report/report_overlay.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Whether c or D is unknown for the same reason, which then stands below their table already.
bool told_with_slopes(const Json& result, const Json& estimate) {
  if (!estimate.contains("reason")) return false;
  const auto tells = [&](const char* slope) {
    return result.at(slope).contains("reason") && result.at(slope).at("reason") == estimate.at("reason");
  };
  return tells("c") || tells("D");
}

}  // namespace

void add_laws(Json& overlay, const Json& summary) {
  Json notes = Json::array();
  std::vector<std::string> told;
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].at("exact") == true) continue;
    const std::string at = at_scanned(summary, i);
    for (const char* name : {"position", "width_squared", "amplitude", "noise"}) {
      if (told_with_slopes(results[i], results[i].at("exponents").at(name))) {
        const std::string value = at.substr(at.find("= ") + 2);
        if (told.empty() || told.back() != value) told.push_back(value);
      } else {
        add_reason(notes, summary, fmt::format("/results/{}/exponents/{}", i, name), "", "at " + at);
      }
    }
  }
  finish_notes(notes);
  overlay["law_notes"] = notes;
  overlay["told"] = enumeration(told);
}

}  // namespace granuscope
