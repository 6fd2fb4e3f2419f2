#pragma once
#include <cmath>

#include "model/lattice.h"

namespace granuscope {

/// The propagation coefficient that follows from the thrust ratio alone: c = tan 30 degrees sqrt(kappa).
inline double speed_from_thrust(double kappa) { return tan30 * std::sqrt(kappa); }

}  // namespace granuscope
