#include "json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "report/estimate_json.h"
#include "studies/study.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

/// Which law, and how its chains ran.
template <class Measured>
Json law_json(const Measured& one) {
  const SamplerSpec& sampler = one.spec.sampler;
  Json json = {{"law", name_of(sampler.law)}};
  if (sampler.law == Law::granusolve) json["repair_rules"] = name_of(sampler.rules);
  if (sampler.law != Law::polytope) return json;
  json["lambda"] = sampler.lambda;
  json["burn_in"] = finite_or_null(one.burn_in);
  json["thinning"] = finite_or_null(one.thinning);
  if (json["burn_in"].is_null()) json["reason"] = "no chain was begun";
  return json;
}

Json to_json(const LawResponse& one) {
  Json json = law_json(one);
  json.update(Json{{"mu", one.spec.sampler.mu},
                   {"columns", one.spec.lattice.columns},
                   {"layers", one.spec.lattice.layers},
                   {"epsilon", one.spec.response.epsilon},
                   {"samples", one.samples},
                   {"failed", one.failed},
                   {"effective_samples", granuscope::to_json(one.effective_samples)},
                   {"window_layers", {one.first_layer, one.last_layer}},
                   {"c", granuscope::to_json(one.c)},
                   {"D", granuscope::to_json(one.D)}});
  return json;
}

Json to_json(const LawOnPiles& one) {
  Json depths = Json::array();
  for (const ThrustAtDepth& depth : one.depths) depths.push_back(granuscope::to_json(depth));
  Json json = law_json(one);
  json.update(Json{{"mu", one.spec.sampler.mu},
                   {"columns", one.spec.lattice.columns},
                   {"layers", one.spec.lattice.layers},
                   {"samples", one.samples},
                   {"failed", one.failed},
                   {"effective_samples", granuscope::to_json(one.effective_samples)},
                   {"draws_per_bead", finite_or_null(one.draws_per_bead)},
                   {"pair_per_bead", finite_or_null(one.pair_per_bead)},
                   {"arc_per_bead", finite_or_null(one.arc_per_bead)},
                   {"backtracked_per_bead", finite_or_null(one.backtracked_per_bead)},
                   {"window_layers", {one.first_layer, one.last_layer}},
                   {"alpha_thrust", granuscope::to_json(one.alpha_thrust)},
                   {"c_thrust", granuscope::to_json(one.c_thrust)},
                   {"weight_variance", granuscope::to_json(one.weight_variance)},
                   {"depths", depths}});
  if (json["draws_per_bead"].is_null()) json["reason"] = "no pile was completed";
  return json;
}

/// Whether a law leaves out some of its rules.
bool some_rules(const Json& one) { return one.contains("repair_rules") && one.at("repair_rules") != "all"; }

/// By how many standard errors of their difference a number lies from that of the first law.
double distance(const Json& one, const Json& first) {
  const double error = std::hypot(one.at("stderr").get<double>(), first.at("stderr").get<double>());
  const double difference = std::abs(one.at("value").get<double>() - first.at("value").get<double>());
  return error > 0 ? difference / error : 0;
}

std::string sigmas_from_first(const Json& one, const Json& first) {
  if (!one.at("value").is_number() || !first.at("value").is_number()) return "n/a";
  const bool none = one.at("stderr") == 0 && first.at("stderr") == 0;
  return none ? "n/a" : fmt::format("{:.1f}", distance(one, first));
}

}  // namespace

Json laws_json(const ComparedLaws& measured) {
  return {{"laws", list_of(measured.on_piles, to_json)},
          {"responses", list_of(measured.responses, to_json)},
          {"costs", list_of(measured.costs, to_json)}};
}

Json laws_overlay(const Json& results, const std::string& base) {
  const Json& laws = results.at("laws");
  Json rows = Json::array(), chains = Json::array();
  for (std::size_t i = 0; i < laws.size(); ++i) {
    rows.push_back({{"some_rules", some_rules(laws[i])}});
    if (laws[i].contains("burn_in")) chains.push_back({{"key", fmt::format("{}/laws/{}", base, i)}, {"last", false}});
  }
  if (!chains.empty()) chains.back()["last"] = true;
  return {{"laws", rows}, {"chains", chains}};
}

Json law_responses_overlay(const Json& results) {
  const Json& responses = results.at("responses");
  Json rows = Json::array();
  for (std::size_t i = 0; i < responses.size(); ++i) {
    Json row = {{"some_rules", some_rules(responses[i])}};
    for (const char* name : {"c", "D"}) {
      row[std::string(name) + "_apart"] =
          i == 0 ? "–" : sigmas_from_first(responses[i].at(name), responses[0].at(name));
    }
    rows.push_back(row);
  }
  return {{"responses", rows}};
}

Json law_rules_overlay(const Json& results, const std::string& base) {
  const Json& laws = results.at("laws");
  Json rules = Json::array();
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Json& one = laws[i];
    const bool as_the_first = one.at("columns") == laws[0].at("columns") && one.at("layers") == laws[0].at("layers");
    if (!one.contains("repair_rules") || !as_the_first) continue;
    rules.push_back({{"key", fmt::format("{}/laws/{}", base, i)}, {"some_rules", some_rules(one)}});
  }
  return {{"rules", rules}};
}

Json laws_page_1(const Json& results, const std::string& base) {
  constexpr double sure = 3;  // standard errors
  const Json& laws = results.at("laws");
  const auto known = [](const Json& number) { return number.at("value").is_number(); };
  std::vector<std::string> same, small, responses;
  const Json *first = nullptr, *first_small = nullptr;
  double farthest = 0;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Json& one = laws[i];
    if (some_rules(one) || !known(one.at("alpha_thrust"))) continue;
    const std::string pointer = fmt::format("{}/laws/{}", base, i);
    const auto size_of = [](const Json& law) { return std::pair(law.at("columns"), law.at("layers")); };
    if (first == nullptr) first = &one;
    if (size_of(one) == size_of(*first)) {
      same.push_back(pointer);
      farthest = std::max(farthest, distance(one.at("alpha_thrust"), first->at("alpha_thrust")));
      continue;
    }
    if (first_small == nullptr) first_small = &one;
    if (size_of(one) == size_of(*first_small)) small.push_back(pointer);
  }
  if (same.size() < 2) return nullptr;
  for (std::size_t i = 0; i < results.at("responses").size(); ++i) {
    const Json& one = results.at("responses")[i];
    if (some_rules(one) || !known(one.at("c")) || !known(one.at("D"))) continue;
    responses.push_back(fmt::format("{}/responses/{}", base, i));
  }
  if (responses.size() < 2) responses.clear();
  const Json& costs = results.at("costs");
  std::string cheapest, dearest;  // of the largest piles at the largest friction, which come last
  for (std::size_t i = 0; i < costs.size(); ++i) {
    const Json& one = costs[i];
    if (one.at("mu") != costs.back().at("mu") || one.at("columns") != costs.back().at("columns")) continue;
    if (one.at("failed") != 0 || !one.at("draws_per_bead").is_number()) continue;
    (one.at("law") == "granusolve" ? cheapest : dearest) = fmt::format("{}/costs/{}", base, i);
  }
  Json cost = nullptr;
  if (!cheapest.empty() && !dearest.empty()) cost = {{"cheap", {{"key", cheapest}}}, {"dear", {{"key", dearest}}}};
  return {{"differ", farthest > sure},
          {"same", enumerated(same)},
          {"first", {{"key", same.front()}}},
          {"has_small", small.size() > 1},
          {"small", enumerated(small)},
          {"first_small", small.empty() ? Json(nullptr) : Json{{"key", small.front()}}},
          {"has_responses", !responses.empty()},
          {"responses", enumerated(responses)},
          {"cost", cost}};
}

}  // namespace granuscope
