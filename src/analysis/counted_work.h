#pragma once
#include "analysis/side_measurements.h"
#include "analysis/transport.h"

namespace granuscope {

/// What it took to draw an ensemble, from its counts.
CountedWork counted_work(const MeasuredEnsemble& ensemble);

}  // namespace granuscope
