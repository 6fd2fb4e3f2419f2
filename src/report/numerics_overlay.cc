#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "report/reason_notes.h"
#include "report/report_overlay.h"
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

/// The spread of chi^2 per degree of freedom over the depths that were fitted, as cells of the smallest and largest.
Json fit_quality(const Json& depths, const std::string& pointer) {
  std::size_t lowest = 0, highest = 0, fitted = 0;
  const auto chi2 = [&depths](std::size_t i) { return depths[i].at("chi2_per_dof").get<double>(); };
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (depths[i].at("chi2_per_dof").is_null() || depths[i].at("identifiable") != true) continue;
    if (fitted == 0 || chi2(i) < chi2(lowest)) lowest = i;
    if (fitted == 0 || chi2(i) > chi2(highest)) highest = i;
    ++fitted;
  }
  if (fitted == 0) return Json::object();
  const auto cell = [&pointer](std::size_t i) { return Json{{"key", fmt::format("{}/{}/chi2_per_dof", pointer, i)}}; };
  return {{"low", cell(lowest)}, {"high", cell(highest)}};
}

/// By how much chi^2 per degree of freedom scatters, with the degrees of freedom of the first depth fitted; or nothing.
Json chi2_scatter(const Json& results) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Json& depths = results[i].at("depths");
    for (std::size_t k = 0; k < depths.size(); ++k) {
      const auto degrees = depths[k].at("degrees_of_freedom").get<int>();
      if (degrees <= 0) continue;
      const std::string pointer = fmt::format("/results/{}/depths/{}/degrees_of_freedom", i, k);
      return {{"scatter", significant(std::sqrt(2.0 / degrees), 1)}, {"degrees_of_freedom", {{"key", pointer}}}};
    }
  }
  return Json::object();
}

}  // namespace

void add_numerics(Json& overlay, const Json& summary) {
  Json failures = Json::array(), more = Json::array();
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::string pointer = fmt::format("/results/{}", i);
    const std::size_t failed = results[i].at("failed").size();
    const Json scanned = {{"key", place_of_scanned(summary, i)}};
    overlay["results"][i]["failures"] = failed;
    overlay["results"][i]["quality"] = fit_quality(results[i].at("depths"), pointer + "/depths");
    for (std::size_t k = 0; k < std::min(failed, most_named_failures); ++k) {
      failures.push_back({{"key", fmt::format("{}/failed/{}", pointer, k)}, {"scanned", scanned}});
    }
    if (failed > most_named_failures) more.push_back({{"scanned", scanned}, {"count", failed - most_named_failures}});
  }
  overlay["chi2_scatter"] = chi2_scatter(results);
  overlay["failures"] = failures;
  overlay["has_failures"] = !failures.empty();
  overlay["more_failures"] = more;
}

namespace {

/// "8192 piles at each of 6 μ", or nothing if they differ.
std::string run_line(const Analysis& analysis) {
  std::set<std::uint64_t> samples;
  std::size_t ensembles = 0;
  for (const Transport& result : analysis.results) {
    if (result.exact) continue;
    ++ensembles;
    samples.insert(result.samples);
  }
  const std::string symbol = analysis.scan->symbol;
  if (samples.size() != 1) return ensembles == 0 ? "" : fmt::format("{} values of {}", ensembles, symbol);
  return ensembles == 1 ? fmt::format("{} piles", *samples.begin())
                        : fmt::format("{} piles at each of {} {}", *samples.begin(), ensembles, symbol);
}

/// Which of five sums a stage belongs to; what a study times by itself is one of its own.
std::string sum_of(const std::string& stage, const std::string& scanned) {
  if (stage.starts_with(fmt::format("sample {} = ", scanned))) return "sampling, main ensembles";
  if (stage.starts_with("sample ")) return "sampling, studies";
  if (stage == "analyse") return "analysis";
  if (stage == "render") return "pictures";
  if (stage == "plot") return "figures";
  return stage;
}

/// timings.json has every stage.
Json sums_of_timings(const std::vector<StageTiming>& timings, const std::string& scanned) {
  struct Sum {
    std::string name;
    double seconds = 0;
    std::uint64_t beads = 0;
    int stages = 0, reused = 0;
  };
  std::vector<Sum> sums;
  for (const StageTiming& timing : timings) {
    const std::string name = sum_of(timing.stage, scanned);
    auto sum = std::find_if(sums.begin(), sums.end(), [&name](const Sum& known) { return known.name == name; });
    if (sum == sums.end()) sum = sums.insert(sums.end(), Sum{name});
    sum->seconds += timing.seconds;
    sum->beads += timing.beads;
    ++sum->stages;
    sum->reused += timing.reused ? 1 : 0;
  }
  Json rows = Json::array();
  for (const Sum& sum : sums) {
    std::string time = std::isfinite(sum.seconds) ? describe_duration(sum.seconds) : "not known";
    const std::string shortest = "less than ";
    if (time.starts_with(shortest)) time.replace(0, shortest.size(), "< ");
    const double nanoseconds = sum.beads > 0 ? 1e9 * sum.seconds / static_cast<double>(sum.beads) : std::nan("");
    rows.push_back({{"stage", sum.name},
                    {"time", time},
                    {"per_bead", std::isfinite(nanoseconds) ? significant(nanoseconds, 2) : ""},
                    {"result", sum.reused == 0            ? "computed"
                               : sum.reused == sum.stages ? "reused"
                                                          : fmt::format("{} of {} reused", sum.reused, sum.stages)}});
  }
  return rows;
}

}  // namespace

void add_provenance(Json& overlay, const ReportData& data) {
  const Provenance& from = data.provenance;
  overlay["run_line"] = run_line(data.analysis);
  overlay["commit"] = from.git_commit.substr(0, 10);
  overlay["dirty"] = from.git_dirty;
  overlay["facts"] = named_values({{"Program", from.program_version},
                                   {"Compiler", from.compiler},
                                   {"Compiler flags", from.compiler_flags},
                                   {"Build type", from.build_type},
                                   {"Processor", from.host_cpu},
                                   {"Operating system", from.operating_system},
                                   {"Hardware threads", std::to_string(from.hardware_threads)}});
  overlay["libraries"] = named_values(from.libraries);
  overlay["has_libraries"] = !from.libraries.empty();
  overlay["environment"] = named_values(data.environment);
  overlay["timings"] = sums_of_timings(data.timings, data.analysis.scan->name);
  overlay["has_timings"] = !data.timings.empty();
  overlay["reuse"] = data.reuse;
  // Line by line, so that what does not fit into one is seen to belong to it.
  Json lines = Json::array();
  std::istringstream text(data.changed_experiment.empty() ? data.resolved_experiment : data.changed_experiment);
  // What the gate expects tells the program which verdicts are news, not the reader what was computed.
  bool of_gate = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with('[')) of_gate = line.starts_with("[gate.");
    const bool of_page = line.starts_with("name = ") || line.starts_with("description = ");  // stands there
    if (!of_gate && !of_page) lines.push_back(line);
  }
  overlay["experiment_lines"] = lines;
}

}  // namespace granuscope
