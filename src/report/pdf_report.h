#pragma once
#include <filesystem>
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// The report's bytes as PDF, or why there are none.
struct PdfOutcome {
  std::string bytes;
  std::string failure;  ///< one sentence; not empty if and only if bytes is empty
};

/// The content of html_report for print, made by WeasyPrint: contents with page numbers, bookmarks, vector plots. The
/// same data give the same bytes. A missing, failing or hanging WeasyPrint is an outcome, not an exception: the caller
/// decides. `run_folder` must be writable (a hidden folder is made there for the time of the call).
PdfOutcome pdf_report(const ReportData& data, const std::string& summary, const std::filesystem::path& run_folder,
                      double timeout_seconds = 300);

}  // namespace granuscope
