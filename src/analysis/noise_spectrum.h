#pragma once
#include <vector>

namespace granuscope {

/// Measured variances of the Fourier modes of one layer, entry m-1 for mode m.
struct LayerVariances {
  double z = 0;
  std::vector<double> variance;
};

/// The noise of a mean response as a smooth function of wave number k and depth z. A pile changes a layer's weights by
/// random stresses, which spread below as waves of speed c0 = tan 30 degrees, damped as the response is, exp(-D k^2
/// z/2):
///   variance(k, z) = S(k) k^2 integral from 0 to z of du sin^2(c0 k u) exp(-D k^2 u),
/// growing as k^4 z^3 while the wave is longer than the depth (sum and first moment of a layer are exact), then to a
/// value that no longer depends on z. ln S is a polynomial of low degree in k, the same at all depths.
///
/// A fit divides its modes by it. The response is not exactly two Gaussians, so that x_p and W depend on what they are
/// divided by; a measured variance scatters by 25 % for 32 blocks, in the lowest modes even after any averaging over
/// neighbours, which differ tenfold, and over depths, which fluctuate together. In precise ensembles x_p followed that
/// scatter. The few numbers of this model scatter by some percent.
/// What did not help: polynomials of ln k and ln z (their ends follow the lowest modes); larger noise for the lowest
/// modes (loses what they know); one power of k (loses a tenth of the precision); cosines of k instead of the
/// polynomial (a little less precise).
class NoiseSpectrum {
 public:
  /// Fits S and D to variances of at least one layer, each with the same number of modes, on a ring of `columns`.
  /// Equal relative errors are assumed for all of them: maximum likelihood of gamma variables.
  NoiseSpectrum(int columns, const std::vector<LayerVariances>& layers);

  /// The same D with S fitted to other variances at the same depths, as of an ensemble without one of its blocks.
  NoiseSpectrum refitted(const std::vector<LayerVariances>& layers) const;

  /// Root of the variance of each mode at depth z.
  std::vector<double> standard_deviations(double z) const;

  double damping() const { return damping_; }  ///< D, bead diameters

 private:
  /// Sets S for a given damping; returns the deviance, mean of y - ln y - 1 with y = measured/fitted variance.
  double fit_spectrum(const std::vector<LayerVariances>& layers, double damping);

  int columns_;
  double damping_ = 0;
  std::vector<double> coefficients_;  ///< of ln S in Chebyshev's polynomials of k on 0 .. pi
};

}  // namespace granuscope
