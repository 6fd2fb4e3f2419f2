#pragma once

#include "analysis/jackknife.h"
#include "studies/study.h"

namespace granuscope {

/// The thrust ratio at a small friction coefficient, on narrow piles deep enough for the force fluctuations to
/// saturate (about 0.6/mu^2 layers).
struct SmallFriction {
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  double depth_over_saturation = 0;   ///< layers / (0.6/mu^2)
  std::vector<ThrustAtDepth> depths;  ///< ascending
  int first_layer = 0;                ///< of the deep part that the numbers below are averaged over
  int last_layer = 0;
  Estimate alpha_thrust;
  Estimate c_thrust;    ///< tan30 sqrt(alpha_thrust)
  Estimate c0_minus_c;  ///< tan30 - c_thrust, with the same error
};

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

/// The figure: saturation of the fluctuations with depth, and the slowing tan30 - c_thrust against mu beside that of
/// the main piles. Throws InputError where no thrust ratio is known.
Figure plot_small_friction(const Analysis& main, const std::vector<SmallFriction>& measured, const ScalingFit& scaling,
                           const std::filesystem::path& run_folder);

/// The thrust ratio at small friction, from uniformly loaded piles that are narrow and deep.
std::unique_ptr<Study> small_friction_study();

}  // namespace granuscope
