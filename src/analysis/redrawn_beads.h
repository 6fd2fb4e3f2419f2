#pragma once
#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// The shares of beads that had to draw another number, over the usable layers (0 .. layers - 21) of an ensemble of the
/// estimator "paired", with standard errors by the jackknife over its blocks. All usable layers must be recorded;
/// throws InputError otherwise. Unknown, with the reason, where a block holds no completed pair.
RedrawnBeads measure_redrawn_beads(const MeasuredEnsemble& ensemble);

}  // namespace granuscope
