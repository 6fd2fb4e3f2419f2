#pragma once
#include "analysis/jackknife.h"
#include "analysis/layer_spectrum.h"

namespace granuscope {

/// What is left of a response when its fit is taken away, and how much its blocks scatter: sums of squares over the
/// modes of a layer. Sums over layers add up.
struct ResidualNoise {
  Replicated residual;  ///< sum of (mean of all blocks - fit)^2
  Replicated scatter;   ///< mean over blocks of the sum of (mean of the block - mean of all blocks)^2
};

/// `peak` and `width` are the fit with its replicates.
ResidualNoise residual_noise(const LayerSpectrum& spectrum, const Replicated& peak, const Replicated& width);

/// a += b, component by component; an empty `a` becomes b.
void add(ResidualNoise& a, const ResidualNoise& b);

/// The power with which the rms residual about the fit falls with the number N of piles averaged, over sub-ensembles of
/// B, B/2, B/4, ... 1 of the B blocks: the slope of its logarithm on ln N, every size weighted alike. The mean square
/// over all choices of k of the B blocks is known without drawing any:
///   residual + (B - k)/(k (B - 1)) scatter.
/// -1/2 if the residual is nothing but noise of independent piles; nearer to 0 if the shape fitted is not the
/// response's.
Replicated noise_exponent(const ResidualNoise& noise);

}  // namespace granuscope
