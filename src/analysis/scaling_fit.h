#pragma once
#include <array>
#include <limits>

#include "analysis/estimate.h"

namespace granuscope {

/// A power law y = exp(intercept) x^exponent fitted on log-log axes.
struct ScalingFit {
  Estimate exponent;
  Estimate intercept;              ///< ln of the prefactor
  std::array<double, 2> window{};  ///< of mu, inclusive
  int points = 0;
  /// Of the points about the law, with points - 2 degrees of freedom; the friction coefficients taken for independent.
  /// NaN where the exponent is unknown.
  double chi2 = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace granuscope
