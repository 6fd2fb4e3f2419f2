#pragma once
#include <cstddef>
#include <vector>

#include "analysis/jackknife.h"
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

}  // namespace granuscope
