#pragma once
#include <string>

#include "analysis/shape_fit.h"

namespace granuscope {

/// The share of a response that two Gaussians may miss before it counts as another shape. granusolve piles of every mu
/// are missed by 0.1 at most where W is above one bead; where it is narrower, the lattice shows and they are missed by
/// up to 0.16 (linear response, mu = 0.1, W = 0.57). The isotropic elastic response is missed by 0.16 to 0.20,
/// depending on which modes the noise leaves, pairs of Lorentzians by 0.37, two peaks with 30 % of the response between
/// them by 0.6. Below one bead the limit is far off, for loads in runs of signs and paired piles are missed by more
/// there: it refuses what has nothing of two peaks, no more.
inline constexpr double largest_misfit = 0.12;
inline constexpr double largest_misfit_of_narrow_peaks = 0.4;
inline constexpr double narrow_peak = 1;  ///< W, bead diameters
/// How many of its standard deviations sqrt(2 dof) chi^2 must lie above dof. 4 leaves a true double Gaussian less than
/// 10^-3, though the noise itself is estimated and chi^2 is skewed (measured in tests/analysis/shape_verdict_test.cc).
inline constexpr double largest_chi2_excess = 4;

/// (chi^2 - dof)/sqrt(2 dof).
double chi2_excess(const ShapeFit& fit);

/// Why a response is not two Gaussians, or nothing if it may be: both the noise cannot explain what the fit misses
/// (chi2_excess above largest_chi2_excess) and what it misses matters (largest_misfit for its W, beyond two standard
/// errors). Either alone will not do: chi^2 grows without end with the number of piles, whose response is not exactly
/// Gaussian, and with few piles the share is noise.
std::string reason_against_two_gaussians(const ShapeFit& fit);

}  // namespace granuscope
