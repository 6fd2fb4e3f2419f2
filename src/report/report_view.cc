#include "report/report_view.h"

#include <nlohmann/json.hpp>

#include "report/clean_json.h"
#include "report/number_text.h"
#include "report/page_scope.h"
#include "report/study_overlays.h"
#include "support/template_file.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

/// Adds the members of one view to another.
void merge(Json& view, const Json& part) {
  for (const auto& [name, value] : part.items()) view[name] = value;
}

/// What is measured beside the main line, as far as no one else hands it in.
std::vector<ReportPart> standard_parts(const Json& summary, const ReportData& data) {
  using enum ReportPart::Place;
  return {{"studies/law_comparison.html", "/side", "laws", numbers, law_comparison_overlay(summary, data)},
          {"studies/rejection_thrust.html", "/side", "exact_thrusts", numbers, rejection_thrust_overlay(summary)},
          {"studies/law_responses.html", "/side", "law_responses", numbers, law_responses_overlay(summary)},
          {"studies/law_rules.html", "/side", "rules", numbers, law_rules_overlay(summary)},
          {"studies/nonlinearity.html", "/side/nonlinearity", "responses", numbers, nonlinearity_overlay(summary)},
          {"studies/redrawn_beads.html", "/side", "redrawn_beads", numbers},
          {"studies/chain_share.html", "/side", "chain_share", numbers},
          {"studies/stress.html", "/side", "stress", numerics}};
}

/// The parts of one place, one after the other.
std::string written_parts(const std::vector<ReportPart>& parts, ReportPart::Place place, const Json& summary) {
  const Json nothing = Json::object();
  const PageScope root(summary, nothing, Markup::html);
  std::string html;
  for (const ReportPart& part : parts) {
    const PageScope scope(root, part.base, part.overlay);
    if (part.place == place && scope.has(part.needs)) html += fill_template_file(part.page, scope);
  }
  return html;
}

}  // namespace

Json report_view(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                 PageMedium medium) {
  const bool print = medium == PageMedium::print;
  Json view;
  view["style"] = template_file(print ? "print.css" : "screen.css");
  view["print"] = print;
  view["program"] = data.provenance.program_version;
  view["title"] = data.experiment_name.empty() ? "untitled experiment" : data.experiment_name;
  view["description"] = data.description;
  view["has_description"] = !data.description.empty();
  for (const char* name : {"columns", "layers", "seed", "overload"}) {
    view[name] = number_cell(summary, std::string("/") + name);
  }
  view["experiment_key"] = number_cell(summary, "/experiment_key");
  merge(view, results_view(summary));
  view["claims"] = claims_view(summary);
  view["claim_counts"] = claim_counts(summary);
  view["has_claims"] = !view["claims"].empty();
  merge(view, laws_view(summary));
  std::vector<ReportPart> parts = standard_parts(summary, data);
  parts.insert(parts.end(), data.parts.begin(), data.parts.end());
  view["numbers_parts"] = written_parts(parts, ReportPart::Place::numbers, summary);
  view["numerics_parts"] = written_parts(parts, ReportPart::Place::numerics, summary);
  view["figures"] = figures_view(data, run_folder, medium);
  view["has_figures"] = !view["figures"].empty();
  view["checks"] = data.checks;
  view["has_checks"] = !data.checks.empty();
  view["law_in_words"] = data.law_in_words;
  view["has_law_in_words"] = !data.law_in_words.empty();
  view["other_laws"] = Json::array();
  for (const auto& [law, sentences] : data.other_laws_in_words) {
    view["other_laws"].push_back({{"law", law}, {"sentences", sentences}});
  }
  merge(view, numerics_view(summary, data));
  merge(view, provenance_view(data));
  clean_strings(view);
  return view;
}

}  // namespace granuscope
