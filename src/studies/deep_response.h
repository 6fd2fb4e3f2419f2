#pragma once
#include <memory>
#include <vector>

#include "analysis/mean_response.h"
#include "studies/spreading.h"
#include "studies/study.h"

namespace granuscope {

/// Exponents against depth. Throws InputError where none is known.
Figure plot_deep_response(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// c and D against the wave number. Throws InputError where none is known.
Figure plot_dispersion(const std::vector<DeepResponse>& measured, const std::filesystem::path& run_folder);

/// How the peaks move and spread far below where the main line looks: whether W^2 stays proportional to z.
std::unique_ptr<Study> deep_response_study();

}  // namespace granuscope
