#pragma once
#include <vector>

#include "analysis/layer_spectrum.h"
#include "coupled_peak.h"
#include "studies/spreading.h"

namespace granuscope {

/// A solution of the mode-coupling equation, referred to layers at the depth `reference` below the base.
struct ReferredPeak {
  const CoupledPeak& solution;
  double reference = 0;
};

/// How much better another shape of the peaks describes one lag than Gaussians do.
struct PeakShapeTest {
  double z = 0;
  int degrees_of_freedom = 0;
  double gaussian = 0, kpz = 0, coupled = 0;  ///< chi^2 with x_p and W free
};

/// Holds the modes of one lag against the three shapes, each with the x_p and W that suit it best.
PeakShapeTest test_shape(const LayerSpectrum& spectrum, const LagResponse& lag, ReferredPeak coupled);

/// One of the two peaks, scaled by its own x_p and W to variance and area 1.
struct ScaledPeak {
  double z = 0;
  std::vector<double> x;         ///< (x - x_p)/W
  std::vector<Estimate> height;  ///< 2 W P
};

/// By cosines and sines, which know the one peak from the other, however near that is on the ring.
ScaledPeak scaled_peak(const LayerSpectrum& spectrum, const LagResponse& lag);
ScaledPeak scaled_peak(ReferredPeak coupled, double z);

}  // namespace granuscope
