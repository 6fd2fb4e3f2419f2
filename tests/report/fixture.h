#pragma once
#include <filesystem>

#include "report/report_data.h"

namespace granuscope::synthetic {

/// Everything a report says, made up (tests/plot/synthetic_analysis.h), with the three plots and a raster picture drawn
/// into `run_folder`. The user's texts are harmless.
ReportData report_data(const std::filesystem::path& run_folder);

/// Texts that try to leave their place: markup, mustache, quotes, back-ticks, line breaks, bytes that are not UTF-8.
std::string hostile_text();

}  // namespace granuscope::synthetic
