#include "report/report.h"

#include <array>
#include <string>

#include "report/html_report.h"
#include "report/junit.h"
#include "report/markdown_summary.h"
#include "report/pdf_report.h"
#include "report/summary_json.h"
#include "support/atomic_file.h"
#include "support/error.h"

namespace granuscope {

ReportFiles files_in(const std::filesystem::path& run_folder) {
  ReportFiles files{run_folder / "summary.json",
                    run_folder / "claims.xml",
                    run_folder / "summary.md",
                    run_folder / "report.html",
                    std::nullopt,
                    ""};
  if (std::filesystem::exists(run_folder / "report.pdf")) files.pdf = run_folder / "report.pdf";
  return files;
}

namespace {

constexpr std::array report_names = {"summary.json", "summary.md", "claims.xml", "report.html", "report.pdf"};

std::filesystem::path set_aside(const std::filesystem::path& run_folder, const char* name) {
  return run_folder / (std::string("earlier-") + name);
}

/// A report in print of other numbers would pass for one of these, where none can be made of them.
void forget_report_of_others(const std::filesystem::path& run_folder, const std::string& summary) {
  const std::filesystem::path pdf = run_folder / "report.pdf", there = run_folder / "summary.json";
  std::error_code none;
  if (!std::filesystem::exists(pdf, none)) return;
  if (std::filesystem::is_regular_file(there, none) && read_file(there) == summary) return;
  std::filesystem::remove(pdf, none);
}

}  // namespace

void set_aside_report(const std::filesystem::path& run_folder) {
  for (const char* name : report_names) {
    std::error_code not_there;
    std::filesystem::rename(run_folder / name, set_aside(run_folder, name), not_there);
  }
}

ReportFiles write_report(const ReportData& data, const std::filesystem::path& run_folder, PdfPolicy pdf) {
  ReportFiles files;
  const std::string summary = summary_json(data);
  files.summary = run_folder / "summary.json";
  forget_report_of_others(run_folder, summary);
  write_file(files.summary, summary);
  files.claims = run_folder / "claims.xml";
  write_file(files.claims, junit_claims(data.analysis.claims, data.experiment_name));
  files.markdown = run_folder / "summary.md";
  write_file(files.markdown, markdown_summary(data));

  // The PDF comes before the page, which says so if there is none.
  ReportData told = data;
  PdfOutcome outcome;
  if (pdf == PdfPolicy::none) {
    files.pdf_skipped = "report.pdf was not asked for.";
  } else {
    outcome = pdf_report(data, summary, run_folder);
    files.pdf_skipped = outcome.failure;
  }
  if (!files.pdf_skipped.empty() && std::filesystem::exists(run_folder / "report.pdf")) {
    files.pdf_skipped += " The report.pdf in the folder is from an earlier run with the same numbers.";
  }
  if (!files.pdf_skipped.empty()) told.skipped.push_back(files.pdf_skipped);
  files.html = run_folder / "report.html";
  write_file(files.html, html_report(told, summary, run_folder));
  if (!outcome.bytes.empty()) {
    files.pdf = run_folder / "report.pdf";
    write_file(*files.pdf, outcome.bytes);
  }
  for (const char* name : report_names) {
    std::error_code not_there;
    std::filesystem::remove(set_aside(run_folder, name), not_there);
  }
  if (pdf == PdfPolicy::required && !files.pdf) throw EnvironmentError(files.pdf_skipped);
  return files;
}

}  // namespace granuscope
