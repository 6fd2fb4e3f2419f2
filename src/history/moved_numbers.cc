#include "history/moved_numbers.h"

#include <fmt/format.h>
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>

#include "analysis/results.h"
#include "report/reason_notes.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

constexpr double tiny = 1e-12;  ///< of numbers that are exact without friction, as in claim_frictionless.cc

void add_known(std::vector<KnownNumber>& numbers, const std::string& name, const Json& holder, const char* key) {
  const auto found = holder.find(key);
  if (found == holder.end() || !found->is_object()) return;
  const auto value = found->find("value"), error = found->find("stderr");
  if (value == found->end() || error == found->end() || !value->is_number() || !error->is_number()) return;
  numbers.push_back({name, value->get<double>(), error->get<double>()});
}

std::string at_value(const std::string& scanned, double value) {
  return fmt::format("at {} = {}", scanned, exact(value));
}

/// Calls `use` for each result with where it is: "at mu = 0.3".
template <class Use>
void for_each_result(const Json& summary, Use use) {
  const auto results = summary.find("results");
  if (results == summary.end() || !results->is_array()) return;
  const std::string scanned = scanned_in(summary);
  for (const Json& result : *results) {
    if (!result.is_object() || !result.contains(scanned) || !result.at(scanned).is_number()) continue;
    use(result, at_value(scanned, result.at(scanned).get<double>()));
  }
}

/// After Welch and Satterthwaite, of the difference of two means with these variances.
double degrees_of_freedom(double before, int blocks_before, double after, int blocks_after) {
  const double sum = before + after;
  if (sum <= 0) return 1;
  return sum * sum / (before * before / (blocks_before - 1) + after * after / (blocks_after - 1));
}

}  // namespace

std::vector<KnownNumber> primary_numbers(const Json& summary) {
  std::vector<KnownNumber> numbers;
  for_each_result(summary, [&](const Json& result, const std::string& where) {
    for (const char* key : {"c", "D", "c_thrust"}) add_known(numbers, fmt::format("{} {}", key, where), result, key);
  });
  if (const auto scaling = summary.find("scaling"); scaling != summary.end() && scaling->is_object()) {
    for (const char* key : {"beta", "gamma", "alpha"}) add_known(numbers, key, *scaling, key);
  }
  return numbers;
}

std::vector<KnownNumber> primary_numbers_of(const Analysis& analysis) {
  std::vector<KnownNumber> numbers;
  const auto add = [&](const std::string& name, const Estimate& estimate) {
    if (estimate.known()) numbers.push_back({name, estimate.value, estimate.standard_error});
  };
  for (const Transport& result : analysis.results) {
    const std::string where = at_value(result.scan->name, result.scanned());
    add("c " + where, result.c);
    add("D " + where, result.D);
    add("c_thrust " + where, result.c_thrust);
  }
  add("beta", analysis.scaling.beta.exponent);
  add("gamma", analysis.scaling.gamma.exponent);
  add("alpha", analysis.scaling.alpha.exponent);
  return numbers;
}

std::vector<KnownNumber> depth_numbers(const Json& summary) {
  std::vector<KnownNumber> numbers;
  for_each_result(summary, [&](const Json& result, const std::string& where) {
    const auto depths = result.find("depths");
    if (depths == result.end() || !depths->is_array()) return;
    for (const Json& depth : *depths) {
      if (!depth.is_object() || !depth.contains("layer")) continue;
      const bool narrow = depth.contains("identifiable") && depth.at("identifiable") == false;
      for (const char* key : {"peak_position", "width", "thrust_ratio"}) {
        if (narrow && std::string_view(key) == "width") continue;  // the size of a bead hides it
        add_known(numbers, fmt::format("{} {}, layer {}", key, where, depth.at("layer").dump()), depth, key);
      }
    }
  });
  return numbers;
}

double chance_of(double t, double degrees_of_freedom) {
  if (std::isinf(t)) return 0;
  return 2 * gsl_cdf_tdist_Q(std::abs(t), degrees_of_freedom);
}

std::vector<MovedNumber> hold_against(const std::vector<KnownNumber>& before, int blocks_before,
                                      const std::vector<KnownNumber>& after, int blocks_after) {
  std::vector<MovedNumber> numbers;
  for (const KnownNumber& old : before) {
    const auto found =
        std::find_if(after.begin(), after.end(), [&](const KnownNumber& one) { return one.name == old.name; });
    if (found == after.end()) continue;
    MovedNumber number{old.name, old, *found};
    const double difference = found->value - old.value;
    const double before_variance = old.standard_error * old.standard_error,
                 after_variance = found->standard_error * found->standard_error;
    const double error = std::sqrt(before_variance + after_variance);
    if (error > 0) {
      number.z = difference / error;
    } else if (std::abs(difference) > tiny * std::max(1.0, std::abs(old.value))) {
      number.z = std::copysign(std::numeric_limits<double>::infinity(), difference);
    }
    number.p = chance_of(number.z, degrees_of_freedom(before_variance, blocks_before, after_variance, blocks_after));
    numbers.push_back(number);
  }
  // Holm: the smallest chance against rate/n, the next against rate/(n - 1), up to the first that is large enough.
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return numbers[a].p < numbers[b].p; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (numbers[order[k]].p > false_alarm_rate / static_cast<double>(order.size() - k)) break;
    numbers[order[k]].moved = true;
  }
  return numbers;
}

}  // namespace granuscope
