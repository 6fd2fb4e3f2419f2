#pragma once
#include "analysis/estimate.h"

namespace granuscope {

/// The thrust ratio of uniformly loaded piles at one recorded layer.
struct ThrustAtDepth {
  int layer = 0;
  double z = 0;  ///< bead diameters
  Estimate thrust_ratio;
  Estimate weight_variance;  ///< <(w - 1)^2>
};

}  // namespace granuscope
