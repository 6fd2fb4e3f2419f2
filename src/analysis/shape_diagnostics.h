#pragma once
#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"
#include "analysis/shape_fit.h"

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

}  // namespace granuscope
