#pragma once
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// The numbers that matter as Markdown, for a pull request or a terminal. User text is escaped.
std::string markdown_summary(const ReportData& data);

}  // namespace granuscope
