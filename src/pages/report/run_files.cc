#include "report/run_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

#include "plot/gnuplot.h"
#include "report/clean_json.h"
#include "sampling/sampler_spec.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
constexpr const char* manifest_file = "manifest.json";

/// Of a manifest but for this digest itself: what was changed by hand is not gone by.
std::string digest_of(Json manifest) {
  manifest.erase("digest");
  return cache_key(manifest.dump());
}

/// What `read` makes of a run's manifest; nothing where there is none, or it is damaged or somebody else's.
template <class Read>
auto told_by_manifest(const fs::path& run_folder, const Read& read) -> decltype(read(Json())) {
  try {
    return read(Json::parse(read_json(run_folder / manifest_file)));
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace

std::optional<FinishedRun> find_finished_run(const fs::path& run_folder, const std::string& made_from,
                                             const std::set<std::string>& stages) {
  // Of an older program, or damaged: then it is made again.
  return told_by_manifest(run_folder, [&](const Json& manifest) -> std::optional<FinishedRun> {
    if (manifest.at("status").get<std::string>() != "done" || !manifest.contains("digest")) return {};
    const FinishedRun run{manifest.at("made_from"), manifest.at("stages"), manifest.at("unexpected"),
                          manifest.at("pdf")};
    if (run.made_from != made_from) return {};
    if (!std::includes(run.stages.begin(), run.stages.end(), stages.begin(), stages.end())) return {};
    return changed_since_run(run_folder, "", "", true).empty() ? std::optional(run) : std::nullopt;
  });
}

bool lies_in(const fs::path& run_folder, const fs::path& path) {
  if (path.empty() || path.is_absolute() || path != path.lexically_normal() || *path.begin() == "..") return false;
  fs::path at = run_folder;
  return std::none_of(path.begin(), path.end(), [&](const fs::path& step) {
    std::error_code none;
    return fs::is_symlink(at /= step, none);
  });
}

void require_results_of_last_run(const fs::path& run_folder, const std::string& stage) {
  require_visible(run_folder / manifest_file);
  if (!path_exists(run_folder / manifest_file)) return;
  const auto manifest = Json::parse(read_json(run_folder / manifest_file), nullptr, false);
  const auto stages = manifest.is_object() ? manifest.value("stages", Json::array()) : Json::array();
  if (std::find(stages.begin(), stages.end(), stage) != stages.end()) return;
  const FileDescriptor folder(::open(run_folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock_file(folder, true)) throw BusyError("{}: a run is at work here; wait for its end", run_folder.string());
  const bool earlier = path_exists(run_folder / "summary.json");
  throw InputError(
      "{}: the last run in this folder did not come to its {}{}; go on with it: {}", run_folder.string(), stage,
      earlier ? ", so that summary.json and the figures are of an earlier one and experiment.toml of another" : "",
      run_again(run_folder));
}

std::string run_again(const fs::path& run_folder) {
  return fmt::format("granuscope run {} --out {}", shell_word((run_folder / "experiment.toml").string()),
                     shell_word(run_folder.string()));
}

std::string changed_since_run(const fs::path& run_folder, const std::string& begins, const std::string& ends,
                              bool whole) {
  const auto changed = told_by_manifest(run_folder, [&](const Json& manifest) -> std::optional<std::string> {
    if (manifest.contains("digest") && manifest.at("digest") != digest_of(manifest)) return manifest_file;
    for (const auto& file : manifest.at("files")) {
      std::string name = file.at("path");
      const bool passed = !whole && (name.ends_with(".gp") || !file.at("sha256").is_string());
      if (passed || !name.starts_with(begins) || !name.ends_with(ends)) continue;
      if (!lies_in(run_folder, name)) return name;
      if (!whole && !path_exists(run_folder / name)) continue;  // who reads it says that it is missing
      if (!file_exists(run_folder / name) || file.at("sha256") != sha256_of_file(run_folder / name)) return name;
    }
    return "";
  });
  return changed.value_or(whole ? manifest_file : "");  // of an older program, or none
}

std::vector<ListedFigure> list_figures(const fs::path& run_folder) {
  std::vector<ListedFigure> list;
  const std::vector<std::string> plots = plots_in(run_folder / "figures");
  if (const auto file = run_folder / "summary.json"; file_exists(file)) {
    const auto summary = Json::parse(read_json(file), nullptr, false);
    const auto figures = summary.is_object() ? summary.find("figures") : summary.end();
    for (std::size_t i = 0; figures != summary.end() && figures->is_array() && i < figures->size(); ++i) {
      const auto& one = (*figures)[i];
      const auto text = [&one](const char* key) {
        return one.is_object() && one.contains(key) && one[key].is_string() ? single_line(one[key].get<std::string>())
                                                                            : std::string();
      };
      list.push_back({text("id"), text("title"), std::ranges::count(plots, text("id")) > 0});
    }
  }
  for (const std::string& id : plots) {
    if (std::none_of(list.begin(), list.end(), [&id](const ListedFigure& one) { return one.id == id; }))
      list.push_back({id, "", true});
  }
  return list;
}

std::string left_out_by_run(const fs::path& run_folder) {
  return told_by_manifest(run_folder, [](const Json& manifest) {
    std::string told;
    for (const std::string one : manifest.at("skipped"))
      if (one.find(" is left out") != std::string::npos) told += " " + one;
    return told;
  });
}

void require_unchanged(const fs::path& run_folder, const std::string& begins, const std::string& ends) {
  const std::string changed = changed_since_run(run_folder, begins, ends);
  if (changed.empty()) return;
  throw InputError(
      "{}: {} is not what the run left there, by the digest in manifest.json: it was changed or damaged since. Take it "
      "from a backup, or make it again: {}",
      run_folder.string(), changed, run_again(run_folder));
}

namespace {

Json object_of(const std::vector<std::pair<std::string, std::string>>& pairs) {
  Json json = Json::object();
  for (const auto& [name, value] : pairs) json[name] = value;
  return json;
}

}  // namespace

void to_json(Json& json, const Provenance& provenance) {
  json["program"] = provenance.program_version;
  json["git_commit"] = provenance.git_commit;
  json["git_dirty"] = provenance.git_dirty;
  json["sampling_version"] = sampling_version;
  json["compiler"] = provenance.compiler;
  json["compiler_flags"] = provenance.compiler_flags;
  json["build_type"] = provenance.build_type;
  json["libraries"] = object_of(provenance.libraries);
  json["host_cpu"] = provenance.host_cpu;
  json["processor_features"] = provenance.processor_features;
  json["operating_system"] = provenance.operating_system;
  json["hardware_threads"] = provenance.hardware_threads;
}

void to_json(Json& stage, const StageTiming& timing) {
  stage["stage"] = timing.stage;
  stage["seconds"] = finite_or_null(timing.seconds);
  stage["reused"] = timing.reused;
  if (timing.beads > 0) stage["beads"] = timing.beads;
}

namespace {

Json stages_json(const std::vector<StageTiming>& timings, const std::map<std::string, StageTiming>& earlier) {
  Json json = timings;
  for (const auto& [stage, told] : earlier) {
    const auto is_it = [&name = stage](const StageTiming& timing) { return timing.stage == name; };
    if (std::none_of(timings.begin(), timings.end(), is_it)) json.push_back(told);
  }
  return json;
}

/// What a run leaves at the top of its folder and below it. A folder may hold more: that of a user who wrote --out . is
/// not to be read as a whole, nor to be listed in what is then passed on.
constexpr std::array results = {"experiment.toml", "summary.json", "summary.md", "claims.xml", "timings.json",
                                "report.html",     "report.pdf",   "ensembles",  "piles",      "figures"};

bool hidden(const fs::path& relative) {
  return std::any_of(relative.begin(), relative.end(),
                     [](const fs::path& part) { return part.string().starts_with('.'); });
}

/// Relative paths of all regular files of the run, sorted. Unreadable folders are left out: a manifest of a failed run
/// must not fail itself.
std::vector<fs::path> files_of_run(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* result : results) {
    std::error_code error;
    const fs::file_status status = fs::symlink_status(folder / result, error);
    if (fs::is_symlink(status)) continue;  // what it leads to is elsewhere
    if (fs::is_regular_file(status)) files.emplace_back(result);
    const auto options = fs::directory_options::skip_permission_denied;
    fs::recursive_directory_iterator at(folder / result, options, error);
    for (const fs::recursive_directory_iterator end; !error && at != end; at.increment(error)) {
      std::error_code no_status;
      const fs::path relative = at->path().lexically_relative(folder);
      if (fs::is_regular_file(at->symlink_status(no_status)) && !hidden(relative)) files.push_back(relative);
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::vector<fs::path> keep_changed(const fs::path& run_folder, bool dry) {
  return told_by_manifest(run_folder, [&](const Json& manifest) {
    std::map<std::string, Json> left;
    for (const Json& file : manifest.at("files")) left[file.at("path")] = file.at("sha256");
    const std::set<std::string> figures = manifest.at("figure_files");
    std::vector<fs::path> changed;
    for (const fs::path& file : files_of_run(run_folder)) {
      const bool report = !left.empty() && std::count(report_names.begin(), report_names.end(), file) > 0;
      const auto was = left.find(file.string());
      const bool ours = was != left.end() && was->second == sha256_of_file(run_folder / file);
      if (ours || (!report && (was == left.end() || !figures.contains(file.string())))) continue;
      changed.push_back(file);
      fs::path kept = run_folder / file;
      while (path_exists(kept)) kept += ".kept";
      if (!dry) fs::rename(run_folder / file, kept);
    }
    return changed;
  });
}

namespace {

Json files_json(const fs::path& folder) {
  Json json = Json::array();
  for (const fs::path& relative : files_of_run(folder)) {
    std::error_code error;
    const auto bytes = fs::file_size(folder / relative, error);
    Json file;
    file["path"] = relative.generic_string();
    file["bytes"] = error ? Json(nullptr) : Json(bytes);
    try {
      file["sha256"] = sha256_of_file(folder / relative);
    } catch (const Error& unreadable) {
      file["sha256"] = nullptr;
      file["reason"] = unreadable.what();
    }
    json.push_back(file);
  }
  return json;
}

}  // namespace

std::string manifest_json(const ReportData& data, const fs::path& run_folder, const RunOutcome& outcome) {
  Json json;
  json["schema"] = 1;
  json["experiment"] = data.experiment_name;
  json["description"] = data.description;
  json["status"] = outcome.status;
  json["exit_code"] = outcome.exit_code ? Json(*outcome.exit_code) : Json(nullptr);
  json["error"] = outcome.error.empty() ? Json(nullptr) : Json(outcome.error);
  json["started"] = data.started;
  json["finished"] = current_time();
  json["seed"] = data.seed;
  json["experiment_key"] = data.resolved_experiment_key;
  if (!outcome.finished.made_from.empty()) {
    json["made_from"] = outcome.finished.made_from;
    json["stages"] = outcome.finished.stages;
    json["unexpected"] = outcome.finished.unexpected;
    json["pdf"] = outcome.finished.pdf;
  }
  json["figure_files"] = outcome.figure_files;
  json["provenance"] = data.provenance;
  json["environment"] = object_of(data.environment);
  json["timings"] = stages_json(data.timings, outcome.earlier_timings);
  json["skipped"] = data.skipped;
  if (!data.reuse.empty()) json["skipped"].push_back(data.reuse);
  json["files"] = outcome.exit_code ? files_json(run_folder) : Json::array();
  clean_strings(json);
  json["digest"] = digest_of(json);
  return json.dump(2) + "\n";
}

std::map<std::string, StageTiming> earlier_timings(const fs::path& run_folder) {
  return told_by_manifest(run_folder, [](const Json& manifest) {
    std::map<std::string, StageTiming> earlier;
    for (const Json& timing : manifest.at("timings")) {
      if (!timing.at("seconds").is_number()) continue;
      earlier[timing.at("stage")] = {timing.at("stage"), timing.at("seconds"), true,
                                     timing.value("beads", std::uint64_t{0})};
    }
    return earlier;
  });
}

std::optional<std::string> experiment_key_of_run(const fs::path& run_folder) {
  return told_by_manifest(run_folder, [](const Json& manifest) -> std::optional<std::string> {
    if (!manifest.at("provenance").contains("sampling_version")) return {};
    return manifest.at("experiment_key").get<std::string>();
  });
}

std::set<std::string> earlier_figure_files(const fs::path& run_folder) {
  std::set<std::string> files = told_by_manifest(
      run_folder, [](const Json& manifest) -> std::set<std::string> { return manifest.at("figure_files"); });
  std::erase_if(files, [](const fs::path& file) { return file.parent_path() != "figures"; });  // of any origin
  files.insert(pile_files.begin(), pile_files.end());
  return files;
}

std::string timings_json(const ReportData& data, const RunOutcome& outcome) {
  Json json;
  json["schema"] = 1;
  json["stages"] = stages_json(data.timings, outcome.earlier_timings);
  clean_strings(json);
  return json.dump(2) + "\n";
}

void write_manifest(const ReportData& data, const fs::path& run_folder, const RunOutcome& outcome) {
  // The first file of a run is the one that tells whose folder it is: a run may be killed after any of them.
  if (outcome.status != "unfinished") write_file(run_folder / "timings.json", timings_json(data, outcome));
  write_file(run_folder / manifest_file, manifest_json(data, run_folder, outcome));
}

}  // namespace granuscope
