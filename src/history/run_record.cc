#include "history/run_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "experiment/experiment_file.h"
#include "history/settings.h"
#include "report/finished_run.h"
#include "support/atomic_file.h"
#include "support/digest.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json parsed(const fs::path& file) {
  try {
    return Json::parse(read_file(file));
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: this is no JSON ({}), so that nothing can be compared; make the run again",
                                 file.string(), error.what()));
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
    throw InputError(fmt::format(
        "{}: there is neither a run nor a summary; name the folder of a run or its summary.json", path.string()));
  }
  if (fs::is_directory(path, none)) {
    run.folder = path;
    require_results_of_last_run(path, "report");
  }
  const fs::path summary = run.folder.empty() ? path : run.folder / "summary.json";
  if (!run.folder.empty() && !fs::exists(summary, none)) {
    throw InputError(
        fmt::format("{}: there is no summary.json in this folder, so that it is no finished run; run the "
                    "experiment to its end",
                    path.string()));
  }
  run.summary = parsed(summary);
  if (!run.summary.is_object() || !run.summary.contains("results")) {
    throw InputError(
        fmt::format("{}: this is no summary of a run (it has no results); name a summary.json", summary.string()));
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

}  // namespace granuscope
