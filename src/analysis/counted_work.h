#pragma once
#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// What it took to draw an ensemble, from its counts.
CountedWork counted_work(const MeasuredEnsemble& ensemble);

}  // namespace granuscope
