#include "report/html_report.h"

#include <nlohmann/json.hpp>

#include "report/mustache_page.h"
#include "report/report_view.h"
#include "support/template_file.h"

namespace granuscope {

std::string html_report(const ReportData& data, const std::string& summary, const std::filesystem::path& run_folder) {
  const auto numbers = nlohmann::ordered_json::parse(summary);
  return fill_page(template_file("report.html.mustache"), report_view(data, numbers, run_folder, PageMedium::screen));
}

}  // namespace granuscope
