#pragma once
#include <array>

#include "analysis/estimate.h"
#include "analysis/line_test.h"

namespace granuscope {

/// An exponent that changes steadily: ln y is a parabola in ln x. Its slope at both ends of the points.
struct RunningExponent {
  double low = 0, high = 0;  ///< the ends, x itself
  Estimate at_low, at_high;
  LineTest scatter;  ///< of the points about the parabola; unknown where the exponents are

  /// Whether the points scatter about the parabola by no more than their errors allow.
  bool meets_the_points() const {
    return at_low.known() && scatter.degrees_of_freedom > 0 &&
           scatter.chi2 <= largest_chi2_per_dof * scatter.degrees_of_freedom;
  }
  static constexpr double largest_chi2_per_dof = 3;
};

/// A power law y = exp(intercept) x^exponent fitted on log-log axes.
struct ScalingFit {
  Estimate exponent;
  Estimate intercept;              ///< ln of the prefactor
  std::array<double, 2> window{};  ///< of mu, inclusive
  int points = 0;
  LineTest scatter;         ///< of the points about the law; unknown where the exponent is
  RunningExponent running;  ///< what they follow instead; unknown below four points

  /// Whether the points scatter about every power law by more than their errors: the exponent is then one between those
  /// of parts of the window, and its statistical error says nothing.
  bool misses_the_points() const {
    return scatter.degrees_of_freedom > 0 &&
           scatter.chi2 > RunningExponent::largest_chi2_per_dof * scatter.degrees_of_freedom;
  }
};

}  // namespace granuscope
