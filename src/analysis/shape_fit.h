#pragma once
#include <optional>
#include <string>

#include "analysis/double_gaussian.h"
#include "analysis/layer_spectrum.h"

namespace granuscope {

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

/// The best shape on a coarse grid of positions up to 2 tan30 z, or half the ring, and widths: a start that no local
/// minimum can fool.
DoubleGaussian coarse_shape(const LayerSpectrum& spectrum, double z);

}  // namespace granuscope
