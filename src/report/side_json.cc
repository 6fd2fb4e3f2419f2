#include "report/side_json.h"

#include "report/estimate_json.h"
#include "report/spec_json.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

Json to_json(const LawOnPiles& one);
Json to_json(const LawResponse& one);
Json to_json(const ExactThrust& one);

template <typename Item>
Json list_of(const std::vector<Item>& items) {
  Json json = Json::array();
  for (const Item& item : items) json.push_back(to_json(item));
  return json;
}

/// Which law, and how its chains ran.
template <class Measured>
void name_law(const Measured& one, Json& json) {
  const SamplerSpec& sampler = one.spec.sampler;
  if (sampler.law == Law::granusolve) json["mending_rules"] = name_of(sampler.rules);
  if (sampler.law != Law::polytope) return;
  json["lambda"] = sampler.lambda;
  json["burn_in"] = finite_or_null(one.burn_in);
  json["thinning"] = finite_or_null(one.thinning);
  if (json["burn_in"].is_null()) json["reason"] = "no chain was begun";
}

Json to_json(const LawResponse& one) {
  Json json = {{"law", name_of(one.spec.sampler.law)}};
  name_law(one, json);
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
  Json json = {{"law", name_of(one.spec.sampler.law)}};
  name_law(one, json);
  json.update(Json{{"mu", one.spec.sampler.mu},
                   {"columns", one.spec.lattice.columns},
                   {"layers", one.spec.lattice.layers},
                   {"samples", one.samples},
                   {"failed", one.failed},
                   {"effective_samples", granuscope::to_json(one.effective_samples)},
                   {"draws_per_bead", finite_or_null(one.draws_per_bead)},
                   {"pair_per_bead", finite_or_null(one.pair_per_bead)},
                   {"arc_per_bead", finite_or_null(one.arc_per_bead)},
                   {"climbed_per_bead", finite_or_null(one.climbed_per_bead)},
                   {"window_layers", {one.first_layer, one.last_layer}},
                   {"alpha_thrust", granuscope::to_json(one.alpha_thrust)},
                   {"c_thrust", granuscope::to_json(one.c_thrust)},
                   {"weight_variance", granuscope::to_json(one.weight_variance)},
                   {"depths", list_of(one.depths)}});
  if (json["draws_per_bead"].is_null()) json["reason"] = "no pile was completed";
  return json;
}

Json to_json(const ExactThrust& one) {
  return {{"law", "rejection"},
          {"mu", one.spec.sampler.mu},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"bulk_layers", {one.first_layer, one.last_layer}},
          {"alpha_thrust", granuscope::to_json(one.alpha)},
          {"deficit_over_mu_squared", granuscope::to_json(one.deficit_over_mu2)},
          {"change_with_depth", granuscope::to_json(one.change_with_depth)},
          {"alpha_of_last_layer", granuscope::to_json(one.alpha_of_last_layer)}};
}

}  // namespace

Json to_json(const SideMeasurements& side) {
  Json json;
  json["laws"] = list_of(side.laws);
  json["law_responses"] = list_of(side.law_responses);
  json["exact_thrusts"] = list_of(side.exact_thrusts);
  json["law_costs"] = list_of(side.law_costs);
  return json;
}

}  // namespace granuscope
