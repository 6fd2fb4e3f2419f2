#include "report/report.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

#include "report/page_overlays.h"
#include "report/page_scope.h"
#include "report/pdf_report.h"
#include "report/run_files.h"
#include "report/summary_json.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

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

/// A report in print of other numbers would pass for one of these, where none can be made of them.
void forget_report_of_others(const std::filesystem::path& run_folder, const std::string& summary) {
  const std::filesystem::path pdf = run_folder / "report.pdf", there = run_folder / "summary.json";
  if (!path_exists(pdf)) return;
  if (file_exists(there) && read_file(there) == summary) return;
  remove_if_there(pdf);
}

}  // namespace

fs::path set_aside(const fs::path& run_folder, const fs::path& file) {
  return run_folder / file.parent_path() / ("earlier-" + file.filename().string());
}

void set_aside_results(const fs::path& run_folder, std::set<std::string> figures) {
  figures.insert(report_names.begin(), report_names.end());
  std::error_code not_there;
  for (const std::string& file : figures) fs::rename(run_folder / file, set_aside(run_folder, file), not_there);
}

ReportFiles write_report(const ReportData& data, const std::filesystem::path& run_folder, PdfPolicy pdf) {
  ReportFiles files;
  const std::string summary = summary_json(data);
  const Json numbers = Json::parse(summary);
  files.summary = run_folder / "summary.json";
  // Who has closed an earlier report to others has closed the next one, too.
  const auto write = [&](const std::filesystem::path& file, const std::string& bytes) {
    write_file(file, bytes, set_aside(run_folder, file.filename()));
  };
  forget_report_of_others(run_folder, summary);
  write(files.summary, summary);
  files.claims = run_folder / "claims.xml";
  write(files.claims, junit_claims(data.analysis.claims, data.experiment_name));
  files.markdown = run_folder / "summary.md";
  write(files.markdown, markdown_summary(data, numbers));

  // The PDF comes before the page, which says so if there is none.
  ReportData told = data;
  PdfOutcome outcome;
  if (pdf == PdfPolicy::none) {
    files.pdf_skipped = "report.pdf was not asked for.";
  } else {
    outcome = pdf_report(data, numbers, run_folder);
    files.pdf_skipped = outcome.failure;
  }
  if (!files.pdf_skipped.empty() && std::filesystem::exists(run_folder / "report.pdf")) {
    files.pdf_skipped += " The report.pdf in the folder is from an earlier run with the same numbers.";
  }
  if (!files.pdf_skipped.empty()) told.skipped.push_back(files.pdf_skipped);
  files.html = run_folder / "report.html";
  write(files.html, html_report(told, numbers, run_folder));
  if (!outcome.bytes.empty()) {
    files.pdf = run_folder / "report.pdf";
    write(*files.pdf, outcome.bytes);
  }
  for (const char* name : report_names) remove_if_there(set_aside(run_folder, name));
  if (pdf == PdfPolicy::required && !files.pdf) throw EnvironmentError(files.pdf_skipped);
  return files;
}

std::string html_report(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder) {
  return report_page(data, summary, run_folder, PageMedium::screen);
}

std::string markdown_summary(const ReportData& data, const Json& summary) {
  Json overlay = {{"title", title_of(data)}};
  add_results(overlay, summary);
  add_claims(overlay, summary);
  add_numerics(overlay, summary);
  return fill_template_file("summary.md.mustache", PageScope(summary, overlay, Markup::markdown));
}

std::string found_text(const std::string& summary_json) {
  const auto summary = Json::parse(summary_json);
  if (summary.at("results").empty()) return "";
  Json overlay;
  add_results(overlay, summary);
  add_claims(overlay, summary);
  std::string text = fill_template_file("found.txt.mustache", PageScope(summary, overlay, Markup::plain));
  // Where there are no exponents, their place is empty.
  for (std::size_t at; (at = text.find("\n\n\n")) != std::string::npos;) text.erase(at, 1);
  return aligned(text);
}

namespace {

bool differs(const Claim& claim) { return !claim.expected.empty() && claim.verdict != claim.expected; }

/// Neither reproduced nor refuted: not decided or not tested, as expected.
bool undecided(const Claim& claim) {
  return claim.verdict != "reproduced" && claim.verdict != "not reproduced" && !differs(claim);
}

std::string markup(const std::string& text) { return escape_markup(clean_text(text)); }

}  // namespace

std::string junit_claims(const std::vector<Claim>& claims, const std::string& experiment_name) {
  std::string suite_name = markup(experiment_name);
  std::replace(suite_name.begin(), suite_name.end(), '\n', ' ');
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  const auto skipped = std::count_if(claims.begin(), claims.end(), undecided);
  xml += fmt::format("<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n", suite_name,
                     claims.size(), std::count_if(claims.begin(), claims.end(), differs), skipped);
  for (const Claim& claim : claims) {
    const std::string verdict = markup(claim.verdict), explanation = markup(claim.explanation);
    xml += fmt::format("  <testcase classname=\"claims\" name=\"{}\">", markup(claim.id));
    if (differs(claim)) {
      xml += fmt::format("<failure message=\"the verdict is {}, expected was {}\">{}</failure>", verdict,
                         markup(claim.expected), explanation);
    } else if (undecided(claim)) {
      xml += fmt::format("<skipped message=\"{}\"/>", verdict);
    }
    const std::string remarks = claim.remarks.empty() ? "" : " " + markup(claim.remarks);
    xml += fmt::format("<system-out>{}: {} {}{}</system-out></testcase>\n", verdict, markup(claim.statement),
                       explanation, remarks);
  }
  return xml + "</testsuite>\n";
}

}  // namespace granuscope
