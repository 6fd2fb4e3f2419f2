#include "studies/model_classes/results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/claims.h"
#include "model/lattice.h"
#include "report/clean_json.h"
#include "studies/study.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// How much of c0 - c the mean must give to explain it. Named by no paper.
constexpr double nearly_all = 0.1;

/// Of the classes, not of what has figures of its own.
template <class Use>
void for_each(const std::vector<ModelSeries>& series, const std::string& model, Use use) {
  for (const ModelSeries& one : series) {
    if (one.aside) continue;
    for (const ModelResponse& response : one.responses) {
      if (response.model == model) use(one, response);
    }
  }
}

void judge_growth(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse* nearest = nullptr;
  const auto distance = [](const ModelResponse& one) {
    return (2 - one.width_exponent.value) / one.width_exponent.standard_error;
  };
  bool measured = false;
  for_each(series, "frictional-beads", [&](const ModelSeries&, const ModelResponse& one) {
    measured = true;
    if (!one.width_exponent.known()) return;
    if (nearest == nullptr || distance(one) < distance(*nearest)) nearest = &one;
  });
  if (!measured) return;
  Claim claim = open_claim("models-not-elastic", "The width of the response does not scale as in an elastic medium.",
                           "power of z in W² of the beads");
  if (nearest == nullptr) {
    leave_open(claim, "the power of z in W² is not known for any friction coefficient: ask for more samples");
  } else {
    judge_by_exclusion(
        claim, nearest->width_exponent, {.value = 1}, {2, "elastic"},
        fmt::format("The power of z in W² at {}, where it is nearest to 2 in its errors,", nearest->parameter));
  }
  claims.push_back(std::move(claim));
}

/// Root of the mean square distance from below the load, W of one Gaussian and sqrt(x_p^2 + W^2) of two, at z by the
/// slopes.
Estimate reach(const ModelResponse& one, double z) {
  Estimate reach;
  const double c = one.peaks == 2 ? one.c.value : 0;
  reach.value = std::sqrt(c * c * z * z + one.D.value * z);
  const double c_error = one.peaks == 2 ? one.c.standard_error : 0;
  reach.standard_error = std::hypot(c * z * z * c_error, z * one.D.standard_error / 2) / reach.value;
  return reach;
}

void judge_q_model(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse *q_model = nullptr, *beads = nullptr;
  bool single = true;
  for_each(series, "q-model", [&](const ModelSeries&, const ModelResponse& one) {
    q_model = &one;
    single = single && one.peaks == 1;
  });
  for_each(series, "frictional-beads", [&](const ModelSeries&, const ModelResponse& one) {
    if (one.c.known() && one.D.known()) beads = &one;
  });
  if (q_model == nullptr || beads == nullptr) return;
  Claim claim = open_claim("q-model-too-narrow", "The response of the q-model is a single peak, and too narrow.",
                           "root mean square distance of the q-model’s response from below the load, over the beads’");
  if (!q_model->D.known()) {
    leave_open(claim, "the width of the q-model is not known: " + q_model->D.reason);
  } else {
    const double z = std::min(q_model->z[1], beads->z[1]);
    const Estimate narrow = reach(*q_model, z), wide = reach(*beads, z);
    Estimate ratio;
    ratio.value = narrow.value / wide.value;
    ratio.standard_error =
        ratio.value * std::hypot(narrow.standard_error / narrow.value, wide.standard_error / wide.value);
    judge_by_exclusion(claim, ratio, {.value = 0}, {1, "as wide"},
                       fmt::format("The ratio to the beads at {} and z = {:.0f}", beads->parameter, z));
    if (ratio.value > 1 && claim.verdict == reproduced) claim.verdict = not_reproduced;
    if (!single) claim.verdict = not_reproduced;
    add_sentence(claim, single ? "It has one peak under every law of q." : "Under some law of q it has two peaks.");
  }
  claims.push_back(std::move(claim));
}

void judge_scaling(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelSeries *beads = nullptr, *osl = nullptr;
  for_each(series, "frictional-beads", [&](const ModelSeries& one, const ModelResponse&) { beads = &one; });
  for_each(series, "stochastic-osl", [&](const ModelSeries& one, const ModelResponse&) { osl = &one; });
  if (beads == nullptr) return;
  Claim claim = open_claim("models-c-of-D", "c₀ − c of the beads does not follow D as the stochastic theory has it.",
                           "exponent of c₀ − c against D of the beads, linear response");
  if (!beads->alpha.exponent.known()) {
    leave_open(claim, "the exponent is not known: " + beads->alpha.exponent.reason);
  } else {
    judge_by_exclusion(claim, beads->alpha.exponent, {.value = 0.4, .error = 0.01}, {1, "stochastic theory"},
                       "The exponent");
    if (osl != nullptr && osl->alpha.exponent.known()) {
      const Estimate& alpha = osl->alpha.exponent;
      add_sentence(claim, "Stochastic OSL itself has {} by the same fits.", value_with_error(alpha));
    }
  }
  claims.push_back(std::move(claim));
}

void judge_mean(const std::vector<ModelSeries>& series, std::vector<Claim>& claims) {
  const ModelResponse* widest = nullptr;
  for_each(series, "three-leg", [&](const ModelSeries& one, const ModelResponse& response) {
    if (one.name == "three-leg, positive") widest = &response;
  });
  if (widest == nullptr) return;
  Claim claim = open_claim("mean-of-noise", "A noise with a finite mean explains the propagation coefficient.",
                           "share of c₀ − c that the mean share of the middle leg gives by itself");
  if (!widest->share_of_mean.known()) {
    leave_open(claim, "the share is not known: " + widest->share_of_mean.reason);
  } else {
    judge_by_number(claim, widest->share_of_mean, {.value = 1, .tolerance = nearly_all}, Rival{0, "fluctuations alone"},
                    fmt::format("The share in the three-leg model whose legs push, {},", widest->parameter));
    if (widest->c.known()) {
      add_sentence(claim, "There c = {}, and c₀ √(1 − ⟨p⟩) = {}.", value_with_error(widest->c),
                   value_with_error(widest->c_of_middle));
    }
  }
  claims.push_back(std::move(claim));
}

}  // namespace

std::vector<Claim> judge_models(const std::vector<ModelSeries>& series) {
  std::vector<Claim> claims;
  judge_growth(series, claims);
  judge_q_model(series, claims);
  judge_scaling(series, claims);
  judge_mean(series, claims);
  return claims;
}

namespace {

using Json = nlohmann::ordered_json;

Estimate exact_or_unknown(double value) {
  return std::isfinite(value) ? Estimate{.value = value, .standard_error = 0, .reason = ""}
                              : Estimate{.reason = "no exact value is known"};
}

Json noise_json(const ModelResponse& one) {
  const std::optional<NoiseTheory>& theory = one.theory;
  if (!theory) return nullptr;
  const double squared = theory->disorder * theory->disorder;
  return {{"disorder", theory->disorder},
          {"disorder_squared", squared},
          {"c0", theory->c0},
          {"D0", theory->D0},
          {"kappa", theory->wide.kappa},
          {"spreading", theory->wide.spreading},
          {"narrow", theory->narrow && one.width < theory->cell},
          {"thrust_loss", one.thrust_loss},
          {"thrust_loss_expected", theory->wide.kappa * squared},
          {"speed_loss", one.speed_loss},
          {"speed_loss_expected", theory->shift(one.width).kappa * squared},
          {"spreading_gain", one.spreading_gain},
          {"spreading_gain_expected", theory->shift(one.width).spreading * squared}};
}

}  // namespace

void to_json(Json& json, const StressAtDepth& one) {
  json = {{"z", one.z},
          {"weight", one.weight},
          {"thrust_ratio", one.thrust_ratio},
          {"weight_variance", one.weight_variance}};
}

void to_json(Json& json, const TractionDepth& one) {
  json = {
      {"middle", one.middle}, {"noise", one.noise}, {"columns", one.columns}, {"samples", one.samples}, {"z", one.z}};
}

void to_json(Json& json, const DeepModel& one) {
  json = {{"series", one.series}, {"parameter", one.parameter}};
  const Json spreading = one.response;
  for (const char* key : {"estimator", "columns", "layers", "samples", "lags", "octaves", "dispersion", "c_thrust"}) {
    json[key] = spreading.at(key);
  }
}

void to_json(Json& json, const ModelResponse& one) {
  Json chi2 = Json::object();
  for (const ResponseShape shape : all_response_shapes) {
    chi2[name_of(shape)] = finite_or_null(one.fits[static_cast<std::size_t>(shape)].chi2);
  }
  const auto of = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  const double elastic = std::min(of(ResponseShape::isotropic), of(ResponseShape::orthotropic));
  const double gaussian = std::min(of(ResponseShape::one_gaussian), of(ResponseShape::two_gaussians));
  const std::size_t colon = std::min(one.verdict.find(": "), one.verdict.size());
  json = {{"series", one.series},
          {"model", one.model},
          {"parameter", one.parameter},
          {"bead_weight", one.bead_weight},
          {"samples", one.samples},
          {"window_layers", one.layers},
          {"window_z", one.z},
          {"peaks", one.peaks},
          {"c", one.c},
          {"c_expected", exact_or_unknown(one.c_expected)},
          {"noise", noise_json(one)},
          {"D", one.D},
          {"D_expected", exact_or_unknown(one.D_expected)},
          {"c0_minus_c", one.slowing},
          {"c_thrust", one.c_thrust},
          {"width_exponent", one.width_exponent},
          {"shape", name_of(one.shape)},
          {"chi2", chi2},
          {"chi2_against_elastic", std::round(elastic - gaussian)},
          {"class", one.verdict.substr(0, colon)},
          {"why", colon < one.verdict.size() ? one.verdict.substr(colon + 2) : ""},
          {"middle", one.middle},
          {"c_of_middle", one.c_of_middle},
          {"share_of_mean", one.share_of_mean},
          {"traction", one.traction},
          {"stress", one.stress}};
}

Json models_json(const MeasuredModels& measured) {
  Json responses = Json::array(), exponents = Json::array();
  for (const ModelSeries& series : measured.series) {
    for (const ModelResponse& one : series.responses) {
      responses.push_back(one);
      responses.back()["aside"] = series.aside;
    }
    if (series.aside) continue;
    exponents.push_back({{"series", series.name}, {"points", series.alpha.points}, {"alpha", series.alpha.exponent}});
  }
  return {
      {"responses", responses}, {"exponents", exponents}, {"tractions", measured.tractions}, {"deep", measured.deep}};
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
