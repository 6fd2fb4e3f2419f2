#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/double_gaussian.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "model/lattice.h"
#include "support/error.h"
#include "support/key.h"

namespace granuscope {
/// Where and how the response is fitted. All layers must be usable (those of beads are 0 .. layers - 21).
struct FitSpec {
  int first_layer = 58;  ///< of the window over which the slopes c and D are taken
  int last_layer = 179;
  int layer_step = 3;      ///< an odd step alternates the two row parities
  int shallow_layer = 16;  ///< fits are also made, for the figures only, from this layer down to the window
  double min_identifiable_width = 0.5;                       ///< bead diameters; below it the bead width hides W
  std::array<double, 2> scaling_window{0.1, 0.3};            ///< of mu, inclusive: beta, gamma, alpha
  std::vector<std::array<double, 2>> other_scaling_windows;  ///< shown beside it
};

inline constexpr int least_window_depths = 3;  ///< fewest depths from which a slope is taken

inline constexpr double least_identifiable_width = 0.1;  ///< bead diameters

/// [fit], bound to the spec.
std::vector<Key> keys_of(FitSpec& spec);

/// Layers recorded for a figure between the steps of the window take no part: drawing must not change a number.
bool at_step(const FitSpec& spec, int layer);
bool in_window(const FitSpec& spec, int layer);

/// The first number out of range on this lattice, of which so many layers at the bottom are not used.
Problem find_problem(const FitSpec& spec, const LatticeSpec& lattice, int unused = bottom_margin);

/// What a depth offers to a slope.
enum class DepthUse : std::uint8_t {
  fitted,
  other_shape,  ///< its response is no two Gaussians, as noise makes it seem now and then
  unidentified  ///< nothing, for any other reason
};

/// The depths that slopes are taken over, as indices in ascending order; `depths` are in the order of their layers. The
/// run reaches up from the deepest depth and ends at one that is unidentified, or at two neighbours of another shape. A
/// single one of these is left out: a run that ended there would have lost its depths to chance. Depths that are
/// unidentified are not left out one by one, since that would choose among those next to them by their noise.
std::vector<std::size_t> identifiable_depths(std::span<const DepthUse> depths);

struct ShapeFit {
  DoubleGaussian shape;
  double chi2 = 0;
  int degrees_of_freedom = 0;
  /// What the shape misses, beyond the noise, as a share of the response: root of the ratio of the sums of their
  /// squared modes. 0 where the noise hides it.
  double misfit = 0;
  double misfit_at_least = 0;  ///< the same, two of its standard errors lower
};

/// Least squares of the double Gaussian to the Fourier modes of the whole ensemble, each weighted with its noise as
/// measured at this layer, so that chi2 tells what the noise explains:
/// Levenberg-Marquardt (GSL) from `start`. On a ring x_p and columns - x_p are the same shape: the smaller one is
/// given. None if it does not converge.
std::optional<ShapeFit> fit_shape(const LayerSpectrum& spectrum, DoubleGaussian start);

/// The best shape on a coarse grid of positions up to 2 c0 z, or half the ring, and widths: a start that no local
/// minimum can fool.
DoubleGaussian coarse_shape(const LayerSpectrum& spectrum, double z);

/// What each Fourier mode counts in the fit that x_p and W are taken from. The response is not exactly two Gaussians,
/// so that x_p and W depend on the weights; these do not look at the noise, and mean the same for every estimator,
/// friction coefficient and size of an ensemble. Weighing by the noise instead moved D of one ensemble at mu = 0.4 from
/// 0.187 to 0.176 with the estimator; under `point`, 3461 piles at mu = 0.1 to 0.6, it makes errors of c smaller by a
/// factor of 1.1 to 1.3 and leaves those of D within 5 %.
enum class ModeWeights {
  /// exp(-k^2 (W^2 + 1)/4) with the fitted W itself and a bead: waves that see single beads count little where peaks
  /// are narrow.
  by_width,
  equal,  ///< plain least squares in x; for how much the weights matter
};

/// What ModeWeights::by_width lets a mode of wave number k count.
double weight_by_width(double k, double width);

/// The shape that fits `modes`, of the layer of `spectrum` from all or some of its blocks, by least squares under these
/// weights. Sines count as cosines do; those not to scale with the factor that fits best. On a ring the shape at
/// columns - x_p has the same cosines: the smaller one is given. None if that does not converge.
std::optional<DoubleGaussian> weighted_shape(const LayerSpectrum& spectrum, ResponseModes modes, ModeWeights weights,
                                             DoubleGaussian start);

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
