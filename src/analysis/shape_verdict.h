#pragma once
#include <string>

#include "analysis/fit_spec.h"
#include "analysis/peak_evidence.h"
#include "analysis/shape_fit.h"

namespace granuscope {

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

}  // namespace granuscope
