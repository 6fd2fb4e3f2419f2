#pragma once
#include <vector>

#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {

/// Each exponent, averaged over the friction coefficients where it is known, with weights 1/(s^2 + tolerance^2): the
/// most precise one must not outvote the others beyond what the power law is trusted to hold
/// (ClaimSpec::exponent_tolerance). Block b is left out at every mu at once.
Exponents average_exponents(const std::vector<MeasuredTransport>& results, double tolerance);

/// The offset x_0 of x_p = x_0 + c z, averaged likewise with weights 1/s^2.
Estimate average_position_offset(const std::vector<MeasuredTransport>& results);

}  // namespace granuscope
