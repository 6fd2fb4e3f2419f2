#include "analysis/peak_evidence.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "analysis/weighted_shape.h"

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

/// Standard errors of the sines.
std::vector<double> noise_of_sines(const BlockMeans& sines) {
  std::vector<double> noise;
  for (std::size_t m = 0; m < sines.whole.size(); ++m) {
    Replicated sine{sines.whole[m], {}};
    for (const auto& without : sines.without_block) sine.without_block.push_back(without[m]);
    noise.push_back(estimate(sine).standard_error);
  }
  return noise;
}

/// What chi^2 of cosines and sines prefers a peak beside the middle by to the best one in the middle, whose cosines
/// have chi^2 `in_the_middle`. The cosines of `best` are those of its image across the ring, too; where they tell no
/// peak from two, the shape that x_p and W are taken from is nearer.
double weigh_motion(const LayerSpectrum& spectrum, double in_the_middle, const DoubleGaussian& best) {
  const std::vector<double>&of_sines = spectrum.sines.whole, noise = noise_of_sines(spectrum.sines);
  std::vector<ModeValue> cosines(spectrum.whole.size()), sines(of_sines.size());
  const auto chi2_at = [&](double peak, double width) {
    fourier_modes({peak, width}, spectrum.columns, spectrum.half_shifted, cosines, sines);
    double sum = 0;
    for (std::size_t i = 0; i < cosines.size(); ++i) {
      sum += std::pow((cosines[i].value - spectrum.whole[i]) / spectrum.noise[i], 2);
    }
    for (std::size_t i = 0; i < sines.size(); ++i) sum += std::pow((sines[i].value - of_sines[i]) / noise[i], 2);
    return sum;
  };
  const DoubleGaussian weighted =
      weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, best).value_or(best);
  double moved = in_the_middle;
  for (std::size_t i = 0; i < noise.size(); ++i) moved += std::pow(of_sines[i] / noise[i], 2);
  const double middle = moved;
  for (const DoubleGaussian& shape : {best, weighted}) {
    moved = std::min({moved, chi2_at(shape.peak, shape.width), chi2_at(spectrum.columns - shape.peak, shape.width)});
  }
  return middle - moved;
}

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
  if (!spectrum.sines.whole.empty() && spectrum.sines_to_scale)
    evidence.for_moved_peak = weigh_motion(spectrum, one_gaussian, best.shape);
  return evidence;
}

}  // namespace granuscope
