#pragma once
#include <cmath>

#include "model/lattice.h"

namespace granuscope {

/// The propagation coefficient that follows from the thrust ratio alone: c = tan 30 degrees sqrt(alpha).
inline double speed_from_thrust(double alpha) { return tan30 * std::sqrt(alpha); }

}  // namespace granuscope
