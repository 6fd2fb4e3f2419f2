#pragma once
#include <filesystem>
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// The report as one self-contained HTML page: no network, no scripts, pictures inside as data: URIs, light or dark by
/// the reader's setting. Each number of the results carries data-key, a JSON pointer into `summary` (the text of
/// summary.json), and is formatted from the value found there. Figures are read from `run_folder`.
std::string html_report(const ReportData& data, const std::string& summary, const std::filesystem::path& run_folder);

}  // namespace granuscope
