#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "report/number_text.h"
#include "report/report_view.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// What the law is called in a row: its name, the exponent of a chain, the rules left out.
Json name_cells(const Json& summary, const Json& one, const std::string& pointer) {
  Json name;
  name["law"] = number_cell(summary, pointer + "/law");
  name["with_lambda"] = Json::array();
  name["with_rules"] = Json::array();
  if (one.contains("lambda")) name["with_lambda"].push_back(number_cell(summary, pointer + "/lambda"));
  if (one.contains("mending_rules") && one.at("mending_rules") != "all") {
    name["with_rules"].push_back(number_cell(summary, pointer + "/mending_rules"));
  }
  return name;
}

/// Burn-in and thinning, where the law has them.
Json chain_cells(const Json& summary, const Json& one, const std::string& pointer) {
  Json chain = Json::array();
  if (!one.contains("burn_in")) return chain;
  chain.push_back({{"burn_in", number_cell(summary, pointer + "/burn_in")},
                   {"thinning", number_cell(summary, pointer + "/thinning")}});
  return chain;
}

bool same_size(const Json& one, const Json& other) {
  return one.at("columns") == other.at("columns") && one.at("layers") == other.at("layers");
}

/// Nanoseconds of wall time for each bead of the piles begun; no part of summary.json, which holds no times.
std::string time_per_bead(const ReportData& data, std::size_t i) {
  const LawOnPiles& one = data.analysis.side.laws[i];
  const double piles = static_cast<double>(one.samples + one.failed);
  if (i >= data.law_seconds.size() || !std::isfinite(data.law_seconds[i]) || piles == 0) return "not known";
  return significant(1e9 * data.law_seconds[i] / (piles * one.columns * one.layers), 2);
}

/// By how many standard errors of their difference a number lies from that of the first law.
std::string sigmas_from_first(const Json& one, const Json& first) {
  if (!one.at("value").is_number() || !first.at("value").is_number()) return "n/a";
  const double error = std::hypot(one.at("stderr").get<double>(), first.at("stderr").get<double>());
  const double difference = std::abs(one.at("value").get<double>() - first.at("value").get<double>());
  return error > 0 ? fmt::format("{:.1f}", difference / error) : "n/a";
}

/// To five standard errors: whether alpha is below 1, and moves over the bulk by less than its distance from 1.
bool settles_below_one(const Json& one) {
  constexpr double sure = 5;
  const Json &alpha = one.at("alpha_thrust"), &change = one.at("change_with_depth");
  if (!alpha.at("value").is_number() || !change.at("value").is_number()) return false;
  const double distance = 1 - alpha.at("value").get<double>();
  return distance > sure * alpha.at("stderr").get<double>() &&
         std::abs(change.at("value").get<double>()) + sure * change.at("stderr").get<double>() < distance;
}

/// The thrust of the law rejection in the bulk, and whether it settles below 1 wherever it was measured.
void add_exact_thrusts(const Json& summary, Json& view) {
  Json rows = Json::array();
  bool below_one = true;
  double last_mu = 0;
  const Json& measured = summary.at("side").at("exact_thrusts");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const std::string pointer = fmt::format("/side/exact_thrusts/{}", i);
    Json row;
    const double mu = measured[i].at("mu").get<double>();
    row["first"] = i > 0 && mu != last_mu;
    last_mu = mu;
    for (const char* number : {"mu", "columns", "layers", "samples"}) {
      row[number] = number_cell(summary, fmt::format("{}/{}", pointer, number));
    }
    row["from"] = number_cell(summary, pointer + "/bulk_layers/0");
    row["to"] = number_cell(summary, pointer + "/bulk_layers/1");
    for (const char* number : {"alpha_thrust", "deficit_over_mu_squared", "change_with_depth", "alpha_of_last_layer"}) {
      row[number] = plain_cell(summary, fmt::format("{}/{}", pointer, number));
    }
    rows.push_back(row);
    below_one = below_one && settles_below_one(measured[i]);
  }
  view["has_exact_thrusts"] = !rows.empty();
  view["exact_thrusts"] = rows;
  view["exact_below_one"] = below_one;
}

}  // namespace

Json law_comparison_view(const Json& summary, const ReportData& data) {
  Json view, piles = Json::array(), rules = Json::array(), responses = Json::array(), notes = Json::array();
  const Json& laws = summary.at("side").at("laws");
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Json& one = laws[i];
    const std::string pointer = fmt::format("/side/laws/{}", i);
    Json row;
    row["name"] = name_cells(summary, one, pointer);
    row["some_failed"] = Json::array();
    if (one.at("failed") != 0) row["some_failed"].push_back(number_cell(summary, pointer + "/failed"));
    row["first"] = i > 0 && !same_size(one, laws[i - 1]);
    row["chain"] = chain_cells(summary, one, pointer);
    for (const char* number : {"columns", "layers", "samples", "failed", "draws_per_bead"}) {
      row[number] = number_cell(summary, fmt::format("{}/{}", pointer, number));
    }
    for (const char* number : {"alpha_thrust", "weight_variance", "c_thrust"}) {
      row[number] = plain_cell(summary, fmt::format("{}/{}", pointer, number));
    }
    row["effective_samples"] = fixed_cell(summary, pointer + "/effective_samples/value", 0);
    row["time_per_bead"] = time_per_bead(data, i);
    if (one.contains("mending_rules") && same_size(one, laws[0])) {
      Json rule = row;
      for (const char* share : {"pair_per_bead", "arc_per_bead", "climbed_per_bead"}) {
        rule[share] = fixed_cell(summary, fmt::format("{}/{}", pointer, share), 4);
      }
      rules.push_back(rule);
    }
    piles.push_back(row);
  }
  const Json& measured = summary.at("side").at("law_responses");
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const Json& one = measured[i];
    const std::string pointer = fmt::format("/side/law_responses/{}", i);
    Json row;
    row["name"] = name_cells(summary, one, pointer);
    row["chain"] = chain_cells(summary, one, pointer);
    row["samples"] = number_cell(summary, pointer + "/samples");
    for (const char* number : {"c", "D"}) row[number] = plain_cell(summary, fmt::format("{}/{}", pointer, number));
    row["effective_samples"] = fixed_cell(summary, pointer + "/effective_samples/value", 0);
    row["later"] = Json::array();
    if (i > 0) {
      row["later"].push_back({{"c_sigmas", sigmas_from_first(one.at("c"), measured[0].at("c"))},
                              {"D_sigmas", sigmas_from_first(one.at("D"), measured[0].at("D"))}});
    }
    if (one.at("c").contains("reason")) {
      notes.push_back({{"name", row["name"]}, {"reason", number_cell(summary, pointer + "/c/reason")}});
    }
    responses.push_back(row);
  }
  Json* last_chain = nullptr;
  for (Json& row : piles) {
    for (Json& chain : row["chain"]) {
      chain["last_chain"] = false;
      last_chain = &chain;
    }
  }
  if (last_chain != nullptr) (*last_chain)["last_chain"] = true;
  view["has_law_comparison"] = !piles.empty();
  view["law_piles"] = piles;
  view["law_rules"] = rules;
  view["law_responses"] = responses;
  view["law_response_notes"] = notes;
  add_exact_thrusts(summary, view);
  view["has_law_responses"] = !responses.empty();
  if (!piles.empty()) view["laws_mu"] = number_cell(summary, "/side/laws/0/mu");
  if (!responses.empty()) {
    for (const char* number : {"columns", "layers", "epsilon"}) {
      view["law_response"][number] = number_cell(summary, fmt::format("/side/law_responses/0/{}", number));
    }
    view["law_response"]["first_layer"] = number_cell(summary, "/side/law_responses/0/window_layers/0");
    view["law_response"]["last_layer"] = number_cell(summary, "/side/law_responses/0/window_layers/1");
  }
  return view;
}

}  // namespace granuscope
