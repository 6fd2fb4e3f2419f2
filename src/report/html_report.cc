#include "report/html_report.h"

#include <nlohmann/json.hpp>

#include "report/report_overlay.h"

namespace granuscope {

std::string html_report(const ReportData& data, const std::string& summary, const std::filesystem::path& run_folder) {
  return report_page(data, nlohmann::ordered_json::parse(summary), run_folder, PageMedium::screen);
}

}  // namespace granuscope
