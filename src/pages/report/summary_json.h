#pragma once
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// The numbers of a run as JSON (schema 1), two spaces of indentation, keys in a fixed order. Nothing in it depends on
/// the moment or the machine, so that equal experiments can be compared byte by byte. Whatever is not finite is written
/// as null, with a "reason" beside it.
std::string summary_json(const ReportData& data);

}  // namespace granuscope
