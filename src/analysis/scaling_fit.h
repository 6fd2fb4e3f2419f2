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

  /// Whether the points scatter about every power law by more than their errors: the exponent is then one between those
  /// of parts of the window, and its statistical error says nothing.
  bool misses_the_points() const {
    return scatter.degrees_of_freedom > 0 && scatter.chi2 > largest_chi2_per_dof * scatter.degrees_of_freedom;
  }
  static constexpr double largest_chi2_per_dof = 3;
};

}  // namespace granuscope
