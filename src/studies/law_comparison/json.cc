#include "json.h"

#include <fmt/format.h>

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
std::string sigmas_from_first(const Json& one, const Json& first) {
  if (!one.at("value").is_number() || !first.at("value").is_number()) return "n/a";
  const double error = std::hypot(one.at("stderr").get<double>(), first.at("stderr").get<double>());
  const double difference = std::abs(one.at("value").get<double>() - first.at("value").get<double>());
  return error > 0 ? fmt::format("{:.1f}", difference / error) : "n/a";
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

}  // namespace granuscope
