#include "report/markdown_summary.h"

#include <nlohmann/json.hpp>

#include "report/clean_json.h"
#include "report/escape_markdown.h"
#include "report/mustache_page.h"
#include "report/number_text.h"
#include "report/report_view.h"
#include "report/summary_json.h"
#include "support/template_file.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

void escape_strings(Json& view) {
  if (view.is_string()) {
    view = escape_markdown(view.get_ref<const std::string&>());
  } else if (view.is_structured()) {
    for (Json& element : view) escape_strings(element);
  }
}

}  // namespace

std::string markdown_summary(const ReportData& data) {
  const Json summary = Json::parse(summary_json(data));
  Json view = results_view(summary);
  view["title"] = data.experiment_name.empty() ? "untitled experiment" : data.experiment_name;
  for (const char* name : {"columns", "layers", "seed"}) {
    view[name] = number_cell(summary, std::string("/") + name);
  }
  view["claims"] = claims_view(summary);
  view["claim_counts"] = claim_counts(summary);
  const Json numerics = numerics_view(summary, data);
  for (const char* name : {"failures", "more_failures"}) view[name] = numerics[name];
  clean_strings(view);
  escape_strings(view);
  return fill_page(template_file("summary.md.mustache"), view);
}

}  // namespace granuscope
