#include "plot/point_selection.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "support/number_format.h"

namespace granuscope {

const Transport* nearest_result(const std::vector<Transport>& results, double mu,
                                const std::function<bool(const Transport&)>& usable) {
  const Transport* nearest = nullptr;
  for (const Transport& result : results) {
    if (!usable(result)) continue;
    if (nearest == nullptr || std::abs(result.scanned() - mu) < std::abs(nearest->scanned() - mu)) nearest = &result;
  }
  return nearest;
}

bool in_window(double mu, const std::array<double, 2>& window) {
  constexpr double rounding = 1e-9;
  return mu >= window[0] - rounding && mu <= window[1] + rounding;
}

Analysis without_imprecise_points(const Analysis& analysis) {
  // Half of D still is a point on logarithmic axes; c is known to parts in a thousand wherever it means something.
  constexpr double imprecise_D = 0.5, imprecise_c = 0.05;
  const auto drop_if_imprecise = [](Estimate& estimate, double share) {
    if (!estimate.known()) estimate.reason = "why stands under the table of c and D";
    if (!estimate.known() || estimate.standard_error <= share * std::abs(estimate.value)) return;
    estimate.reason =
        fmt::format("too uncertain for a point: {}", value_with_error(estimate.value, estimate.standard_error));
    estimate.value = estimate.standard_error = std::numeric_limits<double>::quiet_NaN();
  };
  Analysis clear = analysis;
  for (Transport& result : clear.results) {
    drop_if_imprecise(result.c, imprecise_c);
    drop_if_imprecise(result.D, imprecise_D);
  }
  return clear;
}

}  // namespace granuscope
