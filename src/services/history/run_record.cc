#include "history/run_record.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>
#include <sstream>

#include "experiment/experiment_file.h"
#include "report/run_files.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json parsed(const fs::path& file) {
  try {
    return Json::parse(shallow_json(read_file(file)));
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

std::map<std::string, std::string> keys_of_experiment(const std::string& resolved) {
  try {
    return measuring_keys(print_experiment(parse_experiment(resolved, "experiment.toml")));
  } catch (const InputError&) {
    return measuring_keys(resolved);
  }
}

RunRecord read_run(const fs::path& path) {
  std::error_code none;
  RunRecord run;
  run.path = path;
  if (!fs::exists(path, none)) {
    throw InputError("{}: there is neither a run nor a summary; name the folder of a run or its summary.json",
                     path.string());
  }
  if (fs::is_directory(path, none)) {
    run.folder = path;
    require_results_of_last_run(path, "report");
  }
  const fs::path summary = run.folder.empty() ? path : run.folder / "summary.json";
  if (!run.folder.empty() && !fs::exists(summary, none)) {
    throw InputError(
        "{}: there is no summary.json in this folder, so that it is no finished run; run the experiment to its end",
        path.string());
  }
  run.summary = parsed(summary);
  if (!run.summary.is_object() || !run.summary.contains("results")) {
    throw InputError("{}: this is no summary of a run (it has no results); name a summary.json", summary.string());
  }
  if (run.folder.empty()) return run;
  if (fs::exists(run.folder / "manifest.json", none)) {
    run.manifest = parsed(run.folder / "manifest.json");
  }
  if (fs::exists(run.folder / "experiment.toml", none)) {
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

std::string hash_of(const std::map<std::string, double>& numbers) {
  std::string text;
  for (const auto& [place, number] : numbers) text += fmt::format("{}={}\n", place, exact(number));
  return cache_key(text);
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
/// What numbers the samples, and how many there are.
constexpr std::array sample_keys = {"sampling.seed", "response.samples", "precision.c", "precision.D",
                                    "precision.most_samples"};

/// Layers of the profiles are fitted beside the others, so that they are in the summary.
bool is_told_only(const std::string& key) {
  if (key == "figures.response_profiles.mu" || key == "figures.response_profiles.layers") return false;
  return std::ranges::any_of(untold_tables, [&](const char* table) { return key.starts_with(table); });
}

}  // namespace

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
  return changed;
}

bool only_other_samples(const std::vector<ChangedKey>& changed) {
  return std::ranges::all_of(
      changed, [](const ChangedKey& one) { return std::ranges::find(sample_keys, one.key) != sample_keys.end(); });
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

}  // namespace granuscope
