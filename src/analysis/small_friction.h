#pragma once
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// The number of layers over which the fluctuations of the forces saturate, 0.6/mu^2, measured on granusolve piles.
double saturation_layers(double mu);

/// The layers to record of uniformly loaded piles of `layers` layers: some spread evenly in ln z for a figure, and from
/// half of the usable depth on enough of them, of both row parities, for an average.
std::vector<int> thrust_layers(int layers);

/// SmallFriction with the replicates that a fit over several friction coefficients needs.
struct MeasuredSmallFriction {
  SmallFriction result;
  Replicated c0_minus_c;
};

/// The thrust ratio of a uniformly loaded ensemble by depth, and averaged over the lower half of the usable layers.
MeasuredSmallFriction measure_small_friction(const MeasuredEnsemble& ensemble);

/// tan30 - c_thrust as a power of mu over all ensembles, block b left out of all of them at once.
ScalingFit fit_small_friction(const std::vector<MeasuredSmallFriction>& measured);

}  // namespace granuscope
