#include "report/markdown_summary.h"

#include <nlohmann/json.hpp>

#include "report/page_scope.h"
#include "report/report_overlay.h"
#include "report/summary_json.h"

namespace granuscope {

std::string markdown_summary(const ReportData& data) {
  const auto summary = nlohmann::ordered_json::parse(summary_json(data));
  nlohmann::ordered_json overlay = {{"title", title_of(data)}};
  add_results(overlay, summary);
  add_claims(overlay, summary);
  add_numerics(overlay, summary);
  return fill_template_file("summary.md.mustache", PageScope(summary, overlay, Markup::markdown));
}

}  // namespace granuscope
