#include "overlay.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/reason_notes.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// The wording of a load.
Json load_flags(const Json& one) {
  return {{"one_bead", one.at("estimator") == "point"}, {"all_beads", one.at("estimator") == "multiplexed"}};
}

bool is_the_papers(const Json& one) { return one.at("estimator") == "point" && one.at("load") == 1; }

/// Notes why there is no `estimate` of one load: "exponents with overload 4".
void add_load_reason(Json& notes, const Json& summary, const Json& one, const std::string& estimate,
                     const std::string& what, const std::string& place) {
  const std::string load = format_number(one.at("load"));
  add_reason(notes, summary, estimate, what + (one.at("estimator") == "point" ? "overload " : "ε = ") + load, place);
}

}  // namespace

Json load_overlay(const Json& summary, const std::string& base) {
  Json overlay, notes = Json::array();
  for (const char* list : {"responses", "exponents", "paper_load", "paper_load_exponents"}) {
    overlay[list] = Json::array();
  }
  const Json& measured = summary.at(Json::json_pointer(base));
  for (std::size_t i = 0; i < measured.at("responses").size(); ++i) {
    const Json& one = measured.at("responses")[i];
    const std::string pointer = fmt::format("{}/responses/{}", base, i);
    const bool uniform = one.at("estimator") == "uniform";  // it is what the last column compares with
    Json row = load_flags(one);
    row["uniform"] = uniform;
    row["own_window_told"] = one.at("own_window") == true && !uniform;
    overlay["responses"].push_back(row);
    if (uniform) continue;
    add_load_reason(notes, summary, one, pointer + "/D", "", " at μ = " + format_number(one.at("mu")));
    // The paper's load at the smallest friction where it can be told.
    if (is_the_papers(one) && overlay["paper_load"].empty() && !one.at("D_over_linear_minus_1").at("value").is_null()) {
      overlay["paper_load"].push_back({{"key", pointer}});
    }
  }
  for (std::size_t i = 0; i < measured.at("exponents").size(); ++i) {
    const Json& one = measured.at("exponents")[i];
    const std::string pointer = fmt::format("{}/exponents/{}", base, i);
    overlay["exponents"].push_back(load_flags(one));
    add_load_reason(notes, summary, one, pointer + "/beta", "the exponents with ", "");
    if (!is_the_papers(one)) continue;
    overlay["paper_load_exponents"] = Json::array();
    if (!one.at("beta_minus_linear").at("value").is_null() && !one.at("gamma_minus_linear").at("value").is_null()) {
      overlay["paper_load_exponents"].push_back({{"key", pointer}});
    }
  }
  finish_notes(notes);
  overlay["notes"] = notes;
  return overlay;
}

}  // namespace granuscope
