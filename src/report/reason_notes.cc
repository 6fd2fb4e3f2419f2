#include "report/reason_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "sampling/scan_parameter.h"

namespace granuscope {

using Json = nlohmann::ordered_json;

namespace {

/// "a, b and c".
std::string enumerated(const Json& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i].get<std::string>();
  }
  return text;
}

}  // namespace

std::string scanned_in(const Json& summary) {
  const auto scan = summary.find("scan");
  const bool told =
      scan != summary.end() && scan->is_object() && scan->contains("parameter") && scan->at("parameter").is_string();
  return told ? scan->at("parameter").get<std::string>() : friction_parameter().name;
}

std::string place_of_scanned(const Json& summary, std::size_t result) {
  return fmt::format("/results/{}/{}", result, scanned_in(summary));
}

std::string at_scanned(const Json& summary, std::size_t result) {
  return fmt::format("{} = {}", summary.at("scan").at("symbol").get<std::string>(),
                     format_number(summary.at(Json::json_pointer(place_of_scanned(summary, result)))));
}

void add_reason(Json& notes, const Json& summary, const std::string& pointer, const std::string& name,
                const std::string& place) {
  const Json& estimate = summary.at(Json::json_pointer(pointer));
  if (!estimate.contains("reason")) return;
  auto note = std::find_if(notes.begin(), notes.end(),
                           [&](const Json& known) { return known.at("why") == estimate.at("reason"); });
  if (note == notes.end()) {
    notes.push_back(
        {{"why", estimate.at("reason")}, {"reason", {{"key", pointer + "/reason"}}}, {"places", Json::object()}});
    note = std::prev(notes.end());
  }
  Json& names = (*note)["places"][place];
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

void finish_notes(Json& notes) {
  for (Json& note : notes) {
    std::string what;
    std::size_t names = 0;
    for (const auto& [place, named] : note.at("places").items()) {
      what += (what.empty() ? "" : "; ") + enumerated(named) + place;
      names += named.size();
    }
    note.erase("places");
    note["what"] = what;
    note["are"] = names == 1 ? "is" : "are";
  }
}

}  // namespace granuscope
