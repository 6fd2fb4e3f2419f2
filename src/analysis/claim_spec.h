#pragma once

namespace granuscope {

/// Thresholds of the claims' tests beside the rule for numbers (claim_rule.h). They stand in the experiment file,
/// chosen before the numbers.
struct ClaimSpec {
  /// Difference in chi^2 from which one shape counts as preferred over another: five standard deviations, so that some
  /// hundred depths together meet it by chance once in 10^4 experiments.
  double decisive_chi2 = 25;
  /// The friction coefficient that an experiment must reach for what the paper claims "up to mu about 1.7".
  double highest_mu = 1.7;
  /// Share of the response that two Gaussians which describe a profile well may leave out.
  double largest_remainder = 0.05;
  /// Standard error granted to the exponent of a law that holds asymptotically, where the window ends at a finite
  /// depth.
  double exponent_tolerance = 0.02;
};

}  // namespace granuscope
