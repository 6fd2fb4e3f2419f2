#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "studies/spreading.h"
#include "studies/study.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

constexpr double sure = 3;  ///< standard errors

double distance(const Json& one, const Json& other) {
  return std::abs(one.at("value").get<double>() - other.at("value").get<double>()) /
         std::hypot(one.at("stderr").get<double>(), other.at("stderr").get<double>());
}

}  // namespace

Json spreading_page_1(const Json& results, const std::string& pointer) {
  const Json diffusion = {{"value", 1.0}, {"stderr", 0.0}};
  std::vector<std::string> deep;
  std::size_t slow = 0, fast = 0;
  double apart = 0;
  const Json *last = nullptr, *at_mu = nullptr;  // the largest friction; the measurement that checks are held against
  std::string last_key;
  bool checked = false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Json& one = results[i];
    const std::string place = fmt::format("{}/{}", pointer, i);
    const Json& exponent = one.at("deep").at("exponent");
    if (at_mu != nullptr && at_mu->at("mu") == one.at("mu")) {
      const Json& checked_one = at_mu->at("deep").at("exponent");
      if (!exponent.at("value").is_number() || !checked_one.at("value").is_number()) continue;
      apart = std::max(apart, distance(exponent, checked_one));
      checked = true;
      continue;
    }
    at_mu = &one;
    if (!exponent.at("value").is_number()) continue;
    deep.push_back(place);
    const bool faster = exponent.at("value").get<double>() > 1 && distance(exponent, diffusion) > sure;
    (faster ? fast : slow) += 1;
    last = &one;
    last_key = place;
  }
  if (last == nullptr) return nullptr;
  const std::size_t octaves = last->at("octaves").size();
  return {{"deep", enumerated(deep)},
          {"all_fast", slow == 0},
          {"some_fast", fast > 0 && slow > 0},
          {"none_fast", fast == 0},
          {"largest", {{"key", last_key}}},
          {"first_octave", {{"key", last_key + "/octaves/0"}}},
          {"last_octave", {{"key", fmt::format("{}/octaves/{}", last_key, octaves - 1)}}},
          {"checked", checked},
          {"apart", fmt::format("{:.1f}", apart)}};
}

}  // namespace granuscope
