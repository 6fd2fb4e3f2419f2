#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "report/reason_notes.h"
#include "report/report_overlay.h"
#include "support/number_format.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

std::string verdict_of(const Json& summary, const char* id) {
  for (const Json& claim : summary.at("claims")) {
    if (claim.at("id") == id) return claim.at("verdict").get<std::string>();
  }
  return "not tested";
}

/// What the paper varies.
bool is_friction_of_beads(const Json& summary) {
  return scanned_in(summary) == "mu" && summary.at("scan").at("model") == "frictional-beads";
}

bool known(const Json& estimate) { return estimate.at("value").is_number(); }

/// Exponents to which the points of the fit do not keep stand without an error.
void add_exponents(Json& place, const Json& fits, const std::string& pointer) {
  for (const char* name : {"beta", "gamma", "alpha"}) {
    const Json& fit = fits.at(name);
    if (fit.at("power_law") != false) continue;
    place[name] = {{"key", fmt::format("{}/{}", pointer, name)},
                   {"text", significant(fit.at("value").get<double>(), 3)}};
  }
}

Json exponents_of(const Json& list, const std::string& pointer) {
  Json places = Json::array();
  for (const Json& fits : list) {
    const std::string at = fmt::format("{}/{}", pointer, places.size());
    Json place = Json::object();
    add_exponents(place, fits, at);
    if (fits.contains("from_load")) {
      place["from_load"] = Json::object();
      add_exponents(place["from_load"], fits.at("from_load"), at + "/from_load");
    }
    places.push_back(place);
  }
  return places;
}

/// Whether the ratio lies nearer to the paper's linear law than the slopes do.
bool ratio_explains(const Json& scaling) {
  const Json& ratio = scaling.at("by_ratio").at(0);
  const auto off = [](const Json& fit) { return std::abs(fit.at("value").get<double>() - 1); };
  return off(ratio.at("gamma")) < off(scaling.at("gamma")) / 2 &&
         off(ratio.at("from_load").at("gamma")) > off(scaling.at("gamma")) / 2;
}

}  // namespace

void add_exponent_texts(Json& overlay, const Json& summary) {
  const Json& scaling = summary.at("scaling");
  Json& place = overlay["scaling"] = Json::object();
  add_exponents(place, scaling, "/scaling");
  place["other_windows"] = exponents_of(scaling.at("other_windows"), "/scaling/other_windows");
  place["by_ratio"] = exponents_of(scaling.at("by_ratio"), "/scaling/by_ratio");
}

void add_causes(Json& overlay, const Json& summary) {
  const Json& scaling = summary.at("scaling");
  Json shifts = Json::array();
  // Whichever study holds the exponents of the paper's overload against those of the linear response.
  for (const auto& [id, study] : summary.at("studies").items()) {
    if (!study.is_object() || !study.contains("exponents")) continue;
    const Json& exponents = study.at("exponents");
    for (std::size_t i = 0; i < exponents.size(); ++i) {
      const Json& one = exponents[i];
      if (!one.is_object() || !one.contains("beta_minus_linear") || one.at("estimator") != "point" ||
          one.at("load") != 1 || !known(one.at("beta_minus_linear")) || !known(one.at("gamma_minus_linear"))) {
        continue;
      }
      shifts.push_back({{"key", fmt::format("/studies/{}/exponents/{}", id, i)}});
    }
  }
  bool moved = true;
  for (const char* name : {"beta", "gamma", "alpha"}) moved = moved && scaling.at(name).contains("systematic");
  overlay["overload_shift"] = shifts;
  overlay["depth_window"] = moved ? Json{{"key", "/scaling"}} : Json(nullptr);
  overlay["has_causes"] = is_friction_of_beads(summary) && known(scaling.at("gamma")) && known(scaling.at("alpha"));
}

/// The first and the last result whose c and D are known; null if there are not two.
Json ends_of_scan(const Json& summary, bool powers) {
  const Json& results = summary.at("results");
  std::vector<std::size_t> told;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (known(results[i].at("c")) && known(results[i].at("D"))) told.push_back(i);
  }
  if (told.size() < 2) return nullptr;
  const auto end = [&](std::size_t i) {
    const std::string place = fmt::format("/results/{}", i);
    return Json{{"scanned", {{"key", place_of_scanned(summary, i)}}},
                {"c", {{"key", place + "/c"}}},
                {"D", {{"key", place + "/D"}}}};
  };
  return {{"first", end(told.front())}, {"last", end(told.back())}, {"powers", powers}};
}

void add_headline(Json& overlay, const Json& summary, const std::string& own) {
  const Json& scaling = summary.at("scaling");
  const auto is = [&](const char* id, const char* verdict) { return verdict_of(summary, id) == verdict; };
  const bool ratio = !scaling.at("by_ratio").empty() && known(scaling.at("by_ratio").at(0).at("gamma")) &&
                     known(scaling.at("by_ratio").at(0).at("from_load").at("gamma"));
  const bool of_friction = is_friction_of_beads(summary);
  const bool powers = known(scaling.at("alpha")) && known(scaling.at("beta"));
  const bool generated = own.empty() && of_friction && known(scaling.at("gamma")) && known(scaling.at("beta"));
  overlay["headline"] = {
      {"own", own},
      {"generated", generated},
      {"depth_holds", is("linear-position", "reproduced") && is("diffusive-width", "reproduced")},
      {"c_fails", is("c-of-mu", "not reproduced")},
      {"c_holds", is("c-of-mu", "reproduced")},
      {"D_holds", is("D-of-mu", "reproduced")},
      {"D_fails", is("D-of-mu", "not reproduced")},
      {"alpha_fails", is("c-of-D", "not reproduced")},
      {"alpha_holds", is("c-of-D", "reproduced")},
      {"theory_excluded", is("differs-from-theory", "reproduced")},
      {"theory_holds", is("differs-from-theory", "not reproduced")},
      {"ratio", ratio},
      {"explains", ratio && known(scaling.at("gamma")) && ratio_explains(scaling)},
      {"other_window", !scaling.at("other_windows").empty() && known(scaling.at("other_windows").at(0).at("beta"))},
      {"offset", known(summary.at("mean_position_offset"))}};
  overlay["headline"]["scanned"] = own.empty() && !of_friction ? ends_of_scan(summary, powers) : Json(nullptr);
  const bool any = !own.empty() || generated || !overlay["headline"]["scanned"].is_null();
  overlay["has_headline"] = any;
}

}  // namespace granuscope
