#include "report/clean_json.h"

#include <cmath>

#include "sampling/polytope.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
void clean_strings(Json& document) {
  if (document.is_string()) {
    document = clean_text(document.get_ref<const std::string&>());
  } else if (document.is_structured()) {
    for (auto& element : document) clean_strings(element);
  }
}

void require_known_schema(const Json& summary, const std::string& source) {
  const Json schema = summary.value("schema", Json(summary_schema));
  if (schema.is_number_integer() && schema.get<int>() > 0 && schema.get<int>() <= summary_schema) return;
  throw InputError("{}: its schema is {}, and this program knows 1 to {}; take the program that wrote it", source,
                   single_line(schema.dump(), 20), summary_schema);
}

Json finite_or_null(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

std::string stated(const std::string& reason) { return reason.empty() ? "no reason was recorded" : reason; }

void to_json(Json& json, const Estimate& estimate) {
  if (!estimate.known()) {
    json["value"] = nullptr;
    json["stderr"] = nullptr;
    json["reason"] = stated(estimate.reason);
    return;
  }
  json["value"] = estimate.value;
  json["stderr"] = finite_or_null(estimate.standard_error);
  if (std::isfinite(estimate.systematic)) json["systematic"] = estimate.systematic;
  if (!std::isfinite(estimate.standard_error)) json["reason"] = "its standard error is unknown";
}

void to_json(Json& json, const ThrustAtDepth& depth) {
  json = {{"layer", depth.layer},
          {"z", depth.z},
          {"thrust_ratio", depth.thrust_ratio},
          {"weight_variance", depth.weight_variance}};
}

void to_json(Json& json, const LineTest& test) {
  json["chi2"] = finite_or_null(test.chi2);
  json["degrees_of_freedom"] = test.degrees_of_freedom;
  json["points"] = test.points;
  if (json["chi2"].is_null()) json["reason"] = stated(test.reason);
}

void to_json(Json& json, const FlatTest& test) {
  json = test.all_zero;
  json["probability"] = finite_or_null(test.chance);
  for (std::size_t i = 0; i < test.means.size(); ++i) json[flat_tests[i]] = test.means[i];
}

void to_json(Json& json, const RunningExponent& running) {
  json["at_low"] = running.at_low;
  json["at_high"] = running.at_high;
  if (running.at_low.known()) {
    json["at_low"]["at"] = running.low;
    json["at_high"]["at"] = running.high;
  }
  json["about_law"] = running.scatter;
}

void to_json(Json& json, const ResponseSpec& response) {
  ResponseSpec copy = response;  // keys could set what they tell
  const std::vector<Key> keys = keys_of(copy);
  for (const Key& key : keys) {
    if (key.name == "samples" || key.name == "blocks" || !counts(key, keys)) continue;
    std::visit([&](const auto& value) { json[key.name] = value; }, key.get());
  }
}

namespace {

/// A value whose standard error alone is unknown keeps its value; the reason then tells of the error.
Json estimate_json(const Estimate& estimate) {
  Json json{{"value", finite_or_null(estimate.value)}, {"stderr", finite_or_null(estimate.standard_error)}};
  if (!estimate.reason.empty()) json["reason"] = estimate.reason;
  return json;
}

/// Null where no pile was completed: 0 would be the claim that none of its beads cost anything.
Json share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return nullptr;
  return static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

std::string sample_statistics_json(const SampleStatistics& statistics) {
  const SamplerCounts& counts = statistics.counts;
  const std::uint64_t repaired = counts.repaired_by_pair + counts.repaired_by_arc + counts.repaired_by_ring;
  Json per_layer = Json::array();
  for (const LayerStatistics& layer : statistics.per_layer) {
    per_layer.push_back({{"layer", layer.layer},
                         {"alpha", estimate_json(layer.alpha)},
                         {"weight_variance", estimate_json(layer.weight_variance)}});
    for (const auto& [name, number] : layer.forces) per_layer.back()[name] = estimate_json(number);
  }
  Json audit{{"max_balance_residual", finite_or_null(statistics.audit.max_balance_residual)},
             {"max_cone_violation", finite_or_null(statistics.audit.max_cone_violation)}};
  if (audit["max_balance_residual"].is_null()) audit["reason"] = "none of the audited samples is a completed pile";
  Json json{{"law", statistics.law},
            {"mu", statistics.mu},
            {"columns", statistics.columns},
            {"layers", statistics.layers},
            {"samples", statistics.samples},
            {"tries", counts.tries},
            {"draws_per_bead", share(counts.uniforms, counts.beads)},
            {"repaired_per_bead", share(repaired, counts.beads)},
            {"backtracked_per_bead", share(counts.backtracked, counts.beads)},
            {"seconds", statistics.seconds}};
  if (counts.beads == 0) json["reason"] = "no pile was completed, so that there are no beads to count per";
  json["per_layer"] = per_layer;
  json["audit"] = audit;
  json["rounded_per_bead"] = share(counts.rounded, counts.beads);
  json["effective_samples"] = estimate_json(statistics.effective_samples);
  if (statistics.law == "polytope" && statistics.mu > 0) {
    json["chain"] = {{"lambda", statistics.lambda},
                     {"burn_in", statistics.burn_in},
                     {"thinning", statistics.thinning},
                     {"accepted", share(counts.accepted_moves, counts.moves)}};
  }
  return json.dump(2) + "\n";
}

std::string findings_json(const std::vector<Finding>& findings) {
  Json list = Json::array();
  bool good = true;
  for (const Finding& finding : findings) {
    list.push_back({{"subject", finding.subject}, {"good", finding.good}, {"text", finding.text}});
    if (!finding.good && !finding.package.empty()) list.back()["package"] = finding.package;
    good = good && finding.good;
  }
  return Json{{"good", good}, {"findings", list}}.dump(2) + "\n";
}

std::string audit_json(const Pile& pile, const AuditResult& audit, double tolerance) {
  const auto residual = [](double value, int layer) {
    return Json{{"value", finite_or_null(value)}, {"layer", layer}};
  };
  const bool good = audit.max_balance_residual <= tolerance && audit.max_cone_violation <= tolerance;
  return Json{{"law", pile.law},
              {"mu", pile.mu},
              {"columns", pile.lattice.columns()},
              {"layers", pile.lattice.layers()},
              {"seed", pile.seed},
              {"sample", pile.sample},
              {"max_balance_residual", residual(audit.max_balance_residual, audit.balance_layer)},
              {"max_cone_violation", residual(audit.max_cone_violation, audit.cone_layer)},
              {"allowed", tolerance},
              {"good", good}}
             .dump(2) +
         "\n";
}

std::string render_statistics_json(const SceneStatistics& statistics) {
  const SceneCounts& counts = statistics.counts;
  const SceneStatistics::Seconds& seconds = statistics.seconds;
  const Json json{
      {"drawn", counts.drawn},
      {"outside", counts.outside},
      {"too_faint", counts.too_faint},
      {"aggregated", counts.aggregated},
      {"pixels", counts.pixels},
      {"seconds",
       {{"read", seconds.read}, {"build", seconds.build}, {"draw", seconds.draw}, {"encode", seconds.encode}}}};
  return json.dump(2) + "\n";
}

}  // namespace granuscope
