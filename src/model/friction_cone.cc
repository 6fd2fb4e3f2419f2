#include "model/friction_cone.h"

#include <fmt/format.h>

#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {

FrictionCone::FrictionCone(double mu) : mu_(mu) {
  if (!(mu >= 0 && mu < sqrt3)) {
    throw InputError(fmt::format(
        "friction coefficient {} is out of range: the law is defined for 0 <= mu < sqrt(3) = 1.7320508, where the cone "
        "of admissible forces stays below the horizontal",
        mu));
  }
  t_minus_ = (tan30 - mu) / (1 + mu * tan30);
  t_plus_ = (tan30 + mu) / (1 - mu * tan30);
  k_ = sqrt3 * (t_minus_ + t_plus_) - 1;
  t_minus_over_k_ = t_minus_ / k_;
  t_plus_over_k_ = t_plus_ / k_;
}

}  // namespace granuscope
