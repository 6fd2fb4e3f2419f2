#pragma once
#include <optional>
#include <span>
#include <string>

#include "analysis/double_gaussian.h"
#include "analysis/layer_spectrum.h"

namespace granuscope {

struct ShapeFit {
  DoubleGaussian shape;
  double chi2 = 0;
  int degrees_of_freedom = 0;
  /// What the shape misses, beyond the noise, as a share of the response: root of the ratio of their squared modes.
  double misfit = 0;
};

/// Least squares of the double Gaussian to Fourier modes (shape of spectrum.noise), each weighted with its noise:
/// Levenberg-Marquardt (GSL) from `start`. None if it does not converge.
std::optional<ShapeFit> fit_shape(const LayerSpectrum& spectrum, std::span<const double> modes, DoubleGaussian start);

/// The best shape on a coarse grid of positions up to 2 tan30 z and widths: a start that no local minimum can fool.
DoubleGaussian coarse_shape(const LayerSpectrum& spectrum, double z);

}  // namespace granuscope
