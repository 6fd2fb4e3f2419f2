#pragma once
#include <map>
#include <string>
#include <vector>

#include "analysis/claim_spec.h"
#include "analysis/fit_spec.h"
#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {

/// From the measured friction coefficients to exponents and claims. Results come out ascending in mu.
/// `ratio_layers`: where exponents are also taken from ratios instead of slopes. `side`: what was measured beside the
/// main ensembles; claims whose measurement is missing stay undetermined.
Analysis analyse(std::vector<MeasuredTransport> measured, SideMeasurements side, const FitSpec& fit,
                 const ClaimSpec& claims, const std::vector<int>& ratio_layers,
                 const std::map<std::string, std::string>& expected_verdicts);

}  // namespace granuscope
