#pragma once
#include "report/page.h"
#include "studies/study.h"

namespace granuscope {

/// A report that holds one study alone.
inline Page study_page(const Study& study) {
  ReportData data;
  data.studies[study.id()] = study.json();
  data.parts = study.parts();
  return Page(data);
}

}  // namespace granuscope
