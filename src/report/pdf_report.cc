#include "report/pdf_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>

#include "plot/scratch_folder.h"
#include "report/report_overlay.h"
#include "support/atomic_file.h"
#include "support/child_process.h"
#include "support/error.h"
#include "support/single_line.h"

namespace granuscope {

namespace {

/// WeasyPrint has no switch against it: a page, a style sheet or an SVG in it can have files of this computer attached,
/// or ask servers. All that is loaded passes Python's urlopen, which tells this hook. The folder that it makes shows
/// that it was there.
constexpr const char* hook_against_loading = R"(import os, sys
def refuse(event, arguments):
    if event == 'urllib.Request' and not str(arguments[0]).lower().startswith('data:'):
        raise PermissionError('a report holds all it needs, and loads nothing')
sys.addaudithook(refuse)
os.makedirs('loads-nothing', exist_ok=True)
)";

constexpr const char* install = "`apt-get install weasyprint fonts-dejavu-core` installs what it needs";

PdfOutcome failed(const std::string& why) {
  return {"", fmt::format("report.pdf was not written: {}. report.html holds the same, and can be printed.", why)};
}

/// Where Python says what went wrong, after telling where.
std::string_view last_line(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  return text.substr(text.rfind('\n') + 1);
}

bool ends_as_pdf(const std::string& bytes) {
  return bytes.starts_with("%PDF-") &&
         bytes.find("%%EOF", bytes.size() < 16 ? 0 : bytes.size() - 16) != std::string::npos;
}

}  // namespace

PdfOutcome pdf_report(const ReportData& data, const std::string& summary, const std::filesystem::path& run_folder,
                      double timeout_seconds) {
  if (!find_program("weasyprint")) return failed(fmt::format("WeasyPrint is not installed; {}", install));

  const auto numbers = nlohmann::ordered_json::parse(summary);
  const std::string page = report_page(data, numbers, run_folder, PageMedium::print);
  const ScratchFolder scratch(run_folder, "report-pdf");
  write_file(scratch.path() / "report.html", page);
  write_file(scratch.path() / "sitecustomize.py", hook_against_loading);  // Python runs it first

  ProcessSpec process;
  // The page holds all it needs. Without a base of our own WeasyPrint makes one of the folder's name, and gives up on a
  // name that is not UTF-8.
  process.arguments = {"weasyprint",    "--encoding", "utf-8",       "--base-url", "about:blank",
                       "--pdf-variant", "pdf/ua-1",   "report.html", "report.pdf"};
  process.working_folder = scratch.path();
  // A fixed date makes the same report the same bytes. Font caches go into the scratch folder, where they can be
  // written.
  process.environment = {{"LC_ALL", "C.UTF-8"},
                         {"SOURCE_DATE_EPOCH", "946684800"},
                         {"PYTHONPATH", "."},
                         {"PYTHONDONTWRITEBYTECODE", "1"},
                         {"HOME", scratch.path().string()},
                         {"XDG_CACHE_HOME", scratch.path().string()}};
  process.timeout_seconds = timeout_seconds;
  ProcessResult result;
  try {
    result = run_process(process);
  } catch (const EnvironmentError& error) {
    return failed(error.what());
  }
  if (result.timed_out) return failed(fmt::format("WeasyPrint was still running after {:.0f} s", timeout_seconds));
  if (result.exit_code != 0) {
    const std::string said = single_line(last_line(result.standard_error));
    return failed(fmt::format("WeasyPrint {}{}{}", describe_end(result), said.empty() ? "" : ": ", said));
  }
  // It ends with status 0 even if an image or a style sheet could not be loaded.
  if (result.standard_error.find("ERROR") != std::string::npos) {
    return failed("WeasyPrint could not load a part of the page: " + single_line(result.standard_error));
  }
  std::error_code error;
  if (!std::filesystem::exists(scratch.path() / "loads-nothing", error)) {
    return failed("this WeasyPrint could not be kept from loading files and pages of the web");
  }
  if (!std::filesystem::exists(scratch.path() / "report.pdf", error)) return failed("WeasyPrint left no file");
  PdfOutcome outcome;
  outcome.bytes = read_file(scratch.path() / "report.pdf");
  if (!ends_as_pdf(outcome.bytes)) return failed("WeasyPrint left a file that is cut off");
  return outcome;
}

}  // namespace granuscope
