#pragma once
#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include "report/report_data.h"

namespace granuscope {
/// For whom the page is made: it decides on style sheet, contents and how figures are embedded.
enum class PageMedium { screen, print };

/// The report as an HTML page: report.html.mustache over `summary`, the parsed summary.json, with what does not stand
/// there. Figures are read from `run_folder`; throws InputError if one cannot be read.
std::string report_page(const ReportData& data, const Json& summary, const std::filesystem::path& run_folder,
                        PageMedium medium);

/// Each adds to an overlay of the whole summary (report/page_scope.h) what the templates ask for beside it.
void add_results(Json& overlay, const Json& summary);  ///< exponents, c and D
void add_laws(Json& overlay, const Json& summary);     ///< notes on powers of depth
void add_claims(Json& overlay, const Json& summary);
/// Whether an exact number of a result is nothing but the rounding of the sums it comes from: no number to show.
bool is_rounding(const Json& result, const char* name);
/// The sentences of page 1: `own` of the experiment, or else what templates/headline.html makes of the numbers.
void add_headline(Json& overlay, const Json& summary, const std::string& own);
/// What makes the exponents differ from the paper's.
void add_causes(Json& overlay, const Json& summary);
void add_numerics(Json& overlay, const Json& summary);
void add_provenance(Json& overlay, const ReportData& data);
void add_figures(Json& overlay, const ReportData& data, const std::filesystem::path& run_folder, PageMedium medium);
/// The response at every recorded depth of every result that has scatter: "explored", null where there is none, else
/// its "data" as JSON without a '<' and the "symbol" of what was scanned.
void add_explored_depths(Json& overlay, const Analysis& analysis);

/// What a word of the report means: templates/glossary.txt.
struct GlossaryEntry {
  std::vector<std::string> names;
  std::string text;      ///< without a point behind it
  bool on_page = false;  ///< in the first part of the file, whose words the report uses
};
std::vector<GlossaryEntry> glossary();

/// "yes", "no" or "open": the class of a verdict for the style sheets.
std::string look_of(const std::string& verdict);

}  // namespace granuscope
