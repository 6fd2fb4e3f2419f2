#pragma once
#include "report/page.h"
#include "studies/study.h"

namespace granuscope {

/// A report that holds one study alone.
inline Page study_page(const Study& study) {
  ReportData data;
  study.write_json(data.studies);
  data.parts = study.parts(data.studies);
  return Page(data);
}

}  // namespace granuscope
