#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_view.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Values of one column, once if all rows agree (an empty list if there is no row).
bool all_equal(const Json& results, const char* column, const std::string& value) {
  for (const Json& result : results) {
    if (result.at(column) != value) return false;
  }
  return !results.empty();
}

/// Where an estimate is unknown, the reason as a note below the table; those with the same reason share one.
void add_reason(Json& notes, const Json& summary, const std::string& pointer, const std::string& what) {
  const Json& estimate = summary.at(Json::json_pointer(pointer));
  if (!estimate.contains("reason")) return;
  for (Json& known : notes) {
    if (known.at("why") != estimate.at("reason")) continue;
    known["what"] = known.at("what").get<std::string>() + ", " + what;
    known["are"] = "are";
    return;
  }
  Json note;
  note["what"] = what;
  note["are"] = "is";
  note["why"] = estimate.at("reason");
  note["reason"] = number_cell(summary, pointer + "/reason");
  notes.push_back(note);
}

/// The systematic error of an estimate as a list of one cell, with two significant digits; empty where there is none.
Json systematic_cells(const Json& summary, const std::string& estimate) {
  Json cells = Json::array();
  const std::string pointer = estimate + "/systematic";
  if (!summary.contains(Json::json_pointer(pointer))) return cells;
  Json cell = number_cell(summary, pointer);
  cell["text"] = significant(summary.at(Json::json_pointer(pointer)).get<double>(), 2);
  cells.push_back(cell);
  return cells;
}

/// A row for each neighbour of a window. `names`: the estimates shown of each.
Json neighbour_rows(const Json& summary, const std::string& list, std::initializer_list<const char*> names) {
  Json rows = Json::array();
  const Json& neighbours = summary.at(Json::json_pointer(list));
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const std::string pointer = fmt::format("{}/{}", list, i);
    Json row;
    for (const char* change : {"without_shallowest_quarter", "without_deepest_quarter", "longer_above",
                               "without_lowest_mu", "without_highest_mu"}) {
      row[change] = neighbours[i].at("change") == change;
    }
    for (const char* name : names) row[name] = plain_cell(summary, fmt::format("{}/{}", pointer, name));
    rows.push_back(row);
  }
  return rows;
}

Json window_cells(const Json& summary, const std::string& fit) {
  Json window;
  window["low"] = number_cell(summary, fit + "/window/0");
  window["high"] = number_cell(summary, fit + "/window/1");
  return window;
}

std::string greek(const std::string& name) { return name == "alpha" ? "α" : name == "beta" ? "β" : "γ"; }

Json exponent_view(const Json& summary, const char* name, const char* claim_id, Json& notes) {
  const std::string pointer = fmt::format("/scaling/{}", name);
  Json view;
  view["value"] = number_cell(summary, pointer);
  view["systematic"] = systematic_cells(summary, pointer);
  view["window"] = window_cells(summary, pointer);
  view["points"] = number_cell(summary, pointer + "/points");
  view["verdict"] = verdict_cell(summary, claim_id);
  add_reason(notes, summary, pointer, fmt::format("The exponent {}", greek(name)));
  return view;
}

Json other_windows_view(const Json& summary, Json& notes) {
  Json rows = Json::array();
  const Json& windows = summary.at("scaling").at("other_windows");
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const std::string pointer = fmt::format("/scaling/other_windows/{}", i);
    Json row;
    row["window"] = window_cells(summary, pointer + "/beta");
    for (const char* name : {"beta", "gamma", "alpha"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
      const std::string what =
          fmt::format("The exponent {} over μ = {} to {}", greek(name), row["window"]["low"]["text"].get<std::string>(),
                      row["window"]["high"]["text"].get<std::string>());
      add_reason(notes, summary, fmt::format("{}/{}", pointer, name), what);
    }
    rows.push_back(row);
  }
  return rows;
}

Json by_ratio_view(const Json& summary, Json& notes) {
  Json rows = Json::array();
  const Json& depths = summary.at("scaling").at("by_ratio");
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const std::string pointer = fmt::format("/scaling/by_ratio/{}", i);
    Json row;
    for (const char* name : {"layer", "z", "beta", "gamma", "alpha"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    for (const char* name : {"beta", "gamma", "alpha"}) {
      add_reason(
          notes, summary, fmt::format("{}/{}", pointer, name),
          fmt::format("The exponent {} from ratios at layer {}", greek(name), row["layer"]["text"].get<std::string>()));
    }
    rows.push_back(row);
  }
  return rows;
}

Json transport_rows(const Json& summary, Json& notes) {
  Json rows = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::string pointer = fmt::format("/results/{}", i);
    Json row;
    for (const char* name : {"mu", "samples", "estimator", "law", "c", "D", "alpha_thrust", "c_thrust"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    row["c_systematic"] = systematic_cells(summary, pointer + "/c");
    row["D_systematic"] = systematic_cells(summary, pointer + "/D");
    row["fitted_area"] = plain_cell(summary, pointer + "/fitted_area");
    row["centre_background"] = plain_cell(summary, pointer + "/centre_background");
    row["largest_misfit"] = fixed_cell(summary, pointer + "/largest_misfit", 2);
    row["neighbours"] = neighbour_rows(summary, pointer + "/neighbouring_windows", {"c_shift", "D_shift"});
    row["has_neighbours"] = !row["neighbours"].empty();
    const bool multiplexed = results[i].at("estimator") == "multiplexed";
    row["row_epsilon"] = Json::array();
    if (multiplexed) row["row_epsilon"].push_back(number_cell(summary, pointer + "/epsilon"));
    row["c_minus_c_thrust"] = plain_cell(summary, pointer + "/c_minus_c_thrust");
    row["frictionless"] = results[i].at("mu") == 0;
    row["exact"] = results[i].at("exact");
    const std::string at = " at μ = " + row["mu"]["text"].get<std::string>();
    add_reason(notes, summary, pointer + "/c", "c" + at);
    add_reason(notes, summary, pointer + "/D", "D" + at);
    add_reason(notes, summary, pointer + "/c_thrust", "c from the thrust ratio" + at);
    rows.push_back(row);
  }
  return rows;
}

/// How precise the ensembles were to become, and where they did not: one sentence each.
void add_precision(Json& view, const Json& summary) {
  view["precision"] = Json::array();
  view["imprecise"] = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!results[i].contains("precision")) continue;
    const std::string pointer = fmt::format("/results/{}/precision", i);
    if (view["precision"].empty()) {
      Json asked;
      for (const char* name : {"c", "D"}) {
        asked[std::string("for_") + name] = Json::array();
        if (results[i].at("precision").at(name).is_null()) continue;
        asked[std::string("for_") + name].push_back(number_cell(summary, fmt::format("{}/{}", pointer, name)));
      }
      view["precision"].push_back(asked);
    }
    if (results[i].at("precision").at("reached") == true) continue;
    view["imprecise"].push_back({{"at_mu", number_cell(summary, fmt::format("/results/{}/mu", i))},
                                 {"reason", number_cell(summary, pointer + "/reason")}});
  }
}

}  // namespace

Json results_view(const Json& summary) {
  Json view;
  const Json& results = summary.at("results");
  Json exponent_notes = Json::array(), transport_notes = Json::array();
  view["beta"] = exponent_view(summary, "beta", "D-of-mu", exponent_notes);
  view["gamma"] = exponent_view(summary, "gamma", "c-of-mu", exponent_notes);
  view["alpha"] = exponent_view(summary, "alpha", "c-of-D", exponent_notes);
  view["scaling_neighbours"] =
      neighbour_rows(summary, "/scaling/neighbouring_windows", {"beta_shift", "gamma_shift", "alpha_shift"});
  view["has_scaling_neighbours"] = !view["scaling_neighbours"].empty();
  view["other_windows"] = other_windows_view(summary, exponent_notes);
  view["has_other_windows"] = !view["other_windows"].empty();
  view["by_ratio"] = by_ratio_view(summary, exponent_notes);
  view["has_by_ratio"] = !view["by_ratio"].empty();
  view["transport"] = transport_rows(summary, transport_notes);
  view["has_transport"] = !results.empty();
  add_precision(view, summary);
  view["exponent_notes"] = exponent_notes;
  view["transport_notes"] = transport_notes;
  for (const char* estimator : {"point", "paired", "multiplexed"}) {
    view[std::string(estimator) + "_estimator"] = all_equal(results, "estimator", estimator);
  }
  view["epsilon"] = Json::array();
  view["sign_run"] = Json::array();
  view["opposite"] = false;
  if (view["multiplexed_estimator"] == true) {
    view["epsilon"].push_back(number_cell(summary, "/results/0/epsilon"));
    view["opposite"] = results[0].at("opposite");
    if (results[0].at("sign_run") > 1) view["sign_run"].push_back(number_cell(summary, "/results/0/sign_run"));
  }
  return view;
}

}  // namespace granuscope
