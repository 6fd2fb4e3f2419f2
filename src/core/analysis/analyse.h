#pragma once
#include <vector>

#include "analysis/fit_spec.h"
#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {

/// From the measured ensembles, all of one scan, to exponents and claims. Results come out ascending in its parameter.
Analysis analyse(std::vector<MeasuredTransport> measured, const FitSpec& fit, const ClaimSpec& claims);

}  // namespace granuscope
