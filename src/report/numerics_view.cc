#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "report/number_text.h"
#include "report/report_view.h"
#include "support/number_format.h"
#include "support/progress.h"

namespace granuscope {

namespace {

using Json = nlohmann::ordered_json;

Json named_values(const std::vector<std::pair<std::string, std::string>>& pairs) {
  Json list = Json::array();
  for (const auto& [name, value] : pairs) list.push_back({{"name", name}, {"value", value}});
  return list;
}

/// Of each friction coefficient. All are in summary.json; ten thousand of them would bury the report.
constexpr std::size_t most_named_failures = 8;

Json failures_of(const Json& summary, const Json& result, std::size_t index) {
  Json failures = Json::array();
  for (std::size_t i = 0; i < std::min(result.at("failed").size(), most_named_failures); ++i) {
    const std::string pointer = fmt::format("/results/{}/failed/{}", index, i);
    Json failure;
    failure["at_mu"] = number_cell(summary, fmt::format("/results/{}/mu", index));
    for (const char* name : {"sample", "layer", "replay"}) failure[name] = number_cell(summary, pointer + "/" + name);
    failures.push_back(failure);
  }
  return failures;
}

/// The spread of chi^2 per degree of freedom over the depths that were fitted, as cells of the smallest and largest.
Json fit_quality(const Json& summary, const Json& result, std::size_t index) {
  std::size_t lowest = 0, highest = 0, fitted = 0;
  const Json& depths = result.at("depths");
  const auto chi2 = [&depths](std::size_t i) { return depths[i].at("chi2_per_dof").get<double>(); };
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].at("chi2_per_dof").is_null() || depths[i].at("identifiable") != true) continue;
    if (fitted == 0 || chi2(i) < chi2(lowest)) lowest = i;
    if (fitted == 0 || chi2(i) > chi2(highest)) highest = i;
    ++fitted;
  }
  if (fitted == 0) return Json::object();
  Json quality;
  quality["low"] = fixed_cell(summary, fmt::format("/results/{}/depths/{}/chi2_per_dof", index, lowest), 2);
  quality["high"] = fixed_cell(summary, fmt::format("/results/{}/depths/{}/chi2_per_dof", index, highest), 2);
  return quality;
}

/// By how much chi^2 per degree of freedom scatters, with the degrees of freedom of the first depth fitted; a list of
/// one, or empty.
Json chi2_scatter(const Json& summary) {
  for (std::size_t i = 0; i < summary.at("results").size(); ++i) {
    const Json& depths = summary.at("results")[i].at("depths");
    for (std::size_t k = 0; k < depths.size(); ++k) {
      const auto degrees = depths[k].at("degrees_of_freedom").get<int>();
      if (degrees <= 0) continue;
      const std::string pointer = fmt::format("/results/{}/depths/{}/degrees_of_freedom", i, k);
      return Json::array({{{"scatter", significant(std::sqrt(2.0 / degrees), 1)},
                           {"degrees_of_freedom", number_cell(summary, pointer)}}});
    }
  }
  return Json::array();
}

}  // namespace

Json numerics_view(const Json& summary, const ReportData& data) {
  Json view;
  Json rows = Json::array(), failures = Json::array(), more = Json::array(), chains = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::string pointer = fmt::format("/results/{}", i);
    Json row;
    row["mu"] = number_cell(summary, pointer + "/mu");
    row["samples"] = number_cell(summary, pointer + "/samples");
    row["depths_in_window"] = number_cell(summary, pointer + "/depths_in_window");
    row["draws_per_bead"] = fixed_cell(summary, pointer + "/sampler/draws_per_bead", 3);
    row["mended_per_bead"] = fixed_cell(summary, pointer + "/sampler/mended_per_bead", 4);
    row["climbed_per_bead"] = fixed_cell(summary, pointer + "/sampler/climbed_per_bead", 4);
    row["rounded_per_bead"] = number_cell(summary, pointer + "/sampler/rounded_per_bead");
    row["window"] = {{"first", number_cell(summary, pointer + "/window_layers/0")},
                     {"last", number_cell(summary, pointer + "/window_layers/1")}};
    if (results[i].at("sampler").contains("burn_in")) {
      chains.push_back({{"at_mu", row["mu"]},
                        {"samples", row["samples"]},
                        {"burn_in", number_cell(summary, pointer + "/sampler/burn_in")},
                        {"thinning", number_cell(summary, pointer + "/sampler/thinning")},
                        {"effective_samples", fixed_cell(summary, pointer + "/sampler/effective_samples/value", 0)}});
    }
    row["failed_count"] = std::to_string(results[i].at("failed").size());
    row["quality"] = fit_quality(summary, results[i], i);
    row["exact"] = results[i].at("exact");
    rows.push_back(row);
    for (const Json& failure : failures_of(summary, results[i], i)) failures.push_back(failure);
    if (const std::size_t failed = results[i].at("failed").size(); failed > most_named_failures) {
      more.push_back({{"at_mu", row["mu"]}, {"count", std::to_string(failed - most_named_failures)}});
    }
  }
  view["sampler_rows"] = rows;
  view["chi2_scatter"] = chi2_scatter(summary);
  view["has_sampler_rows"] = !rows.empty();
  view["chains"] = chains;
  view["has_chains"] = !chains.empty();
  view["failures"] = failures;
  view["more_failures"] = more;
  view["has_failures"] = !failures.empty();
  view["skipped"] = data.skipped;
  view["has_skipped"] = !data.skipped.empty();
  return view;
}

Json provenance_view(const ReportData& data) {
  const Provenance& from = data.provenance;
  Json view;
  view["commit"] = from.git_commit;
  view["dirty"] = from.git_dirty;
  view["facts"] = named_values({{"Program", from.program_version},
                                {"Compiler", from.compiler},
                                {"Compiler flags", from.compiler_flags},
                                {"Build type", from.build_type},
                                {"Processor", from.host_cpu},
                                {"Operating system", from.operating_system},
                                {"Hardware threads", std::to_string(from.hardware_threads)}});
  view["libraries"] = named_values(from.libraries);
  view["has_libraries"] = !from.libraries.empty();
  view["environment"] = named_values(data.environment);
  Json timings = Json::array();
  for (const StageTiming& timing : data.timings) {
    std::string time = std::isfinite(timing.seconds) ? describe_duration(timing.seconds) : "not known";
    const std::string shortest = "less than ";
    if (time.starts_with(shortest)) time.replace(0, shortest.size(), "< ");
    timings.push_back({{"stage", timing.stage}, {"time", time}, {"reused", timing.reused}});
  }
  view["timings"] = timings;
  view["has_timings"] = !timings.empty();
  // Line by line, so that what does not fit into one is seen to belong to it.
  Json lines = Json::array();
  std::istringstream text(data.resolved_experiment);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  view["experiment_lines"] = lines;
  return view;
}

}  // namespace granuscope
