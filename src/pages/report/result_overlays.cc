#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <sstream>

#include "model/lattice.h"
#include "plot/figure_captions.h"
#include "report/number_text.h"
#include "report/page_overlays.h"
#include "report/page_scope.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {
/// Whether all rows agree in a column, and there is one.
bool all_equal(const Json& results, const char* column) {
  for (const Json& result : results) {
    if (result.at(column) != results[0].at(column)) return false;
  }
  return !results.empty();
}

/// What stands in the second bracket of 0.0792(41)(12): the systematic error in units of the value's last digit, one at
/// least, or written out where the statistical one is: 123.4(5.6)(1.2). Empty for a value with a power of ten.
std::string in_last_digits(double value, double error, double systematic) {
  const std::string text = value_with_error(value, error);
  const std::size_t bracket = text.find('('), point = text.find('.');
  if (bracket == std::string::npos || text.find("×") != std::string::npos) return "";
  const std::size_t decimals = point < bracket ? bracket - point - 1 : 0;
  if (text.find('.', bracket) != std::string::npos) return fmt::format("{:.{}f}", systematic, decimals);
  const double units = systematic * std::pow(10, static_cast<double>(decimals));
  return fmt::format("{:.0f}", std::max(units, 1.0));
}

/// Adds the systematic error of an estimate as a cell: `name` + "bracket" for a bracket of its own or, where that
/// cannot be, `name` + "beside" with two significant digits; neither if there is none beyond what the scatter accounts
/// for.
void add_systematic(Json& row, const std::string& name, const Json& estimate, const std::string& pointer) {
  if (!estimate.contains("systematic") || estimate.at("systematic") == 0) return;
  if (!estimate.at("value").is_number() || !estimate.at("stderr").is_number()) return;
  const auto systematic = estimate.at("systematic").get<double>();
  const std::string bracket =
      in_last_digits(estimate.at("value").get<double>(), estimate.at("stderr").get<double>(), systematic);
  const bool beside = bracket.empty();
  row[name + (beside ? "beside" : "bracket")] = {{"key", pointer + "/systematic"},
                                                 {"text", beside ? significant(systematic, 2) : bracket}};
}

}  // namespace

bool is_rounding(const Json& result, const char* name) {
  constexpr double rounding = 1e-12;
  const Json& value = result.at(name).at("value");
  return result.at("exact") == true && value.is_number() && std::abs(value.get<double>()) < rounding;
}

namespace {

std::string greek(const std::string& name) { return name == "alpha" ? "α" : name == "beta" ? "β" : "γ"; }

/// What the table of exponents says of one beside its fit.
Json exponent_row(const Json& summary, const char* name, const char* claim_id, Json& notes) {
  const std::string pointer = fmt::format("/scaling/{}", name);
  const Json& fit = summary.at("scaling").at(name);
  Json row = {{"key", pointer}, {"name", name}, {"symbol", greek(name)}};
  if (fit.at("power_law") != false) add_systematic(row, "", fit, pointer);
  const Json& claims = summary.at("claims");
  for (std::size_t i = 0; i < claims.size(); ++i) {
    if (claims[i].at("id") != claim_id || row.contains("verdict")) continue;
    row["verdict"] = {{"key", fmt::format("/claims/{}/verdict", i)}};
    row["look"] = look_of(claims[i].at("verdict"));
  }
  add_reason(notes, summary, pointer, greek(name), "");
  if (fit.at("value").is_number()) add_reason(notes, summary, pointer + "/about_law", "χ² of " + greek(name), "");
  return row;
}

/// Exponents over other windows: the reasons of those that are unknown.
void add_other_exponent_reasons(Json& notes, const Json& summary) {
  const Json& windows = summary.at("scaling").at("other_windows");
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const Json& window = windows[i].at("beta").at("window");
    for (const char* name : {"beta", "gamma", "alpha"}) {
      add_reason(notes, summary, fmt::format("/scaling/other_windows/{}/{}", i, name), greek(name),
                 fmt::format(" over {} = {} to {}", summary.at("scan").at("symbol").get<std::string>(),
                             format_number(window[0]), format_number(window[1])));
    }
  }
}

/// Where it is not known how a variation changes c or D, the reason, once for all places that share it.
void add_variation_reasons(Json& notes, const Json& summary, std::size_t result, const std::string& place) {
  const std::string list = fmt::format("/results/{}/variations", result);
  for (std::size_t i = 0; i < summary.at(Json::json_pointer(list)).size(); ++i) {
    add_reason(notes, summary, fmt::format("{}/{}/c_shift", list, i), "", place);
    add_reason(notes, summary, fmt::format("{}/{}/D_shift", list, i), "", place);
  }
}

/// Whether some of the response lies between the peaks, by more than three errors, and all is known of it.
bool has_background(const Json& result) {
  for (const char* name : {"centre_background", "c_beside_background", "D_beside_background"}) {
    if (!result.at(name).at("value").is_number() || !result.at(name).at("stderr").is_number()) return false;
  }
  for (const char* name : {"chi2_per_dof", "chi2_beside_background_per_dof"}) {
    if (!result.at(name).is_number()) return false;
  }
  const Json& share = result.at("centre_background");
  return share.at("value").get<double>() > 3 * share.at("stderr").get<double>();
}

/// For page 1: why the deepest depth was refused, of a reason that stands below the tables of c and D.
std::string in_one_clause(std::string reason) {
  const std::size_t layer = reason.find("; at layer ");
  if (layer != std::string::npos) reason.erase(0, reason.find(": ", layer) + 2);
  return reason.substr(0, reason.find_first_of(":;"));
}

/// The rows of c and D, and what is said below their tables.
void add_transport(Json& overlay, const Json& summary) {
  bool has_backgrounds = false;
  Json rows = Json::array(), notes = Json::array(), variation_notes = Json::array(), asked = Json::array();
  std::vector<LeftOut> unknown, fast;
  const Json& results = summary.at("results");
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Json& c = results[i].at("c");
    if (!c.at("value").is_number()) {
      unknown.push_back({at_scanned(summary, i), in_one_clause(c.value("reason", ""))});
    } else if (results[i].at("exact") != true && c.at("value") >= results[i].value("c0", 1 / sqrt3)) {
      fast.push_back({at_scanned(summary, i), "c is not below c₀"});
    }
    const std::string pointer = fmt::format("/results/{}", i);
    Json row = {{"frictionless", results[i].contains("mu") && results[i].at("mu") == 0},
                {"scanned", {{"key", place_of_scanned(summary, i)}}},
                {"has_background", has_background(results[i])}};
    has_backgrounds = has_backgrounds || has_background(results[i]);
    for (const char* name : {"D", "c_minus_c_thrust", "width_offset"}) {
      if (is_rounding(results[i], name)) row[name] = {{"key", fmt::format("{}/{}", pointer, name)}, {"text", "0"}};
    }
    add_systematic(row, "c_", results[i].at("c"), pointer + "/c");
    add_systematic(row, "D_", results[i].at("D"), pointer + "/D");
    const std::string at = " at " + at_scanned(summary, i);
    add_reason(notes, summary, pointer + "/c", "c", at);
    add_reason(notes, summary, pointer + "/D", "D", at);
    add_reason(notes, summary, pointer + "/c_thrust", "c from the thrust ratio", at);
    add_variation_reasons(variation_notes, summary, i, at.substr(1));
    if (results[i].contains("precision")) {
      if (asked.empty())
        asked.push_back({{"key", pointer + "/precision"}, {"missed", Json::array()}, {"any_missed", false}});
      if (results[i].at("precision").at("reached") == false) {
        asked[0]["any_missed"] = true;
        asked[0]["missed"].push_back({{"scanned", {{"key", place_of_scanned(summary, i)}}}});
      }
    }
    rows.push_back(row);
  }
  finish_notes(notes);
  finish_notes(variation_notes);
  overlay["results"] = rows;
  overlay["has_backgrounds"] = has_backgrounds;
  overlay["transport_notes"] = notes;
  overlay["variation_notes"] = variation_notes;
  overlay["asked_precision"] = asked;
  overlay["without_c"] = unknown.size() < results.size() ? with_reasons(unknown) : "";
  overlay["without_powers"] = overlay.at("any_exponent") == true ? with_reasons(fast) : "";
}

}  // namespace

void add_results(Json& overlay, const Json& summary) {
  const Json& results = summary.at("results");
  Json notes = Json::array();
  overlay["exponents"] =
      Json::array({exponent_row(summary, "beta", "D-of-mu", notes), exponent_row(summary, "gamma", "c-of-mu", notes),
                   exponent_row(summary, "alpha", "c-of-D", notes)});
  Json missed = notes;  // of the window that page 1 is about
  finish_notes(missed);
  add_other_exponent_reasons(notes, summary);
  finish_notes(notes);
  const auto measured = std::ranges::count_if(results, [](const Json& one) { return one.at("exact") == false; });
  overlay["any_exponent"] = std::ranges::any_of(overlay["exponents"], [&](const Json& row) {
    return summary.at("scaling").at(row.at("name").get<std::string>()).at("value").is_number();
  });
  // Of a single value nobody asks for exponents.
  overlay["exponent_notes"] = measured > 1 ? notes : Json::array();
  add_transport(overlay, summary);
  const Json studied = summary.at("studies").flatten();
  overlay["studies_alone"] =
      measured == 0 && std::ranges::any_of(studied, [](const Json& one) { return one.is_number(); });
  // Of two values nobody asks for exponents either.
  overlay["exponents_missed"] = measured > 2 ? missed : Json::array();
  overlay["incomplete"] = Json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const std::size_t failed = results[i].at("failed").size();
    if (failed == 0) continue;
    const std::size_t drawn = failed + results[i].at("samples").get<std::size_t>();
    overlay["incomplete"].push_back(
        {{"scanned", {{"key", place_of_scanned(summary, i)}}}, {"failed", failed}, {"drawn", drawn}});
  }
  overlay["same_procedure"] = all_equal(results, "estimator") && all_equal(results, "law");
  const auto has = [&results](const char* key, const auto& value) {
    return std::ranges::any_of(results, [&](const Json& one) { return one.contains(key) && one.at(key) == value; });
  };
  overlay["coupled"] = has("coupled", true);
  overlay["two_overloads"] = has("overloads", 2);
  overlay["procedure"] = all_equal(results, "estimator") ? results[0].at("estimator") : Json("");
}

namespace {

Json named_values(const std::vector<std::pair<std::string, std::string>>& pairs) {
  Json list = Json::array();
  for (const auto& [name, value] : pairs) list.push_back({{"name", name}, {"value", value}});
  return list;
}

/// "gnuplot 5.4" of gnuplot is 5.4.
std::vector<std::pair<std::string, std::string>> without_names(std::vector<std::pair<std::string, std::string>> pairs) {
  for (auto& [name, value] : pairs) {
    const auto same = [](char a, char b) { return std::tolower(a) == std::tolower(b); };
    if (value.size() > name.size() && std::equal(name.begin(), name.end(), value.begin(), same) &&
        value[name.size()] == ' ') {
      value.erase(0, name.size() + 1);
    }
  }
  return pairs;
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
      return {{"scatter", significant(std::sqrt(2.0 / degrees), 2)}, {"degrees_of_freedom", {{"key", pointer}}}};
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

/// What sets the beads apart from the paper's: " · load 12° from the vertical · bead weight 0.1".
std::string unusual_beads(const Analysis& analysis) {
  if (analysis.results.empty()) return {};
  const EnsembleSpec& spec = analysis.results.back().spec;
  const SamplerSpec& sampler = spec.sampler;
  std::string words;
  if (spec.lattice.angle != usual_angle) words += fmt::format(" · contacts at {}°", spec.lattice.angle);
  const char* const loads = sampler.lean_excess ? "overloads" : "loads";
  if (sampler.load_angle != 0) words += fmt::format(" · {} {}° from the vertical", loads, sampler.load_angle);
  if (sampler.load_offset != 0) words += fmt::format(" · {} {} radii beside the centres", loads, sampler.load_offset);
  if (sampler.bead_weight != 0) words += fmt::format(" · bead weight {}", sampler.bead_weight);
  return words;
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
  overlay["run_line"] = run_line(data.analysis) + unusual_beads(data.analysis);
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
  overlay["environment"] = named_values(without_names(data.environment));
  overlay["timings"] = sums_of_timings(data.timings, data.analysis.scan->name);
  double seconds = 0;
  for (const StageTiming& timing : data.timings) seconds += timing.seconds;
  overlay["all_timings"] = std::isfinite(seconds) ? describe_duration(seconds) : "not known";
  overlay["reuse"] = data.reuse;
  // Table by table, which no column parts, and line by line, so that what does not fit into one is seen to belong to
  // it.
  std::vector<std::vector<std::string>> tables;
  std::istringstream text(data.changed_experiment.empty() ? data.resolved_experiment : data.changed_experiment);
  // What the gate expects tells the program which verdicts are news, not the reader what was computed.
  bool of_gate = false, of_experiment = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with('[')) {
      of_gate = line.starts_with("[gate.");
      of_experiment = line == "[experiment]";
    }
    // Stands at the head of the page.
    const bool of_page = of_experiment && (line.starts_with("name = ") || line.starts_with("description = "));
    if (of_gate || of_page) continue;
    if (line.starts_with('[') || tables.empty()) tables.emplace_back();
    if (!line.empty()) tables.back().push_back(line);
  }
  std::erase_if(tables, [](const auto& lines) { return lines.size() == 1 && lines.front().starts_with('['); });
  overlay["experiment_tables"] = tables;
}

}  // namespace granuscope
