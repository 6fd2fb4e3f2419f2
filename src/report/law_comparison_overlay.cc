#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/study_overlays.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Whether a law leaves out some of its rules.
bool some_rules(const Json& one) { return one.contains("mending_rules") && one.at("mending_rules") != "all"; }

/// Nanoseconds of wall time for each bead of the piles begun; no part of summary.json, which holds no times.
std::string time_per_bead(const ReportData& data, std::size_t i) {
  const LawOnPiles& one = data.side.laws[i];
  const double piles = static_cast<double>(one.samples + one.failed);
  if (i >= data.law_seconds.size() || !std::isfinite(data.law_seconds[i]) || piles == 0) return "not known";
  return significant(1e9 * data.law_seconds[i] / (piles * one.spec.lattice.columns * one.spec.lattice.layers), 2);
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

}  // namespace

Json law_comparison_overlay(const Json& summary, const ReportData& data) {
  const Json& laws = summary.at("side").at("laws");
  Json rows = Json::array(), chains = Json::array();
  for (std::size_t i = 0; i < laws.size(); ++i) {
    rows.push_back({{"some_rules", some_rules(laws[i])}, {"time_per_bead", time_per_bead(data, i)}});
    if (laws[i].contains("burn_in")) chains.push_back({{"key", fmt::format("/side/laws/{}", i)}, {"last", false}});
  }
  if (!chains.empty()) chains.back()["last"] = true;
  return {{"laws", rows}, {"chains", chains}};
}

Json rejection_thrust_overlay(const Json& summary) {
  bool below_one = true;
  for (const Json& one : summary.at("side").at("exact_thrusts")) below_one = below_one && settles_below_one(one);
  return {{"exact_below_one", below_one}};
}

Json law_responses_overlay(const Json& summary) {
  const Json& responses = summary.at("side").at("law_responses");
  Json rows = Json::array();
  for (std::size_t i = 0; i < responses.size(); ++i) {
    Json row = {{"some_rules", some_rules(responses[i])}};
    for (const char* name : {"c", "D"}) {
      row[std::string(name) + "_apart"] =
          i == 0 ? "–" : sigmas_from_first(responses[i].at(name), responses[0].at(name));
    }
    rows.push_back(row);
  }
  return {{"law_responses", rows}};
}

Json law_rules_overlay(const Json& summary) {
  const Json& laws = summary.at("side").at("laws");
  Json rules = Json::array();
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Json& one = laws[i];
    const bool as_the_first = one.at("columns") == laws[0].at("columns") && one.at("layers") == laws[0].at("layers");
    if (!one.contains("mending_rules") || !as_the_first) continue;
    rules.push_back({{"key", fmt::format("/side/laws/{}", i)}, {"some_rules", some_rules(one)}});
  }
  return {{"rules", rules}};
}

}  // namespace granuscope
