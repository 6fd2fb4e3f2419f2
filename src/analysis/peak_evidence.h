#pragma once
#include <limits>

#include "analysis/layer_spectrum.h"
#include "analysis/shape_fit.h"

namespace granuscope {

/// Whether a response has two peaks or one, by likelihood ratios: differences of chi^2 with the noise of the ensemble.
struct PeakEvidence {
  /// chi^2 of the best single Gaussian minus that of the best two: at least 0 up to rounding.
  double against_one_gaussian = std::numeric_limits<double>::quiet_NaN();
  /// chi^2 of the best shape with one maximum minus that of the best one with two. Two mirror Gaussians have two maxima
  /// if and only if x_p > W; a single Gaussian is x_p = 0. Positive: two peaks are preferred.
  double for_two_peaks = std::numeric_limits<double>::quiet_NaN();
  /// Where there are sines to scale (LayerSpectrum::sines), chi^2 of cosines and sines of the best single Gaussian in
  /// the middle, which has none, minus that of the best peak beside it. Positive: the peak has moved, be it farther
  /// than W or not.
  double for_moved_peak = std::numeric_limits<double>::quiet_NaN();
};

/// `best` is the fit of two Gaussians to spectrum.whole; sines need the replicates of the spectrum.
PeakEvidence weigh_peaks(const LayerSpectrum& spectrum, const ShapeFit& best);

}  // namespace granuscope
