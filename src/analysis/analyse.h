#pragma once
#include <map>
#include <string>
#include <vector>

#include "analysis/fit_spec.h"
#include "analysis/results.h"
#include "analysis/transport.h"

namespace granuscope {

/// From ensembles to claims. Results come out ascending in mu.
Analysis analyse(const std::vector<MeasuredEnsemble>& ensembles, const FitSpec& spec,
                 const std::vector<int>& profile_layers, const std::map<std::string, std::string>& expected_verdicts,
                 int threads);

}  // namespace granuscope
