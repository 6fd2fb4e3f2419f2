#pragma once
#include "analysis/estimate.h"
#include "storage/ensemble_file.h"

namespace granuscope {

/// The thrust ratio alone: it needs no profiles and no fit, only uniformly loaded piles.
struct MeasuredThrust {
  Estimate alpha_thrust;
  Estimate c_thrust;  ///< tan30 sqrt(alpha_thrust)
};

/// Averaged over all recorded layers. Unknown, with the reason, where a block holds no completed pile.
MeasuredThrust measure_thrust(const EnsembleRecord& record);

}  // namespace granuscope
