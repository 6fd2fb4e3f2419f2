#include "report/estimate_json.h"

#include <cmath>

namespace granuscope {

using Json = nlohmann::ordered_json;

Json finite_or_null(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

std::string stated(const std::string& reason) { return reason.empty() ? "no reason was recorded" : reason; }

Json to_json(const Estimate& estimate) {
  Json json;
  if (!estimate.known()) {
    json["value"] = nullptr;
    json["stderr"] = nullptr;
    json["reason"] = stated(estimate.reason);
    return json;
  }
  json["value"] = estimate.value;
  json["stderr"] = finite_or_null(estimate.standard_error);
  if (std::isfinite(estimate.systematic)) json["systematic"] = estimate.systematic;
  if (!std::isfinite(estimate.standard_error)) json["reason"] = "its standard error is unknown";
  return json;
}

Json to_json(const ThrustAtDepth& depth) {
  return {{"layer", depth.layer},
          {"z", depth.z},
          {"thrust_ratio", to_json(depth.thrust_ratio)},
          {"weight_variance", to_json(depth.weight_variance)}};
}

Json to_json(const LineTest& test) {
  Json json;
  json["chi2"] = finite_or_null(test.chi2);
  json["degrees_of_freedom"] = test.degrees_of_freedom;
  json["points"] = test.points;
  if (json["chi2"].is_null()) json["reason"] = stated(test.reason);
  return json;
}

Json to_json(const RunningExponent& running) {
  Json json;
  json["at_low"] = to_json(running.at_low);
  json["at_high"] = to_json(running.at_high);
  if (running.at_low.known()) {
    json["at_low"]["at"] = running.low;
    json["at_high"]["at"] = running.high;
  }
  json["about_law"] = to_json(running.scatter);
  return json;
}

}  // namespace granuscope
