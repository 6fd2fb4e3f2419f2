#pragma once
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// The numbers of a run as JSON (schema 1), two spaces of indentation, keys in a fixed order. It holds no time, host or
/// path: the same experiment gives the same bytes. An unknown number is null beside a "reason"; NaN and inf never
/// appear.
std::string summary_json(const ReportData& data);

}  // namespace granuscope
