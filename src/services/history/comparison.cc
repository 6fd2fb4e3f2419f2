#include "history/comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gsl/gsl_cdf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>

#include "analysis/results.h"
#include "experiment/experiment_file.h"
#include "report/clean_json.h"
#include "report/page_scope.h"
#include "report/run_files.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
Json parsed(const fs::path& file) {
  try {
    return Json::parse(read_json(file));
  } catch (const Json::exception&) {
    throw InputError(
        "{}: this is no JSON, so that nothing can be compared; name the folder of a run or its summary.json{}",
        file.string(), file.filename() == "summary.json" ? ", and make that run again" : "");
  }
}

void collect(const Json& json, const std::string& place, std::map<std::string, double>& numbers) {
  if (json.is_number()) {
    numbers[place] = json.get<double>();
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items()) collect(value, fmt::format("{}/{}", place, key), numbers);
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) collect(json[i], fmt::format("{}/{}", place, i), numbers);
  }
}

}  // namespace

RunRecord read_run(const fs::path& path) {
  RunRecord run;
  run.path = path;
  if (!path_exists(path)) {
    throw InputError("{}: there is neither a run nor a summary; name the folder of a run or its summary.json",
                     path.string());
  }
  if (folder_exists(path)) {
    run.folder = path;
    require_results_of_last_run(path, "report");
  }
  const fs::path summary = run.folder.empty() ? path : run.folder / "summary.json";
  if (!run.folder.empty() && !path_exists(summary)) {
    throw InputError(
        "{}: there is no summary.json in this folder, so that it is no finished run; run the experiment to its end",
        path.string());
  }
  run.summary = parsed(summary);
  if (!run.summary.is_object() || !run.summary.contains("results")) {
    throw InputError("{}: this is no summary of a run (it has no results); name a summary.json", summary.string());
  }
  require_known_schema(run.summary, summary.string());
  if (run.folder.empty()) return run;
  if (path_exists(run.folder / "manifest.json")) run.manifest = parsed(run.folder / "manifest.json");
  if (path_exists(run.folder / "experiment.toml")) {
    run.keys = keys_of_experiment(read_file(run.folder / "experiment.toml"));
    if (const auto blocks = run.keys.find("response.blocks"); blocks != run.keys.end()) {
      run.blocks = std::max(2, std::atoi(blocks->second.c_str()));  // NOLINT(cert-err34-c): checked when it was read
    }
  }
  return run;
}

std::map<std::string, double> numbers_of(const Json& summary) {
  std::map<std::string, double> numbers;
  for (const auto& [key, value] : summary.items()) {
    if (key != "figures" && key != "schema") collect(value, "/" + key, numbers);
  }
  return numbers;
}

std::map<std::string, std::string> environment_of(const Json& manifest) {
  static const std::set<std::string> told = {"program",          "git_commit",        "git_dirty",  "sampling_version",
                                             "compiler",         "compiler_flags",    "build_type", "host_cpu",
                                             "operating_system", "processor_features"};
  std::map<std::string, std::string> environment;
  const auto add = [&](const std::string& prefix, const Json& holder, bool all) {
    if (!holder.is_object()) return;
    for (const auto& [name, value] : holder.items()) {
      if (!all && !told.contains(name)) continue;
      environment[prefix + name] = value.is_string() ? value.get<std::string>() : value.dump();
    }
  };
  if (!manifest.is_object()) return environment;
  const Json& from = manifest.value("provenance", Json::object());
  add("", from, false);
  if (from.is_object()) add("library ", from.value("libraries", Json::object()), true);
  add("", manifest.value("environment", Json::object()), true);
  return environment;
}

namespace {

/// Tables of what is shown and told, and what is expected.
constexpr std::array untold_tables = {"experiment", "figures.", "scenes.", "report", "gate."};
/// What numbers the samples, how many there are, and how they are dealt for the jackknife.
constexpr std::array sample_keys = {"sampling.seed", "response.samples", "response.blocks",
                                    "precision.c",   "precision.D",      "precision.most_samples"};

/// Layers of the profiles are fitted beside the others, so that they are in the summary.
bool is_told_only(const std::string& key) {
  if (key == "figures.response_profiles.mu" || key == "figures.response_profiles.layers") return false;
  return std::ranges::any_of(untold_tables, [&](const char* table) { return key.starts_with(table); });
}

/// Keys of a resolved experiment (print_experiment) with their values as written, by path, without those that change
/// nothing that is measured: name, description, figures, scenes, report, expected verdicts.
std::map<std::string, std::string> measuring_keys(std::string_view resolved_experiment) {
  std::map<std::string, std::string> settings;
  std::istringstream lines{std::string(resolved_experiment)};
  std::string table;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('[')) {
      table = line.substr(1, line.find(']') - 1);
      continue;
    }
    const std::size_t equals = line.find(" = ");
    if (line.empty() || line.starts_with('#') || equals == std::string::npos) continue;
    const std::string key = table + "." + line.substr(0, equals);
    if (!is_told_only(key)) settings[key] = line.substr(equals + 3);
  }
  return settings;
}

}  // namespace

std::map<std::string, std::string> keys_of_experiment(const std::string& resolved) {
  try {
    return measuring_keys(print_experiment(parse_experiment(resolved, "experiment.toml")));
  } catch (const InputError&) {
    return measuring_keys(resolved);
  }
}

std::vector<ChangedKey> changed_keys(const std::map<std::string, std::string>& before,
                                     const std::map<std::string, std::string>& after) {
  std::vector<ChangedKey> changed;
  for (const auto& [key, value] : before) {
    const auto found = after.find(key);
    if (found == after.end() || found->second != value) {
      changed.push_back({key, value, found == after.end() ? "" : found->second});
    }
  }
  for (const auto& [key, value] : after) {
    if (!before.contains(key)) changed.push_back({key, "", value});
  }
  // What the others follow from comes first.
  std::stable_partition(changed.begin(), changed.end(), [](const ChangedKey& one) {
    return one.key.starts_with("model.") || one.key == "sampling.law" || one.key.starts_with("lattice.");
  });
  return changed;
}

std::string in_words(const std::vector<ChangedKey>& changed) {
  constexpr std::size_t most_told = 5, most_bytes = 60;
  const auto shown = [](const std::string& value) {
    return value.empty() ? "nothing" : single_line(value, most_bytes);
  };
  std::vector<std::string> told;
  for (std::size_t i = 0; i < std::min(changed.size(), most_told); ++i) {
    told.push_back(
        fmt::format("{} = {} where {} was", changed[i].key, shown(changed[i].after), shown(changed[i].before)));
  }
  return fmt::format("{}{}", fmt::join(told, ", "),
                     changed.size() > most_told ? fmt::format(", and {} more", changed.size() - most_told) : "");
}

namespace {

/// One word for all of these numbers.
std::string hash_of(const std::map<std::string, double>& numbers) {
  std::string text;
  for (const auto& [place, number] : numbers) text += fmt::format("{}={}\n", place, exact(number));
  return cache_key(text);
}

/// Whether only another part of the same ensembles is drawn: another seed, number of samples or of blocks.
bool only_other_samples(const std::vector<ChangedKey>& changed) {
  return std::ranges::all_of(
      changed, [](const ChangedKey& one) { return std::ranges::find(sample_keys, one.key) != sample_keys.end(); });
}

constexpr std::array build_keys = {"program", "git_commit", "git_dirty", "compiler"};

/// Path and hash of the files that a run lists.
std::map<std::string, std::string> listed_files(const RunRecord& run) {
  std::map<std::string, std::string> files;
  if (!run.manifest || !run.manifest->is_object()) return files;
  for (const Json& file : run.manifest->value("files", Json::array())) {
    if (file.is_object() && file.contains("path") && file.contains("sha256") && file.at("sha256").is_string()) {
      files[file.at("path")] = file.at("sha256");
    }
  }
  return files;
}

bool same_sums(const BlockSums& one, const BlockSums& other) {
  if (one.layers != other.layers || one.count != other.count || one.quantities.size() != other.quantities.size()) {
    return false;
  }
  return std::ranges::all_of(one.quantities, [&](const auto& named) {
    const auto found = other.quantities.find(named.first);
    return found != other.quantities.end() && found->second.sum == named.second.sum &&
           found->second.sum_of_squares == named.second.sum_of_squares;
  });
}

/// Whether the sums in two files differ: their bytes may, where another HDF5 wrote them.
bool sums_differ(const fs::path& before, const fs::path& after) {
  try {
    return !same_sums(read_ensemble(before).sums, read_ensemble(after).sums);
  } catch (const InputError&) {
    return true;
  }
}

/// Whether one build of the program made both. Pictures carry its commit, so that those of two builds differ in any
/// case.
bool same_build(const RunRecord& before, const RunRecord& after) {
  if (!before.manifest || !after.manifest) return false;
  auto one = environment_of(*before.manifest), other = environment_of(*after.manifest);
  return std::ranges::all_of(build_keys, [&](const char* key) { return one[key] == other[key]; });
}

/// The first file of such a folder whose hashes differ; "" if there is none.
std::string first_other_file(const RunRecord& before, const RunRecord& after, const std::string& folder) {
  const std::map<std::string, std::string> ours = listed_files(before), theirs = listed_files(after);
  const bool pictures = same_build(before, after);
  for (const auto& [path, hash] : ours) {
    const auto found = theirs.find(path);
    if (!path.starts_with(folder) || found == theirs.end() || found->second == hash) continue;
    const bool picture = path.ends_with(".svg") || path.ends_with(".pdf") || path.ends_with(".png");
    if (picture && !pictures) continue;
    if (folder != "ensembles/" || sums_differ(before.folder / path, after.folder / path)) return path;
  }
  return "";
}

/// The standard error that belongs to a number of a summary, by its place; NaN if it has none.
double error_of(const std::map<std::string, double>& numbers, const std::string& place) {
  const std::string value = "/value";
  if (!place.ends_with(value)) return std::nan("");
  const auto found = numbers.find(place.substr(0, place.size() - value.size()) + "/stderr");
  return found == numbers.end() ? std::nan("") : found->second;
}

/// Finds the first number that differs, and by how many standard errors they differ at most.
void find_other_numbers(const RunRecord& before, const RunRecord& after, Comparison& comparison) {
  const std::map<std::string, double> ours = numbers_of(before.summary), theirs = numbers_of(after.summary);
  comparison.hash_before = hash_of(ours);
  comparison.hash_after = hash_of(theirs);
  if (comparison.hash_before == comparison.hash_after) return;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [place, number] : ours) {
    const auto found = theirs.find(place);
    if (found != theirs.end() && found->second == number) continue;
    if (comparison.place.empty()) comparison.place = place;
    if (found == theirs.end()) {
      comparison.largest = infinity;
      continue;
    }
    const double error = error_of(ours, place), difference = std::abs(found->second - number);
    // A number without an error of its own counts by its own size.
    const double apart =
        error > 0 ? difference / error : difference / std::max(std::abs(number), std::abs(found->second));
    comparison.largest = std::max(comparison.largest, error == 0 ? infinity : apart);
  }
  for (const auto& [place, number] : theirs) {
    if (ours.contains(place)) continue;
    if (comparison.place.empty()) comparison.place = place;
    comparison.largest = infinity;
  }
}

/// Of summaries alone: what is drawn as far as it stands there.
std::map<std::string, std::string> keys_in_summary(const Json& summary) {
  std::map<std::string, std::string> keys;
  const auto add = [&](const Json& holder, const char* name, const std::string& key) {
    if (holder.contains(name)) keys[key] = holder.at(name).dump();
  };
  add(summary, "columns", "lattice.columns");
  add(summary, "layers", "lattice.layers");
  add(summary, "seed", "sampling.seed");
  add(summary, "overload", "response.overload");
  for (const Json& result : summary.at("results")) {
    if (!result.is_object()) continue;
    const std::string scanned = scanned_in(summary);
    const std::string value = result.contains(scanned) ? result.at(scanned).dump() : "?";
    ResponseSpec response;
    add(result, "law", fmt::format("law at {} = {}", scanned, value));
    for (const Key& key : keys_of(response)) {
      if (key.name == "samples" || key.name == "blocks") continue;
      add(result, key.name.c_str(), fmt::format("{} at {} = {}", key.name, scanned, value));
    }
    // Those that failed are the same samples, too.
    const std::uint64_t begun =
        result.value("samples", std::uint64_t{0}) + (result.contains("failed") ? result.at("failed").size() : 0);
    if (result.value(scanned, 0.0) > 0) keys["response.samples"] = std::to_string(begun);
  }
  return keys;
}

std::vector<std::string> causes_of(const RunRecord& before, const RunRecord& after) {
  std::vector<std::string> causes;
  for (const ChangedKey& one : changed_keys(environment_of(*before.manifest), environment_of(*after.manifest))) {
    causes.push_back(
        fmt::format("{}: {} where {} was", one.key, single_line(one.after, 80), single_line(one.before, 80)));
  }
  return causes;
}

std::string in_errors(double apart) {
  return std::isinf(apart) ? "without limit (an exact number, or one that is missing)"
                           : fmt::format("{} standard errors", significant(apart, 2));
}

std::string in_words(const MovedNumber& number) {
  return fmt::format("{}: {} to {}, pull {}, p = {}", number.name,
                     value_with_error(number.before.value, number.before.standard_error),
                     value_with_error(number.after.value, number.after.standard_error), significant(number.z, 2),
                     significant(number.p, 2));
}

const MovedNumber* largest_of(const std::vector<MovedNumber>& numbers) {
  const auto found = std::ranges::max_element(
      numbers, [](const MovedNumber& a, const MovedNumber& b) { return std::abs(a.z) < std::abs(b.z); });
  return found == numbers.end() ? nullptr : &*found;
}

}  // namespace

void to_json(Json& json, const KnownNumber& number) {
  json = {{"value", number.value}, {"stderr", number.standard_error}};
}

void to_json(Json& json, const MovedNumber& one) {
  json = {{"name", one.name},           {"before", one.before}, {"after", one.after},
          {"z", finite_or_null(one.z)}, {"p", one.p},           {"moved", one.moved}};
  if (!std::isfinite(one.z)) json["reason"] = "exact numbers differ";
}

std::string name_of(Likeness likeness) {
  static constexpr Names<Likeness, 4> names{{{Likeness::same, "same"},
                                             {Likeness::other_numbers, "other numbers"},
                                             {Likeness::other_samples, "other samples"},
                                             {Likeness::other_experiment, "other experiment"}}};
  return name_in(names, likeness);
}

std::string name_of(FirstDifference where) {
  static constexpr Names<FirstDifference, 4> names{{{FirstDifference::none, "none"},
                                                    {FirstDifference::sampling, "sampling"},
                                                    {FirstDifference::analysis, "analysis"},
                                                    {FirstDifference::plotting, "plotting"}}};
  return name_in(names, where);
}

bool Comparison::alarms() const {
  if (likeness == Likeness::other_numbers) return !is_rounding();
  return std::ranges::any_of(numbers, [](const MovedNumber& one) { return one.moved; });
}

Comparison compare_runs(const RunRecord& before, const RunRecord& after) {
  Comparison comparison;
  const auto tell_changed = [&](const std::string& begins) {
    for (const RunRecord* run : {&before, &after}) {
      const std::string changed = run->folder.empty() ? "" : changed_since_run(run->folder, begins);
      if (changed.empty()) continue;
      comparison.causes.push_back(fmt::format("{}: changed or damaged since its run, by the digest in manifest.json",
                                              (run->folder / changed).string()));
    }
  };
  const bool both = !before.keys.empty() && !after.keys.empty();
  comparison.keys = both ? changed_keys(before.keys, after.keys)
                         : changed_keys(keys_in_summary(before.summary), keys_in_summary(after.summary));
  find_other_numbers(before, after, comparison);
  if (!comparison.keys.empty()) {
    for (const char* part : {"experiment.toml", "summary.json"}) tell_changed(part);
    comparison.numbers =
        hold_against(primary_numbers(before.summary), before.blocks, primary_numbers(after.summary), after.blocks);
    if (!only_other_samples(comparison.keys)) {
      comparison.likeness = Likeness::other_experiment;
      // Exponents belong to windows and lists that may differ; what was measured at one value may be shown side by
      // side.
      std::erase_if(comparison.numbers,
                    [](const MovedNumber& one) { return one.name.find(" at ") == std::string::npos; });
      for (MovedNumber& one : comparison.numbers) one.moved = false;
      return comparison;
    }
    comparison.likeness = Likeness::other_samples;
    comparison.depths =
        hold_against(depth_numbers(before.summary), before.blocks, depth_numbers(after.summary), after.blocks);
    for (MovedNumber& detail : comparison.depths) detail.moved = false;
    return comparison;
  }
  const std::string sums = first_other_file(before, after, "ensembles/");
  const bool numbers_differ = comparison.hash_before != comparison.hash_after;
  const std::string figure = numbers_differ || !sums.empty() ? "" : first_other_file(before, after, "figures/");
  if (!numbers_differ && sums.empty() && figure.empty()) return comparison;
  comparison.likeness = Likeness::other_numbers;
  comparison.where = !sums.empty()    ? FirstDifference::sampling
                     : numbers_differ ? FirstDifference::analysis
                                      : FirstDifference::plotting;
  if (!sums.empty()) comparison.place = sums;
  if (!figure.empty()) comparison.place = figure;
  comparison.causes_known = before.manifest.has_value() && after.manifest.has_value();
  comparison.causes = comparison.causes_known ? causes_of(before, after) : std::vector<std::string>();
  tell_changed("");
  return comparison;
}

namespace {

std::map<std::string, std::string> verdicts_of(const Json& summary) {
  std::map<std::string, std::string> verdicts;
  for (const Json& claim : summary.value("claims", Json::array())) {
    if (claim.contains("id") && claim.contains("verdict")) verdicts[claim.at("id")] = claim.at("verdict");
  }
  return verdicts;
}

std::vector<std::string> changed_verdicts(const Json& before, const Json& after) {
  const std::map<std::string, std::string> then = verdicts_of(before);
  std::vector<std::string> changed;
  for (const auto& [claim, verdict] : verdicts_of(after)) {
    const auto was = then.find(claim);
    if (was == then.end() || was->second == verdict) continue;
    changed.push_back(fmt::format("{}: {} where it was {}", claim, verdict, was->second));
  }
  return changed;
}

}  // namespace

Comparison compare_runs(const fs::path& before, const fs::path& after) {
  const RunRecord one = read_run(before), other = read_run(after);
  try {
    Comparison comparison = compare_runs(one, other);
    comparison.verdicts = changed_verdicts(one.summary, other.summary);
    return comparison;
  } catch (const Json::exception& error) {
    throw InputError(
        "{} or {}: a summary.json or manifest.json is not as granuscope writes it ({}), so that nothing can be "
        "compared; make the run again",
        before.string(), after.string(), error.what());
  }
}

std::vector<std::string> describe(const Comparison& comparison) {
  std::vector<std::string> lines;
  switch (comparison.likeness) {
    case Likeness::same:
      lines.push_back(fmt::format("same: every value and error is equal (numbers {})", comparison.hash_after));
      break;
    case Likeness::other_numbers:
      lines.push_back(fmt::format("same experiment, other numbers: {} differs first, in {}", comparison.place,
                                  name_of(comparison.where)));
      if (comparison.where != FirstDifference::plotting) {
        lines.push_back(fmt::format("the largest difference is {}{}", in_errors(comparison.largest),
                                    comparison.is_rounding() ? ": rounding, as by a C library without FMA" : ""));
      }
      if (!comparison.causes_known) {
        lines.emplace_back("why is not known: both runs' folders would tell by their manifest.json");
      } else if (comparison.causes.empty() && !comparison.is_rounding()) {
        lines.emplace_back(
            "not reproducible: program, libraries and processor are the same, so that this is a fault; please report "
            "it");
      }
      break;
    case Likeness::other_samples: {
      const auto moved = std::ranges::count_if(comparison.numbers, [](const MovedNumber& one) { return one.moved; });
      lines.push_back(fmt::format("same experiment but for {}: {} of {} primary numbers moved",
                                  in_words(comparison.keys), moved, comparison.numbers.size()));
      for (const MovedNumber& one : comparison.numbers) {
        if (one.moved) lines.push_back("moved: " + in_words(one));
      }
      if (const MovedNumber* most = largest_of(comparison.numbers); most != nullptr && moved == 0) {
        lines.push_back("furthest apart: " + in_words(*most));
      }
      if (const MovedNumber* most = largest_of(comparison.depths)) {
        lines.push_back(fmt::format("of {} numbers of single depths, not judged, furthest apart: {}",
                                    comparison.depths.size(), in_words(*most)));
      }
      break;
    }
    case Likeness::other_experiment:
      lines.push_back("other experiments: " + in_words(comparison.keys));
      if (!comparison.numbers.empty()) lines.emplace_back("what both measured, not judged, since it need not agree:");
      for (const MovedNumber& one : comparison.numbers) lines.push_back(in_words(one));
  }
  for (const std::string& cause : comparison.causes) lines.push_back("differs: " + cause);
  std::size_t tested_by_one = 0;  // what another experiment does not measure has not changed
  for (const std::string& changed : comparison.verdicts) {
    if (comparison.likeness == Likeness::other_experiment && changed.find("not tested") != std::string::npos) {
      ++tested_by_one;
    } else {
      lines.push_back("verdict changed: " + changed);
    }
  }
  if (tested_by_one > 0) lines.push_back(fmt::format("claims that only one of them tests: {}", tested_by_one));
  for (std::string& line : lines) line = single_line(line, line.size());
  return lines;
}

std::string json_text(const Comparison& comparison) {
  Json json = {{"schema", 1},
               {"likeness", name_of(comparison.likeness)},
               {"alarm", comparison.alarms()},
               {"lines", describe(comparison)},
               {"hash_before", comparison.hash_before},
               {"hash_after", comparison.hash_after}};
  if (comparison.likeness == Likeness::other_numbers) {
    json["first_difference"] = {{"stage", name_of(comparison.where)},
                                {"place", comparison.place},
                                {"largest_in_standard_errors", finite_or_null(comparison.largest)},
                                {"rounding", comparison.is_rounding()}};
    json["causes"] = comparison.causes;
  }
  Json keys = Json::array();
  for (const ChangedKey& one : comparison.keys) {
    keys.push_back({{"key", one.key}, {"before", one.before}, {"after", one.after}});
  }
  json["keys"] = keys;
  json["changed_verdicts"] = comparison.verdicts;
  json["numbers"] = comparison.numbers;
  json["depths"] = comparison.depths;
  clean_strings(json);
  return json.dump(2) + "\n";
}

namespace {

constexpr double tiny = 1e-12;       ///< of numbers that are exact without friction, as in claims.cc
constexpr double tiny_width = 1e-5;  ///< the root of what rounding leaves of W^2

void add_known(std::vector<KnownNumber>& numbers, const std::string& name, const Json& holder, const char* key) {
  const auto found = holder.find(key);
  if (found == holder.end() || !found->is_object()) return;
  const auto value = found->find("value"), error = found->find("stderr");
  if (value == found->end() || error == found->end() || !value->is_number() || !error->is_number()) return;
  numbers.push_back({name, value->get<double>(), error->get<double>()});
}

std::string at_value(const std::string& scanned, double value) {
  return fmt::format("at {} = {}", scanned, exact(value));
}

/// Calls `use` for each result with where it is: "at mu = 0.3".
template <class Use>
void for_each_result(const Json& summary, Use use) {
  const auto results = summary.find("results");
  if (results == summary.end() || !results->is_array()) return;
  const std::string scanned = scanned_in(summary);
  for (const Json& result : *results) {
    if (!result.is_object() || !result.contains(scanned) || !result.at(scanned).is_number()) continue;
    use(result, at_value(scanned, result.at(scanned).get<double>()));
  }
}

/// After Welch and Satterthwaite, of the difference of two means with these variances.
double degrees_of_freedom(double before, int blocks_before, double after, int blocks_after) {
  const double sum = before + after;
  if (sum <= 0) return 1;
  return sum * sum / (before * before / (blocks_before - 1) + after * after / (blocks_after - 1));
}

}  // namespace

std::vector<KnownNumber> primary_numbers(const Json& summary) {
  std::vector<KnownNumber> numbers;
  for_each_result(summary, [&](const Json& result, const std::string& where) {
    for (const char* key : {"c", "D", "c_thrust"}) add_known(numbers, fmt::format("{} {}", key, where), result, key);
  });
  if (const auto scaling = summary.find("scaling"); scaling != summary.end() && scaling->is_object()) {
    for (const char* key : {"beta", "gamma", "alpha"}) add_known(numbers, key, *scaling, key);
  }
  return numbers;
}

std::vector<KnownNumber> primary_numbers_of(const Analysis& analysis) {
  std::vector<KnownNumber> numbers;
  const auto add = [&](const std::string& name, const Estimate& estimate) {
    if (estimate.known()) numbers.push_back({name, estimate.value, estimate.standard_error});
  };
  for (const Transport& result : analysis.results) {
    const std::string where = at_value(result.scan->name, result.scanned());
    add("c " + where, result.c);
    add("D " + where, result.D);
    add("c_thrust " + where, result.c_thrust);
  }
  add("beta", analysis.scaling.beta.exponent);
  add("gamma", analysis.scaling.gamma.exponent);
  add("alpha", analysis.scaling.alpha.exponent);
  return numbers;
}

std::vector<KnownNumber> depth_numbers(const Json& summary) {
  std::vector<KnownNumber> numbers;
  for_each_result(summary, [&](const Json& result, const std::string& where) {
    const auto depths = result.find("depths");
    if (depths == result.end() || !depths->is_array()) return;
    for (const Json& depth : *depths) {
      if (!depth.is_object() || !depth.contains("layer")) continue;
      const bool narrow = depth.contains("identifiable") && depth.at("identifiable") == false;
      for (const char* key : {"peak_position", "width", "thrust_ratio"}) {
        if (narrow && std::string_view(key) == "width") continue;  // the size of a bead hides it
        add_known(numbers, fmt::format("{} {}, layer {}", key, where, depth.at("layer").dump()), depth, key);
        if (!numbers.empty() && std::abs(numbers.back().value) < tiny_width) numbers.back().value = 0;
      }
    }
  });
  return numbers;
}

double chance_of(double t, double degrees_of_freedom) {
  if (std::isinf(t)) return 0;
  return 2 * gsl_cdf_tdist_Q(std::abs(t), degrees_of_freedom);
}

std::vector<MovedNumber> hold_against(const std::vector<KnownNumber>& before, int blocks_before,
                                      const std::vector<KnownNumber>& after, int blocks_after) {
  std::vector<MovedNumber> numbers;
  for (const KnownNumber& old : before) {
    const auto found = std::ranges::find_if(after, [&](const KnownNumber& one) { return one.name == old.name; });
    if (found == after.end()) continue;
    MovedNumber number{old.name, old, *found};
    const double difference = found->value - old.value;
    const double before_variance = old.standard_error * old.standard_error,
                 after_variance = found->standard_error * found->standard_error;
    const double error = std::sqrt(before_variance + after_variance);
    if (error > 0) {
      number.z = difference / error;
    } else if (std::abs(difference) > tiny * std::max(1.0, std::abs(old.value))) {
      number.z = std::copysign(std::numeric_limits<double>::infinity(), difference);
    }
    number.p = chance_of(number.z, degrees_of_freedom(before_variance, blocks_before, after_variance, blocks_after));
    numbers.push_back(number);
  }
  // Holm: the smallest chance against rate/n, the next against rate/(n - 1), up to the first that is large enough.
  std::vector<std::size_t> order(numbers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return numbers[a].p < numbers[b].p; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (numbers[order[k]].p > false_alarm_rate / static_cast<double>(order.size() - k)) break;
    numbers[order[k]].moved = true;
  }
  return numbers;
}

}  // namespace granuscope
