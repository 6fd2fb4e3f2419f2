#include "json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/estimate_json.h"
#include "studies/study.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

Json exact_or_unknown(double value) {
  return std::isfinite(value) ? granuscope::to_json(Estimate{.value = value, .standard_error = 0, .reason = ""})
                              : granuscope::to_json(Estimate{.reason = "no exact value is known"});
}

Json to_json(const std::optional<NoiseTheory>& theory, const ModelResponse& one) {
  if (!theory) return nullptr;
  const double squared = theory->disorder * theory->disorder;
  return {{"disorder", theory->disorder},
          {"disorder_squared", squared},
          {"c0", theory->c0},
          {"D0", theory->D0},
          {"kappa", theory->wide.kappa},
          {"spreading", theory->wide.spreading},
          {"narrow", theory->narrow && one.width < theory->cell},
          {"thrust_loss", granuscope::to_json(one.thrust_loss)},
          {"thrust_loss_expected", theory->wide.kappa * squared},
          {"speed_loss", granuscope::to_json(one.speed_loss)},
          {"speed_loss_expected", theory->shift(one.width).kappa * squared},
          {"spreading_gain", granuscope::to_json(one.spreading_gain)},
          {"spreading_gain_expected", theory->shift(one.width).spreading * squared}};
}

Json to_json(const StressAtDepth& one) {
  return {{"z", one.z},
          {"weight", one.weight},
          {"thrust_ratio", granuscope::to_json(one.thrust_ratio)},
          {"weight_variance", granuscope::to_json(one.weight_variance)}};
}

Json to_json(const TractionDepth& one) {
  return {{"middle", one.middle},
          {"noise", one.noise},
          {"columns", one.columns},
          {"samples", one.samples},
          {"z", granuscope::to_json(one.z)}};
}

Json to_json(const DeepModel& one) {
  Json json{{"series", one.series}, {"parameter", one.parameter}};
  const Json spreading = spreading_json(one.response);
  for (const char* key : {"estimator", "columns", "layers", "samples", "lags", "octaves", "dispersion", "c_thrust"}) {
    json[key] = spreading.at(key);
  }
  return json;
}

Json to_json(const ModelResponse& one) {
  Json chi2 = Json::object();
  for (const ResponseShape shape : all_response_shapes) {
    chi2[name_of(shape)] = finite_or_null(one.fits[static_cast<std::size_t>(shape)].chi2);
  }
  const auto of = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  const double elastic = std::min(of(ResponseShape::isotropic), of(ResponseShape::orthotropic));
  const double gaussian = std::min(of(ResponseShape::one_gaussian), of(ResponseShape::two_gaussians));
  const std::size_t colon = std::min(one.verdict.find(": "), one.verdict.size());
  return {{"series", one.series},
          {"model", one.model},
          {"parameter", one.parameter},
          {"bead_weight", one.bead_weight},
          {"samples", one.samples},
          {"window_layers", one.layers},
          {"window_z", one.z},
          {"peaks", one.peaks},
          {"c", granuscope::to_json(one.c)},
          {"c_expected", exact_or_unknown(one.c_expected)},
          {"noise", to_json(one.theory, one)},
          {"D", granuscope::to_json(one.D)},
          {"D_expected", exact_or_unknown(one.D_expected)},
          {"c0_minus_c", granuscope::to_json(one.slowing)},
          {"c_thrust", granuscope::to_json(one.c_thrust)},
          {"width_exponent", granuscope::to_json(one.width_exponent)},
          {"shape", name_of(one.shape)},
          {"chi2", chi2},
          {"chi2_against_elastic", std::round(elastic - gaussian)},
          {"class", one.verdict.substr(0, colon)},
          {"why", colon < one.verdict.size() ? one.verdict.substr(colon + 2) : ""},
          {"middle", granuscope::to_json(one.middle)},
          {"c_of_middle", granuscope::to_json(one.c_of_middle)},
          {"share_of_mean", granuscope::to_json(one.share_of_mean)},
          {"traction", granuscope::to_json(one.traction)},
          {"stress", list_of<StressAtDepth>(one.stress, to_json)}};
}

}  // namespace

Json models_json(const MeasuredModels& measured) {
  Json responses = Json::array(), exponents = Json::array();
  for (const ModelSeries& series : measured.series) {
    for (const ModelResponse& one : series.responses) {
      responses.push_back(to_json(one));
      responses.back()["aside"] = series.aside;
    }
    if (series.aside) continue;
    exponents.push_back({{"series", series.name},
                         {"points", series.alpha.points},
                         {"alpha", granuscope::to_json(series.alpha.exponent)}});
  }
  return {{"responses", responses},
          {"exponents", exponents},
          {"tractions", list_of<TractionDepth>(measured.tractions, to_json)},
          {"deep", list_of<DeepModel>(measured.deep, to_json)}};
}

Json models_page_1(const Json& results) {
  constexpr double roughest = 0.2;  // standard error of a power of z that is told
  const std::string base = "/studies/model_classes";
  std::vector<std::string> by_peaks[2], exponents;
  std::string least, most, fastest, slowest, last;
  const auto value = [&results](const std::string& pointer) {
    return results.at(Json::json_pointer(pointer)).at("value");
  };
  const auto place = [&](std::string& chosen, const std::string& pointer, double sign) {
    const Json& candidate = value(pointer);
    if (!candidate.is_number()) return;
    if (chosen.empty() || sign * candidate.get<double>() > sign * value(chosen).get<double>()) chosen = pointer;
  };
  for (std::size_t i = 0; i < results.at("responses").size(); ++i) {
    const Json& one = results.at("responses")[i];
    if (one.at("aside")) continue;
    const std::string pointer = fmt::format("/responses/{}", i);
    const std::size_t peaks = one.at("peaks") == 1 ? 0 : 1;
    std::vector<std::string>& alike = by_peaks[peaks];
    if (one.at("series") != last || alike.empty()) alike.push_back(base + pointer);
    last = one.at("series");
    place(least, pointer + "/share_of_mean", -1);
    place(most, pointer + "/share_of_mean", 1);
    const Json& power = one.at("width_exponent");
    if (!power.at("value").is_number() || power.at("stderr").get<double>() > roughest) continue;
    place(slowest, pointer + "/width_exponent", -1);
    place(fastest, pointer + "/width_exponent", 1);
  }
  for (std::size_t i = 0; i < results.at("exponents").size(); ++i) {
    const std::string pointer = fmt::format("/exponents/{}", i);
    if (value(pointer + "/alpha").is_number()) exponents.push_back(base + pointer);
  }
  const auto pair = [&](const std::string& low, const std::string& high) {
    return low.empty() ? Json(nullptr) : Json{{"low", {{"key", base + low}}}, {"high", {{"key", base + high}}}};
  };
  return {{"told_apart", !by_peaks[0].empty() && !by_peaks[1].empty()},
          {"one_peak", enumerated(by_peaks[0])},
          {"two_peaks", enumerated(by_peaks[1])},
          {"some_exponents", !exponents.empty()},
          {"exponents", enumerated(exponents)},
          {"widths", pair(slowest, fastest)},
          {"shares", pair(least, most)}};
}

}  // namespace granuscope
