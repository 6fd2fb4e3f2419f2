#include "report/report_overlay.h"

#include <nlohmann/json.hpp>

#include "report/page_scope.h"
#include "support/template_file.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// The parts of one place, one after the other.
std::string written_parts(const std::vector<ReportPart>& parts, ReportPart::Place place, const PageScope& root) {
  std::string html;
  for (const ReportPart& part : parts) {
    const PageScope scope(root, part.base, part.overlay);
    if (part.place == place && scope.has(part.needs)) html += scope.part(part.page);
  }
  return html;
}

}  // namespace

std::string report_page(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                        PageMedium medium) {
  const bool print = medium == PageMedium::print;
  // A browser prints the page as WeasyPrint does.
  Json overlay = {{"screen_style", print ? "" : template_file("screen.css")},
                  {"print_style", template_file("print.css")},
                  {"print", print},
                  {"program", data.provenance.program_version},
                  {"title", title_of(data)},
                  {"description", data.description},
                  {"checks", data.checks},
                  {"has_checks", !data.checks.empty()},
                  {"skipped", data.skipped},
                  {"has_skipped", !data.skipped.empty()},
                  {"law_description", data.law_description},
                  {"has_law_description", !data.law_description.empty()},
                  {"other_laws", Json::array()}};
  for (const auto& [law, sentences] : data.other_law_descriptions) {
    overlay["other_laws"].push_back({{"law", law}, {"sentences", sentences}});
  }
  add_results(overlay, summary);
  add_exponent_texts(overlay, summary);
  add_headline(overlay, summary, data.headline);
  add_causes(overlay, summary);
  add_laws(overlay, summary);
  add_claims(overlay, summary);
  add_numerics(overlay, summary);
  add_figures(overlay, data, run_folder, medium);
  add_provenance(overlay, data);

  const PageScope root(summary, overlay, Markup::html);
  // What the experiment is about has its own sentences on page 1; the experiment's own words come before all others.
  const std::string of_study = data.headline.empty() ? written_parts(data.parts, ReportPart::Place::page_1, root) : "";
  overlay["headline"]["of_study"] = of_study;
  if (!of_study.empty()) {
    overlay["has_headline"] = true;
    overlay["headline"]["generated"] = false;
    overlay["headline"]["scanned"] = nullptr;
  }
  overlay["numbers_parts"] = written_parts(data.parts, ReportPart::Place::numbers, root);
  overlay["numerics_parts"] = written_parts(data.parts, ReportPart::Place::numerics, root);
  return fill_template_file("report.html.mustache", root);
}

}  // namespace granuscope
