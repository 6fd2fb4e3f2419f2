#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "kit/temporary_folder.h"
#include "report/fixture.h"
#include "report/report.h"
#include "report/summary_json.h"

namespace granuscope {

struct MadePage {
  test::TemporaryFolder run;
  ReportData data = synthetic::report_data(run.path());
  std::string summary = summary_json(data);
  std::string html = html_report(data, nlohmann::ordered_json::parse(summary), run.path());
};

/// The page of the synthetic report, made once for all cases that only read it: its figures take two seconds.
inline const MadePage& made_page() {
  static const MadePage page;
  return page;
}

}  // namespace granuscope
