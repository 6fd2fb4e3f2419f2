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

}  // namespace granuscope
