#pragma once
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "analysis/jackknife.h"

namespace granuscope {

/// chi^2 of a straight line, or of a parabola, through several points, with their joint covariance.
struct LineTest {
  double chi2 = std::numeric_limits<double>::quiet_NaN();
  int degrees_of_freedom = 0;
  int points = 0;      ///< that took part
  std::string reason;  ///< not empty if and only if chi2 is unknown
};

/// chi^2 of the straight line through three points or more that share their blocks, with their joint covariance from
/// the replicates: what is left of y orthogonal to 1 and x, whichever line was fitted. The jackknife covariance of B
/// blocks follows Wishart's distribution with B - 1 degrees of freedom; the inverse of its part in those m - 2
/// directions is too large by (B - 1)/(B - m) on average, and is freed of that (Hartlap, Simon, Schneider, Astronomy &
/// Astrophysics 464, 399 (2007)). The mean of chi^2 is then m - 2; its tail is that of Hotelling's T^2, somewhat
/// heavier than that of chi^2. Unknown, with the reason, for fewer points, for more than B/2, and where the covariance
/// has no inverse.
LineTest test_line(std::span<const double> x, const std::vector<Replicated>& y);

/// The same of a parabola through four points or more.
LineTest test_parabola(std::span<const double> x, const std::vector<Replicated>& y);

}  // namespace granuscope
