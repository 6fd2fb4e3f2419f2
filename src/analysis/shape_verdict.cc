#include "analysis/shape_verdict.h"

#include <fmt/format.h>

#include <cmath>

namespace granuscope {

double chi2_excess(const ShapeFit& fit) {
  return (fit.chi2 - fit.degrees_of_freedom) / std::sqrt(2.0 * fit.degrees_of_freedom);
}

std::string reason_against_two_gaussians(const ShapeFit& fit) {
  const double largest = fit.shape.width < narrow_peak ? largest_misfit_of_narrow_peaks : largest_misfit;
  if (!(chi2_excess(fit) > largest_chi2_excess && fit.misfit_at_least > largest)) return {};
  return fmt::format(
      "two Gaussians miss {:.0f} % of the response, more than {:.0f} % and more than its noise explains: it has "
      "another "
      "shape",
      100 * fit.misfit, 100 * largest);
}

std::string reason_against_identification(const ShapeFit& fit, const PeakEvidence& evidence, const FitSpec& spec) {
  if (std::string other_shape = reason_against_two_gaussians(fit); !other_shape.empty()) return other_shape;
  if (fit.shape.width < spec.min_identifiable_width) {
    return fmt::format("the fitted width {:.2f} is below {} bead diameters: the width of a bead hides it",
                       fit.shape.width, spec.min_identifiable_width);
  }
  // What goes to which side tells x_p from W also where the peaks overlap.
  if (evidence.for_moved_peak > least_evidence_for_two_peaks) return {};
  if (fit.shape.peak < fit.shape.width) {
    return "the two peaks are closer to the middle than their width: position and width cannot be told apart";
  }
  if (!(evidence.for_two_peaks > least_evidence_for_two_peaks)) {
    return fmt::format(
        "the noise leaves open whether there are two peaks or one: χ² differs by {:.1f}, and at least {} is required",
        evidence.for_two_peaks, least_evidence_for_two_peaks);
  }
  return {};
}

}  // namespace granuscope
