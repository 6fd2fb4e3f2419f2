#pragma once
#include <array>
#include <vector>

#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {

/// The power laws of the paper over the friction coefficients inside `window` (inclusive): D = A mu^beta,
/// c0 - c = B mu^gamma, c0 - c = C D^alpha, each a straight line in the logarithms, all points of one weight. Results
/// without scatter and unknown ones take no part. Block b is left out at every mu at once, so that common random
/// numbers between friction coefficients are accounted for. Unknown, with the reason, below three points.
ScalingFits fit_scaling(const std::vector<MeasuredTransport>& results, std::array<double, 2> window);

/// The same with the systematic error of each exponent: its spread (systematic_spread) over the windows of depth and
/// the weights beside those of the fit (MeasuredTransport::variations; all friction coefficients at once, those without
/// such a variation keeping theirs) and over `window` without its lowest or highest friction coefficient, if three are
/// left.
struct ScalingWithVariations {
  ScalingFits fits;
  std::vector<ScalingVariation> variations;
};
ScalingWithVariations fit_scaling_with_variations(const std::vector<MeasuredTransport>& results,
                                                  std::array<double, 2> window);

/// fit_scaling from the ratios at one layer, by both depths, where they were measured (MeasuredTransport::ratios).
RatioScaling fit_ratio_scaling(const std::vector<MeasuredTransport>& results, int layer, std::array<double, 2> window);

}  // namespace granuscope
