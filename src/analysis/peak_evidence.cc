#include "analysis/peak_evidence.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace granuscope {
namespace {

constexpr double narrowest = 0.3;         ///< bead diameters
constexpr double coarse_step = 1.4;       ///< ratio of neighbouring widths of the scan
constexpr double width_precision = 1e-4;  ///< relative; chi^2 is flat to second order at its minimum

/// chi^2 of two Gaussians at distance x_p = ratio W, as a function of W.
class TiedShape {
 public:
  TiedShape(const LayerSpectrum& spectrum, double ratio)
      : spectrum_(spectrum), ratio_(ratio), modes_(spectrum.whole.size()) {}

  double chi2(double width) {
    fourier_modes({ratio_ * width, width}, spectrum_.columns, spectrum_.half_shifted, modes_);
    double sum = 0;
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      const double residual = (modes_[i].value - spectrum_.whole[i]) / spectrum_.noise[i];
      sum += residual * residual;
    }
    return sum;
  }

  /// Smallest chi^2 over all widths: a scan that no local minimum can fool, then a golden section.
  double least_chi2(double widest) {
    double best_width = narrowest, best = chi2(narrowest);
    double width = narrowest * coarse_step;
    while (width < widest) {
      if (const double value = chi2(width); value < best) {
        best = value;
        best_width = width;
      }
      width *= coarse_step;
    }
    constexpr double golden = 0.6180339887498949;
    double low = best_width / coarse_step, high = best_width * coarse_step;
    double left = high - golden * (high - low), right = low + golden * (high - low);
    double at_left = chi2(left), at_right = chi2(right);
    while (high - low > width_precision * best_width) {
      if (at_left < at_right) {
        high = right;
        right = left;
        at_right = at_left;
        left = high - golden * (high - low);
        at_left = chi2(left);
      } else {
        low = left;
        left = right;
        at_left = at_right;
        right = low + golden * (high - low);
        at_right = chi2(right);
      }
    }
    return std::min({best, at_left, at_right});
  }

 private:
  const LayerSpectrum& spectrum_;
  double ratio_;
  std::vector<ModeValue> modes_;
};

}  // namespace

PeakEvidence weigh_peaks(const LayerSpectrum& spectrum, const ShapeFit& best) {
  const double widest = 0.5 * spectrum.columns;
  const double one_gaussian = TiedShape(spectrum, 0).least_chi2(widest);
  const double edge = TiedShape(spectrum, 1).least_chi2(widest);
  PeakEvidence evidence;
  evidence.against_one_gaussian = one_gaussian - best.chi2;
  const bool two_peaks = best.shape.peak > best.shape.width;
  // The edge belongs to both sides; a search that missed a shallow minimum cannot make either side worse than it.
  const double with_one = two_peaks ? std::min(one_gaussian, edge) : std::min({best.chi2, one_gaussian, edge});
  const double with_two = two_peaks ? std::min(best.chi2, edge) : edge;
  evidence.for_two_peaks = with_one - with_two;
  return evidence;
}

}  // namespace granuscope
