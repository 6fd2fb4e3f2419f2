#pragma once
#include <vector>

#include "analysis/fit_spec.h"
#include "analysis/fit_variations.h"
#include "analysis/jackknife.h"
#include "analysis/measured_ensemble.h"
#include "analysis/results.h"

namespace granuscope {

/// x_p/z and W^2/z at one layer, with replicates.
struct MeasuredRatios {
  int layer = 0;
  Replicated position, width_squared;
};

/// Exponents with replicates; empty where unknown.
struct ReplicatedExponents {
  Replicated position, width, amplitude, noise;
};

/// A Transport together with the replicates that later fits need.
struct MeasuredTransport {
  Transport transport;
  Replicated c, D, position_offset;         ///< empty if unknown
  std::vector<VariationSlopes> variations;  ///< as Transport::variations
  ReplicatedExponents exponents;
  std::vector<MeasuredRatios> ratios;  ///< at the identifiable ones of the profile layers
};

/// The layers that a FitSpec needs recorded, ascending, with `extra` (figures) merged in.
std::vector<int> layers_to_record(const FitSpec& spec, const std::vector<int>& extra);

/// Fits the response at every recorded layer, then x_p = x_0 + c z and W^2 = w_0 + D z over the window of `spec`, with
/// delete-one-block replicates through the whole chain. The window loses its shallow end where the width is not
/// identifiable, the last depth there by degrees (edge_of); the layers used are reported. Fits have weights
/// that do not look at the noise (depth_weights in depth_series.h, ModeWeights in weighted_shape.h).
/// `profile_layers`: layers to report as ResponseProfile. An ensemble without scatter (mu = 0) is measured by its
/// moments instead and marked exact. `threads`: 0 for as many as the machine has; the result does not depend on it.
MeasuredTransport measure_transport(const MeasuredEnsemble& ensemble, const FitSpec& spec,
                                    const std::vector<int>& profile_layers, int threads);

/// c and D of measure_transport alone, without errors and in a fraction of the time, for whoever has many ensembles to
/// take the scatter from. NaN where unknown. Those of the estimator paired as they come out, whatever law its piles
/// follow.
struct Slopes {
  double c = 0, D = 0;
};
Slopes measure_slopes(const MeasuredEnsemble& ensemble, const FitSpec& spec);

}  // namespace granuscope
