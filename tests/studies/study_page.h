#pragma once
#include <catch2/catch.hpp>
#include <map>
#include <string>

#include "kit/temporary_folder.h"
#include "report/html_report.h"
#include "report/page_reader.h"
#include "report/report_data.h"
#include "report/summary_json.h"
#include "studies/study.h"

namespace granuscope {

/// A report that holds one study alone; its keyed texts are held against summary.json.
struct Page {
  std::string html;
  std::map<std::string, std::string> texts;  ///< of each key
};

inline Page study_page(const Study& study) {
  ReportData data;
  data.studies[study.id()] = study.json();
  data.parts = study.parts(data.studies[study.id()]);
  const test::TemporaryFolder run;
  const std::string summary = summary_json(data);
  Page page;
  page.html = html_report(data, summary, run.path());
  for (const std::string& line : synthetic::differences(page.html, summary)) FAIL_CHECK(line);
  for (const auto& [key, text] : synthetic::keyed_texts(page.html)) page.texts[key] = text;
  return page;
}

}  // namespace granuscope
