#include "analysis/coupling_bias.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "support/number_format.h"

namespace granuscope {

std::string reason_against_pairs(const Replicated& response_thrust, const Replicated& thrust) {
  const Estimate difference = estimate(transform([](double a, double b) { return a - b; }, response_thrust, thrust));
  if (!difference.known()) return "the thrust of the pairs' response is unknown: " + difference.reason;
  const double allowed = std::max(coupling_bias_errors * difference.standard_error, coupling_bias_rounding);
  if (std::abs(difference.value) <= allowed) return {};
  return fmt::format(
      "the numbers that beads keep have been chosen by the first solution, and piles solved from them follow another "
      "law: their response has the thrust ratio {} where that of the law is {}",
      value_with_error(response_thrust.value, estimate(response_thrust).standard_error),
      value_with_error(thrust.value, estimate(thrust).standard_error));
}

}  // namespace granuscope
