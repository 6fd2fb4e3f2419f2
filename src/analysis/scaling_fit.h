#pragma once
#include <array>

#include "analysis/estimate.h"

namespace granuscope {

/// A power law y = exp(intercept) x^exponent fitted on log-log axes.
struct ScalingFit {
  Estimate exponent;
  Estimate intercept;              ///< ln of the prefactor
  std::array<double, 2> window{};  ///< of mu, inclusive
  int points = 0;
};

}  // namespace granuscope
