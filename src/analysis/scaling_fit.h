#pragma once
#include <array>

#include "analysis/estimate.h"
#include "analysis/line_test.h"

namespace granuscope {

/// A power law y = exp(intercept) x^exponent fitted on log-log axes.
struct ScalingFit {
  Estimate exponent;
  Estimate intercept;              ///< ln of the prefactor
  std::array<double, 2> window{};  ///< of mu, inclusive
  int points = 0;
  LineTest scatter;  ///< of the points about the law; unknown where the exponent is
};

}  // namespace granuscope
