#include "analysis/analyse.h"

#include <algorithm>
#include <utility>

#include "analysis/claims.h"
#include "analysis/scaling.h"

namespace granuscope {

Analysis analyse(std::vector<MeasuredTransport> measured, const FitSpec& fit, const ClaimSpec& claims) {
  std::ranges::sort(measured, [](const MeasuredTransport& a, const MeasuredTransport& b) {
    return a.transport.scanned() < b.transport.scanned();
  });
  Analysis analysis;
  for (const MeasuredTransport& result : measured) analysis.results.push_back(result.transport);
  if (!measured.empty()) analysis.scan = measured.front().transport.scan;
  ScalingWithVariations scaling = fit_scaling_with_variations(measured, fit.scaling_window);
  analysis.scaling = std::move(scaling.fits);
  analysis.variations = std::move(scaling.variations);
  for (const auto& window : fit.other_scaling_windows) analysis.other_windows.push_back(fit_scaling(measured, window));
  analysis.mean_exponents = average_exponents(measured, claims.exponent_tolerance);
  analysis.mean_position_offset = average_position_offset(measured);
  analysis.claims = judge_claims(analysis, fit, claims);
  return analysis;
}

}  // namespace granuscope
