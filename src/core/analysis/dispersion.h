#pragma once
#include <cstddef>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "storage/block_sums.h"

namespace granuscope {
/// How fast the Fourier modes of a band travel and decay over a stretch of depth.
struct BandOfModes {
  double k_from = 0, k_to = 0;  ///< edges, radians per bead diameter
  double k = 0;                 ///< root mean square of the modes' wave numbers
  int modes = 0;
  double z_from = 0, z_to = 0;  ///< bead diameters below the base layers' reference
  Estimate c, D;
};

/// Rough values from which the fit of a band starts.
struct RoughPropagation {
  double c = 0, D = 0;
};

/// The dispersion relation between the recorded lags number `above` and `below` of an ensemble of the estimator
/// fluctuation. A deviation of w and H handed down from the one lag to the other is multiplied by
///   G = C_below C_above^-1 = exp(-k^2 D z / 2) [cos(c k z) - i sin(c k z) ((0, 1/s), (s, 0))]
/// for two modes of sound, z the depth between the lags and s the ratio of the two fields' amplitudes; both lags have
/// the same amplitudes and offsets, which therefore drop out. c and D of a band are the least squares of all elements
/// of G over its modes; errors from the jackknife over blocks. Bands between successive `edges` (ascending) that hold
/// no mode known at both lags are left out; c and D are unknown where the fit does not converge.
std::vector<BandOfModes> measure_dispersion(const BlockSums& sums, std::size_t above, std::size_t below,
                                            const std::vector<double>& edges, RoughPropagation rough);

/// Edges 1, 2^-1/2, 1/2, ... down to the first mode of a ring, ascending.
std::vector<double> half_octave_bands(int columns);

/// Bands of half an octave, ascending, each over the deepest pair of successive lags at whose end it has kept most of
/// its amplitude: there its decay stands out of the noise. (To take the pair with the least error would favour errors
/// that are small by chance.) `D`: rough values from lag number i + 1 to i + 2; pairs where it is not finite are passed
/// over, and bands left out that no pair tells.
std::vector<BandOfModes> dispersion_of_lags(const BlockSums& sums, double c, const std::vector<double>& D);

/// Whether the sums are those of the estimator fluctuation: correlations of layers instead of a response.
bool holds_propagation(const BlockSums& sums);

/// The sums of "propagation" of recorded lag number `row`.
LayerSums propagation_at(const BlockSums& sums, std::size_t row);

/// Their totals over all blocks but one, or over all if `left_out` is blocks(): correlation_parts
/// (ensemble/group_fourier.h) for each of the modes 1, 2, ... that carry weight there.
std::vector<double> propagation_without(const LayerSums& propagation, std::size_t left_out);

/// G = C_below C_above^-1 of one mode: its diagonal, and the imaginary parts of its corners. In a scalar model w is
/// alone.
struct ModePropagator {
  double ww, HH, wH, Hw;
};

/// From the correlation_parts of one mode at two lags.
ModePropagator mode_propagator(const double* below, const double* above);

/// Fourier modes of a peak that moves towards +x. Two modes of sound, which move to either side, make
///   G = exp(-k^2 W^2/2) [cos(k x_p) - i sin(k x_p) ((0, 1/s), (s, 0))],
/// s the ratio of the sizes of H and w.
struct PropagatedModes {
  BlockMeans cosines;  ///< half the trace of G: of the response to a load, half of which moves to either side
  BlockMeans sines;    ///< half of -(s G_wH + G_Hw/s); none in a scalar model
};

/// Those over recorded lag number `row`, G = C_{r+l} C_r^-1 (ensemble/estimator.h) being made from sums
/// over blocks, never from ratios of one block. As many modes as carry weight there; none where nothing fluctuates. The
/// (w, w) element alone would be that of peaks shifted by (G_ww - G_HH)/(2 k sin(k x_p)): 0.005, 0.07 and 0.2 bead at
/// mu = 0.1, 0.3 and 0.5, and up to a bead in waves that are not saturated. At 0.5 the error of c was 1.6 times larger
/// with it.
PropagatedModes propagated_modes(const BlockSums& sums, std::size_t row);

/// The mean response in x that the cosines make, modes without weight being 0; entry i belongs to bead i, the loaded
/// bead being Lattice::middle().
BlockMeans propagated_response(const BlockSums& sums, std::size_t row);

}  // namespace granuscope
