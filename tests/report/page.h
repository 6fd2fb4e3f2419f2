#pragma once
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "kit/temporary_folder.h"
#include "report/page_reader.h"
#include "report/report.h"
#include "report/report_data.h"
#include "report/summary_json.h"

namespace granuscope {

/// The page of a report without figures; its keyed texts are held against summary.json.
struct Page {
  std::string html;
  std::map<std::string, std::string> texts;  ///< of each key

  explicit Page(const ReportData& data) {
    const test::TemporaryFolder run;
    const std::string summary = summary_json(data);
    html = html_report(data, nlohmann::ordered_json::parse(summary), run.path());
    for (const std::string& line : synthetic::differences(html, summary)) FAIL_CHECK(line);
    for (const auto& [key, text] : synthetic::keyed_texts(html)) texts[key] = text;
  }
};

/// The table of a class, from its start tag to its end tag; empty if there is none.
inline std::string table_of(const std::string& html, const std::string& name) {
  const std::size_t start = html.find("<table class=\"" + name + "\"");
  return start == std::string::npos ? "" : html.substr(start, html.find("</table>", start) - start);
}

}  // namespace granuscope
