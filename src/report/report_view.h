#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "report/report_data.h"

namespace granuscope {

/// For whom the page is made: it decides on style sheet, contents and how figures are embedded.
enum class PageMedium { screen, print };

/// Everything the template report.html.mustache asks for. Numbers of the results are cells {key, text} formatted from
/// `summary`, the parsed summary.json; all text is clean UTF-8. Figures are read from `run_folder`; throws InputError
/// if one cannot be read.
nlohmann::ordered_json report_view(const ReportData& data, const nlohmann::ordered_json& summary,
                                   const std::filesystem::path& run_folder, PageMedium medium);

/// The parts of it, each in a file of its own.
nlohmann::ordered_json results_view(const nlohmann::ordered_json& summary);  ///< tables of exponents and of c and D
nlohmann::ordered_json claims_view(const nlohmann::ordered_json& summary);   ///< one row per claim
nlohmann::ordered_json claim_counts(const nlohmann::ordered_json& summary);  ///< of each verdict
/// The verdict on one claim with a flag for its look; an empty object if the claim was not judged.
nlohmann::ordered_json verdict_cell(const nlohmann::ordered_json& summary, const std::string& claim_id);
nlohmann::ordered_json laws_view(const nlohmann::ordered_json& summary);   ///< powers of depth, chi^2 of the lines
nlohmann::ordered_json figures_view(const ReportData& data, const std::filesystem::path& run_folder, PageMedium medium);
nlohmann::ordered_json numerics_view(const nlohmann::ordered_json& summary, const ReportData& data);
nlohmann::ordered_json provenance_view(const ReportData& data);

}  // namespace granuscope
