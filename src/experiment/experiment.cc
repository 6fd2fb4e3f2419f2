#include "experiment/experiment.h"

#include <algorithm>
#include <cmath>

#include "analysis/small_friction.h"

namespace granuscope {

int SmallFrictionSpec::layers(double friction) const {
  // Far more than any pile may have stays a number, which the check then refuses.
  return static_cast<int>(std::min(std::ceil(depth * saturation_layers(friction)) + bottom_margin, 2e9));
}

}  // namespace granuscope
