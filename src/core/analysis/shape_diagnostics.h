#pragma once
#include <limits>
#include <string>

#include "analysis/fit_spec.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/shape_fit.h"
#include "model/lattice.h"

namespace granuscope {
/// What a fit of two Gaussians of area 1 leaves out, each from a fit with one more parameter beside x_p and W. Both
/// take the values 1 and 0 where the response is two Gaussians.
struct ShapeDiagnostics {
  /// Area A of A G(x), from the modes m > 0: the mode m = 0 knows it to be 1, so that A tells what the shape, continued
  /// to m = 0, makes of it.
  Replicated area;
  /// Share b of the response that lies spread evenly over |x| < x_p (x_p of `fit`): (1 - b) G + b/(2 x_p).
  Replicated background;
  double chi2_beside = 0;  ///< with such a background, of as many degrees of freedom less one as that of `fit`
  /// x_p and W^2 of the Gaussians beside such a background, by the weights that x_p and W are taken from.
  Replicated peak, width_squared;
};

/// `fit` is the fit to spectrum.whole by its noise, `shape` the one that x_p and W are taken from
/// (ModeWeights::by_width). The replicates follow from the fits linearised about them. Numbers are NaN where a fit does
/// not converge.
ShapeDiagnostics diagnose_shape(const LayerSpectrum& spectrum, const ShapeFit& fit, const DoubleGaussian& shape);

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

/// The share of a response that two Gaussians may miss before it counts as another shape, in two classes by the fitted
/// W. Each limit lies between what piles are missed by and what other shapes are (measured and held by
/// tests/analysis/shape_calibration_test.cc):
///   W >= 1: piles of every mu by 0.1 at most. Isotropic elastic responses by 0.13 to 0.18, boxes as wide as 3 beads or
///     more by 0.19 to 0.3, pairs of Lorentzians by 0.34 to 0.42, two peaks with a tenth of the response between them
///     by 0.17 (spread evenly) or 0.3 (as a third peak).
///   W < 1: the lattice shows in the peaks, and piles are missed by up to 0.2, under loads in runs of signs by up to
///     0.26 (mu = 0.07 to 0.15). There the limit has little power: boxes and pairs of Lorentzians that narrow are
///     missed by 0.19 and 0.24 and pass. It refuses what has two narrow peaks and something else beside them; a fifth
///     of the response between the peaks widens the fit beyond one bead and out of this class.
inline constexpr double largest_misfit = 0.12;
inline constexpr double largest_misfit_of_narrow_peaks = 0.3;
inline constexpr double narrow_peak = 1;  ///< W, bead diameters
/// How many of its standard deviations sqrt(2 dof) chi^2 must lie above dof. 4 leaves a true double Gaussian less than
/// 10^-3, though the noise itself is estimated and chi^2 is skewed (measured in tests/analysis/shape_verdict_test.cc).
inline constexpr double largest_chi2_excess = 4;

/// By how much chi^2 must prefer two peaks to one (PeakEvidence::for_two_peaks). Where the noise leaves it open, x_p >
/// W happens by chance: without this, one peak of W = 0.9 whose noise is a tenth of its height would count as two in
/// one case in five. Two standard deviations; two true peaks at x_p > 3 W pass as long as the fit means anything.
inline constexpr double least_evidence_for_two_peaks = 4;

/// (chi^2 - dof)/sqrt(2 dof).
double chi2_excess(const ShapeFit& fit);

/// Why a response is not two Gaussians, or nothing if it may be: both the noise cannot explain what the fit misses
/// (chi2_excess above largest_chi2_excess) and what it misses matters (largest_misfit for its W, beyond two standard
/// errors). Either alone will not do: chi^2 grows without end with the number of piles, whose response is not exactly
/// Gaussian, and with few piles the share is noise.
std::string reason_against_two_gaussians(const ShapeFit& fit);

/// Why x_p and W of a fit mean nothing, or nothing if they do: another shape, W hidden by the width of a bead, peaks
/// that have merged (x_p < W), or noise that leaves open whether they have. The last two only where no sines tell that
/// the peaks have moved (PeakEvidence::for_moved_peak).
std::string reason_against_identification(const ShapeFit& fit, const PeakEvidence& evidence, const FitSpec& spec);

/// Height of the response's peaks, per bead diameter and unit overload: the weight measured within W + 1/2 of
/// x = +-x_p, of beads at the edge in part, over what the fitted shape puts there, times the maximum of that shape. The
/// shape only carries the measured weight from beads to a point. `response` is the mean response of the layer,
/// [columns].
Replicated peak_height(const BlockMeans& response, const Lattice& lattice, int layer, const Replicated& peak,
                       const Replicated& width);

}  // namespace granuscope
