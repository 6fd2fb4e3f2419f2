#pragma once
#include <filesystem>

#include "analysis/results.h"
#include "plot/figure_captions.h"

namespace granuscope {

inline constexpr const char* main_finding_id = "main-finding";

/// Whether any exponent of slopes or ratios is known.
bool has_exponents(const Analysis& analysis);

/// Whether, beside that, at least two friction coefficients have a c below c_0, so that there is a law to look at.
bool has_main_finding(const Analysis& analysis);

/// What the report begins with: c_0 - c against mu, c read as a slope and as two ratios, and against D. Throws
/// InputError if there is nothing to show.
Figure plot_main_finding(const Analysis& analysis, const std::filesystem::path& run_folder);

}  // namespace granuscope
