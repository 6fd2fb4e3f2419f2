#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/reason_notes.h"
#include "report/report_view.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Which of the table's rows it is: a flag for the wording of the load, and its size.
void name_load(Json& row, const Json& one, const Json& summary, const std::string& pointer) {
  for (const char* estimator : {"point", "multiplexed"}) row[estimator] = one.at("estimator") == estimator;
  row["reference"] = one.at("reference");
  row["load"] = number_cell(summary, pointer + "/load");
}

/// Fills `what` of a sentence with the cells of a shift, if it is known.
Json shift_cells(const Json& summary, const std::string& pointer, const char* value, const char* shift) {
  Json cells = Json::object();
  if (summary.at(Json::json_pointer(pointer + "/" + shift + "/value")).is_null()) return cells;
  cells["value"] = plain_cell(summary, pointer + "/" + value);
  cells["shift"] = plain_cell(summary, pointer + "/" + shift);
  return cells;
}

}  // namespace

Json loads_view(const Json& summary) {
  Json view, rows = Json::array(), exponents = Json::array(), notes = Json::array(), own = Json::array();
  const Json& measured = summary.at("side").at("nonlinearity");
  Json sentence = Json::object(), exponent_sentence = Json::object();
  for (std::size_t i = 0; i < measured.at("responses").size(); ++i) {
    const Json& one = measured.at("responses")[i];
    const std::string pointer = fmt::format("/side/nonlinearity/responses/{}", i);
    if (one.at("estimator") == "uniform") continue;  // it is what the last column compares with
    Json row;
    name_load(row, one, summary, pointer);
    row["next_group"] = !rows.empty() && measured.at("responses")[i - 1].at("mu") != one.at("mu");
    row["first"] = rows.empty() || measured.at("responses")[i - 1].at("mu") != one.at("mu");
    row["mu"] = number_cell(summary, pointer + "/mu");
    row["samples"] = number_cell(summary, pointer + "/samples");
    for (const char* name : {"c", "D", "c_minus_linear", "D_over_linear_minus_1", "c_thrust_minus_uniform"}) {
      row[name] = plain_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    if (one.at("own_window") == true) {
      own.push_back({{"load", row["load"]},
                     {"mu", row["mu"]},
                     {"first", number_cell(summary, pointer + "/window_layers/0")},
                     {"last", number_cell(summary, pointer + "/window_layers/1")}});
    }
    if (one.at("D").contains("reason")) {
      const std::string load = row["load"]["text"].get<std::string>();
      add_reason(notes, summary, pointer + "/D", (one.at("estimator") == "point" ? "overload " : "ε = ") + load,
                 " at μ = " + row["mu"]["text"].get<std::string>());
    }
    // The paper's load at the smallest friction where it can be told.
    if (one.at("estimator") == "point" && one.at("load") == 1 && sentence.empty()) {
      const Json D = shift_cells(summary, pointer, "D", "D_over_linear_minus_1");
      if (!D.empty()) {
        sentence["mu"] = row["mu"];
        sentence["D"] = D;
        sentence["c"] = shift_cells(summary, pointer, "c", "c_minus_linear");
      }
    }
    rows.push_back(row);
  }
  for (std::size_t i = 0; i < measured.at("exponents").size(); ++i) {
    const Json& one = measured.at("exponents")[i];
    const std::string pointer = fmt::format("/side/nonlinearity/exponents/{}", i);
    Json row;
    name_load(row, one, summary, pointer);
    row["window"] = {{"low", number_cell(summary, pointer + "/window/0")},
                     {"high", number_cell(summary, pointer + "/window/1")}};
    row["points"] = number_cell(summary, pointer + "/points");
    for (const char* name : {"beta", "gamma", "beta_minus_linear", "gamma_minus_linear"}) {
      row[name] = plain_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    if (one.at("estimator") == "point" && one.at("load") == 1) {
      exponent_sentence["beta"] = shift_cells(summary, pointer, "beta", "beta_minus_linear");
      exponent_sentence["gamma"] = shift_cells(summary, pointer, "gamma", "gamma_minus_linear");
      if (exponent_sentence["beta"].empty() || exponent_sentence["gamma"].empty())
        exponent_sentence = Json::object();
      else
        exponent_sentence["window"] = row["window"];
    }
    if (one.at("beta").contains("reason")) {
      const std::string load = row["load"]["text"].get<std::string>();
      add_reason(notes, summary, pointer + "/beta",
                 (one.at("estimator") == "point" ? "the exponents with overload " : "the exponents with ε = ") + load,
                 "");
    }
    exponents.push_back(row);
  }
  view["load_rows"] = rows;
  view["has_load_rows"] = !rows.empty();
  view["load_exponents"] = exponents;
  finish_notes(notes);
  view["load_notes"] = notes;
  view["own_windows"] = own;
  view["paper_load"] = sentence.empty() ? Json::array() : Json::array({sentence});
  view["paper_load_exponents"] = exponent_sentence.empty() ? Json::array() : Json::array({exponent_sentence});
  return view;
}

}  // namespace granuscope
