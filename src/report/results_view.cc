#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/reason_notes.h"
#include "report/report_view.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Whether all rows agree in a column, and there is one.
bool all_equal(const Json& results, const char* column) {
  for (const Json& result : results) {
    if (result.at(column) != results[0].at(column)) return false;
  }
  return !results.empty();
}

/// What stands in the second bracket of 0.0792(41)(12): the systematic error in units of the value's last digit, one at
/// least, or written out where the statistical one is: 123.4(5.6)(1.2). Empty for a value with a power of ten.
std::string in_last_digits(double value, double error, double systematic) {
  const std::string text = value_with_error(value, error);
  const std::size_t bracket = text.find('('), point = text.find('.');
  if (bracket == std::string::npos || text.find("×") != std::string::npos) return "";
  const std::size_t decimals = point < bracket ? bracket - point - 1 : 0;
  if (text.find('.', bracket) != std::string::npos) return fmt::format("{:.{}f}", systematic, decimals);
  const double units = systematic * std::pow(10, static_cast<double>(decimals));
  return fmt::format("{:.0f}", std::max(units, 1.0));
}

/// The systematic error of an estimate as a list of one cell, for a bracket of its own or, where that cannot be, with
/// two significant digits behind a sign; empty where there is none, or none beyond what the scatter accounts for.
Json systematic_cells(const Json& summary, const std::string& estimate) {
  Json cells = Json::array();
  const std::string pointer = estimate + "/systematic";
  if (!summary.contains(Json::json_pointer(pointer)) || summary.at(Json::json_pointer(pointer)) == 0) return cells;
  const Json& number = summary.at(Json::json_pointer(estimate));
  if (!number.at("value").is_number() || !number.at("stderr").is_number()) return cells;
  const auto systematic = number.at("systematic").get<double>();
  const std::string bracket =
      in_last_digits(number.at("value").get<double>(), number.at("stderr").get<double>(), systematic);
  Json cell = number_cell(summary, pointer);
  cell["text"] = bracket.empty() ? significant(systematic, 2) : bracket;
  cell["bracket"] = !bracket.empty();
  cells.push_back(cell);
  return cells;
}

/// Exact results are exact up to the rounding of the sums they come from: that is no number to show.
void show_rounding_as_zero(Json& cell, const Json& summary, bool exact) {
  constexpr double rounding = 1e-12;
  const Json& value = summary.at(Json::json_pointer(cell.at("key").get<std::string>())).at("value");
  if (exact && value.is_number() && std::abs(value.get<double>()) < rounding) cell["text"] = "0";
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
    row["first"] = rows.empty();
    row["layers"] = Json::object();
    if (neighbours[i].contains("window_layers")) {
      row["layers"] = {{"first_layer", number_cell(summary, pointer + "/window_layers/0")},
                       {"last_layer", number_cell(summary, pointer + "/window_layers/1")}};
    }
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

/// Whether any of the named estimates is known in any entry of a list.
bool any_known(const Json& list, std::initializer_list<const char*> names) {
  for (const Json& entry : list) {
    for (const char* name : names) {
      if (entry.at(name).at("value").is_number()) return true;
    }
  }
  return false;
}

std::string greek(const std::string& name) { return name == "alpha" ? "α" : name == "beta" ? "β" : "γ"; }

Json exponent_view(const Json& summary, const char* name, const char* claim_id, Json& notes) {
  const std::string pointer = fmt::format("/scaling/{}", name);
  Json view;
  view["value"] = number_cell(summary, pointer);
  view["systematic"] = systematic_cells(summary, pointer);
  view["window"] = window_cells(summary, pointer);
  view["points"] = number_cell(summary, pointer + "/points");
  view["chi2"] = Json::array();
  const std::string about_law = pointer + "/about_law";
  if (summary.at(Json::json_pointer(about_law + "/chi2")).is_number()) {
    view["chi2"].push_back(fixed_cell(summary, about_law + "/chi2", 1));
    view["chi2"][0]["degrees"] = number_cell(summary, about_law + "/degrees_of_freedom").at("text");
  }
  view["verdict"] = verdict_cell(summary, claim_id);
  add_reason(notes, summary, pointer, greek(name), "");
  if (summary.at(Json::json_pointer(pointer + "/value")).is_number()) {
    add_reason(notes, summary, about_law, "χ² of " + greek(name), "");
  }
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
      const std::string place = fmt::format(" over μ = {} to {}", row["window"]["low"]["text"].get<std::string>(),
                                            row["window"]["high"]["text"].get<std::string>());
      add_reason(notes, summary, fmt::format("{}/{}", pointer, name), greek(name), place);
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
      add_reason(notes, summary, fmt::format("{}/{}", pointer, name), greek(name),
                 " from ratios at layer " + row["layer"]["text"].get<std::string>());
    }
    rows.push_back(row);
  }
  return rows;
}

/// Where a shift of the window changes c or D by nothing known, the reason, once for all places that share it.
void add_neighbour_reasons(Json& notes, const Json& summary, std::size_t result, const std::string& place) {
  const std::string list = fmt::format("/results/{}/neighbouring_windows", result);
  for (std::size_t i = 0; i < summary.at(Json::json_pointer(list)).size(); ++i) {
    add_reason(notes, summary, fmt::format("{}/{}/c_shift", list, i), "", place);
    add_reason(notes, summary, fmt::format("{}/{}/D_shift", list, i), "", place);
  }
}

Json transport_rows(const Json& summary, bool same_procedure, Json& notes, Json& neighbour_notes) {
  Json rows = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::string pointer = fmt::format("/results/{}", i);
    Json row;
    for (const char* name : {"mu", "samples", "estimator", "law", "c", "D", "alpha_thrust", "c_thrust"}) {
      row[name] = number_cell(summary, fmt::format("{}/{}", pointer, name));
    }
    row["c_minus_c_thrust"] = plain_cell(summary, pointer + "/c_minus_c_thrust");
    for (const char* name : {"D", "c_minus_c_thrust"})
      show_rounding_as_zero(row[name], summary, results[i].at("exact"));
    row["c_systematic"] = systematic_cells(summary, pointer + "/c");
    row["D_systematic"] = systematic_cells(summary, pointer + "/D");
    row["fitted_area"] = plain_cell(summary, pointer + "/fitted_area");
    row["centre_background"] = plain_cell(summary, pointer + "/centre_background");
    row["largest_misfit"] = fixed_cell(summary, pointer + "/largest_misfit", 2);
    row["neighbours"] = neighbour_rows(summary, pointer + "/neighbouring_windows", {"c_shift", "D_shift"});
    row["moves"] = !row["neighbours"].empty();
    row["has_shape"] = results[i].at("fitted_area").at("value").is_number();
    row["window"] = {{"first", number_cell(summary, pointer + "/window_layers/0")},
                     {"last", number_cell(summary, pointer + "/window_layers/1")}};
    row["own_procedure"] = !same_procedure;
    const bool multiplexed = results[i].at("estimator") == "multiplexed";
    row["row_epsilon"] = Json::array();
    if (multiplexed) row["row_epsilon"].push_back(number_cell(summary, pointer + "/epsilon"));
    row["frictionless"] = results[i].at("mu") == 0;
    row["exact"] = results[i].at("exact");
    const std::string at = " at μ = " + row["mu"]["text"].get<std::string>();
    add_reason(notes, summary, pointer + "/c", "c", at);
    add_reason(notes, summary, pointer + "/D", "D", at);
    add_reason(notes, summary, pointer + "/c_thrust", "c from the thrust ratio", at);
    add_neighbour_reasons(neighbour_notes, summary, i, at.substr(1));
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
  Json exponent_notes = Json::array(), transport_notes = Json::array(), neighbour_notes = Json::array();
  view["beta"] = exponent_view(summary, "beta", "D-of-mu", exponent_notes);
  view["gamma"] = exponent_view(summary, "gamma", "c-of-mu", exponent_notes);
  view["alpha"] = exponent_view(summary, "alpha", "c-of-D", exponent_notes);
  view["scaling_neighbours"] =
      neighbour_rows(summary, "/scaling/neighbouring_windows", {"beta_shift", "gamma_shift", "alpha_shift"});
  // A table of unknown numbers alone says no more than the notes, which name them all.
  const Json& scaling = summary.at("scaling");
  view["has_scaling_neighbours"] =
      any_known(scaling.at("neighbouring_windows"), {"beta_shift", "gamma_shift", "alpha_shift"});
  view["other_windows"] = other_windows_view(summary, exponent_notes);
  view["has_other_windows"] = any_known(scaling.at("other_windows"), {"beta", "gamma", "alpha"});
  view["by_ratio"] = by_ratio_view(summary, exponent_notes);
  view["has_by_ratio"] = any_known(scaling.at("by_ratio"), {"beta", "gamma", "alpha"});
  const bool same_procedure = all_equal(results, "estimator") && all_equal(results, "law");
  view["same_procedure"] = Json::array();
  if (same_procedure) {
    Json procedure = {{"estimator", number_cell(summary, "/results/0/estimator")},
                      {"law", number_cell(summary, "/results/0/law")},
                      {"epsilon", Json::array()}};
    if (results[0].at("estimator") == "multiplexed") {
      procedure["epsilon"].push_back(number_cell(summary, "/results/0/epsilon"));
    }
    view["same_procedure"].push_back(procedure);
  }
  view["rest"] = same_procedure ? "4" : "5";  // columns that the row of the paper leaves free
  view["transport"] = transport_rows(summary, same_procedure, transport_notes, neighbour_notes);
  view["has_transport"] = !results.empty();
  view["has_neighbours"] = std::any_of(view["transport"].begin(), view["transport"].end(),
                                       [](const Json& row) { return !row.at("neighbours").empty(); });
  view["has_shapes"] = std::any_of(view["transport"].begin(), view["transport"].end(),
                                   [](const Json& row) { return row.at("has_shape") == true; });
  add_precision(view, summary);
  for (Json* notes : {&exponent_notes, &transport_notes, &neighbour_notes}) finish_notes(*notes);
  view["neighbour_notes"] = neighbour_notes;
  view["exponent_notes"] = exponent_notes;
  view["transport_notes"] = transport_notes;
  for (const char* estimator : {"point", "paired", "multiplexed"}) {
    view[std::string(estimator) + "_estimator"] =
        all_equal(results, "estimator") && results[0].at("estimator") == estimator;
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
