#pragma once
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "analysis/results.h"
#include "report/report_data.h"

namespace granuscope {
/// What to do about report.pdf, which needs WeasyPrint.
enum class PdfPolicy {
  none,         ///< not asked for
  if_possible,  ///< written where WeasyPrint works; otherwise reported as skipped, with the reason
  required,     ///< EnvironmentError if it cannot be written (every other file is written first)
};

/// What write_report left in the run's folder.
struct ReportFiles {
  std::filesystem::path summary;             ///< summary.json
  std::filesystem::path claims;              ///< claims.xml (JUnit)
  std::filesystem::path markdown;            ///< summary.md
  std::filesystem::path html;                ///< report.html
  std::optional<std::filesystem::path> pdf;  ///< report.pdf
  std::string pdf_skipped;                   ///< one sentence why there is no PDF; empty if there is one
};

/// The same of a report that is there already.
ReportFiles files_in(const std::filesystem::path& run_folder);

/// Renames the files of the report, and figures, that another experiment has left, from report.html to
/// earlier-report.html: under their own names they would pass for those of the run that begins, should it not come to
/// its end. The next report that is written removes them.
void set_aside_results(const std::filesystem::path& run_folder, std::set<std::string> figures);
/// The name that one of them gets.
std::filesystem::path set_aside(const std::filesystem::path& run_folder, const std::filesystem::path& file);

/// Writes summary.json, claims.xml, summary.md, report.html and report.pdf into `run_folder`, each whole or not at all.
/// Figures are read from `run_folder` by the relative paths they carry. Throws InputError for a figure that cannot be
/// read, EnvironmentError for files that cannot be written.
ReportFiles write_report(const ReportData& data, const std::filesystem::path& run_folder, PdfPolicy pdf);

/// The report as one self-contained HTML page: no network, no scripts, pictures inside as data: URIs, light or dark by
/// the reader's setting. Each number of the results carries data-key, a JSON pointer into `summary` (summary.json,
/// parsed), and is formatted from the value found there. Figures are read from `run_folder`.
std::string html_report(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder);

/// The numbers that matter as Markdown, for a pull request or a terminal. User text is escaped.
std::string markdown_summary(const ReportData& data, const Json& summary);

/// What was found, in a few lines for a terminal: c, D and c_thrust, exponents, verdicts. `summary_json`: a
/// summary.json that this version wrote; throws as PageScope for what is none.
std::string found_text(const std::string& summary_json);

/// One JUnit test case for each claim; a case fails only if its verdict is not the expected one, and a claim without an
/// expectation passes. One that is neither reproduced nor refuted, and not expected to be, is skipped. What is written
/// to the case begins with the verdict.
std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name);

}  // namespace granuscope
