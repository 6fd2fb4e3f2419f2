#pragma once
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "storage/block_sums.h"

namespace granuscope {
/// A number with its standard error (one standard deviation, delete-one-block jackknife), or the reason why unknown.
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  double standard_error = std::numeric_limits<double>::quiet_NaN();
  std::string reason;  ///< not empty if and only if the value is unknown
  /// How far it depends on the window and the weights it was fitted with (transport.h); NaN where that was not
  /// measured.
  double systematic = std::numeric_limits<double>::quiet_NaN();

  bool known() const { return std::isfinite(value); }
};

/// As the function of this name in support/plain_text.h writes it; "n/a" if unknown.
std::string value_with_error(const Estimate& number);
/// The same, but "unknown" if unknown.
std::string in_words(const Estimate& number);

/// A number computed from the whole ensemble, and again from the ensemble without each of its blocks. Whatever is
/// computed from such numbers goes through `transform`, so that its error knows all correlations.
struct Replicated {
  double value = 0;
  std::vector<double> without_block;  ///< one entry per block
};

/// Delete-one jackknife: se^2 = (B-1)/B sum_b (theta_b - mean)^2. Unknown, with the reason, if any entry is not finite.
Estimate estimate(const Replicated& number,
                  const std::string& reason_if_unknown = "it is unknown without one of the blocks of piles");

/// f applied to the whole-ensemble values and to each set of replicates. All arguments have the same blocks.
template <typename F, typename... Numbers>
Replicated transform(F f, const Replicated& first, const Numbers&... others) {
  Replicated result;
  result.value = f(first.value, others.value...);
  result.without_block.reserve(first.without_block.size());
  for (std::size_t b = 0; b < first.without_block.size(); ++b) {
    result.without_block.push_back(f(first.without_block[b], others.without_block[b]...));
  }
  return result;
}

/// The same for a function of one set of numbers (one per depth, per friction coefficient, ...).
Replicated transform_all(const std::vector<Replicated>& numbers,
                         const std::function<double(const std::vector<double>&)>& f);

/// The mean over at least one number.
Replicated mean_of(const std::vector<Replicated>& numbers);

/// y = intercept + slope x.
struct Line {
  double intercept = 0, slope = 0;
};

/// Least squares line through at least two points with weights (1/variance; any common factor), by a QR decomposition.
Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights);

/// y = intercept + slope x + curvature x^2.
struct Parabola {
  double intercept = 0, slope = 0, curvature = 0;
};

/// The same through at least three points.
Parabola fit_parabola(std::span<const double> x, std::span<const double> y, std::span<const double> weights);

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

/// The chance of a larger chi^2 than that of a test over so many blocks, by the law of T^2.
double chance_of(const LineTest& test, std::size_t blocks);

/// Whether an ensemble has what every sample of the flat law has, see sampling/polytope.h.
struct FlatTest {
  std::vector<Estimate> means;  ///< of flat_tests over all recorded layers, each 0 on average; none of other laws
  LineTest all_zero;            ///< of all of them together
  double chance = std::numeric_limits<double>::quiet_NaN();
};

/// Blocks are independent however far the piles of a chain are not, so that the chance is uniform under the flat law as
/// far as means over blocks are normal. Unknown, with the reason, where the last chain is incomplete.
FlatTest test_flat_law(const BlockSums& sums);

/// How many independent piles would have given the ensemble's standard errors: variance of one pile over the variance
/// of the mean (jackknife over blocks), each summed over the layers in which the quantity scatters; the smaller number
/// of "thrust" and "weight_variance". The number of samples for independent ones, less for a chain. Its relative
/// standard error is sqrt(2/(blocks - 1)) or less, depending on how many layers are independent; that of one layer is
/// stated. Unknown, with the reason, without blocks enough or without scatter.
Estimate effective_samples(const BlockSums& sums);

}  // namespace granuscope
