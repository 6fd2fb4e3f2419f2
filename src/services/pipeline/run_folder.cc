#include "pipeline/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "experiment/experiment_file.h"
#include "report/run_files.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {
/// What a run leaves, and what a history does; "samples" marks the ensembles from before a night.
constexpr std::array run_files = {
    "experiment.toml",    "manifest.json",      "timings.json",        "summary.json",      "summary.md",
    "claims.xml",         "report.html",        "report.pdf",          "samples",           "earlier-summary.json",
    "earlier-summary.md", "earlier-claims.xml", "earlier-report.html", "earlier-report.pdf"};
constexpr std::array run_folders = {"ensembles", "piles", "figures", "shards"};
const std::vector<std::string> history_entries = parts_between(
    "canary|pool|before|reports|index.html|badge.json|alert.md|history.sqlite|history.sqlite-wal|history.sqlite-shm",
    "|");

/// Whether this holds an ensemble or a pile of this program, or what is left of one.
bool is_drawn_by_us(const fs::path& file) {
  if (file.extension() != ".h5") return file.extension() == ".notes";
  std::string head(1024, ' ');
  std::ifstream(file, std::ios::binary).read(head.data(), 1024);
  return fs::file_size(file) == 0 || head.find("granuscope ") != std::string::npos;
}

template <class Names>
bool among(const Names& names, const fs::path& name) {
  return std::ranges::any_of(names, [&](const auto& one) { return name == one; });
}

std::string list_of(const std::vector<fs::path>& paths) {
  constexpr std::size_t told = 8;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(told, paths.size()); ++i) names.push_back(paths[i].string());
  return fmt::format("{}{}", fmt::join(names, ", "),
                     paths.size() > told ? fmt::format(" and {} more", paths.size() - told) : "");
}

/// Calls `look` with everything beneath a path, itself included; goes through no link.
template <class Look>
void walk(const fs::path& path, const Look& look) {
  std::error_code none;
  const fs::file_status status = fs::symlink_status(path, none);
  if (!fs::exists(status)) return;
  look(path, status);
  if (!fs::is_directory(status)) return;
  for (const fs::path& entry : entries_of(path)) walk(entry, look);
}

void require_no_links(const fs::path& folder) {
  std::vector<fs::path> links;
  const auto look_for_links = [&](const fs::path& path, const fs::file_status& status) {
    if (fs::is_symlink(status)) links.push_back(path);
  };
  for (const char* name : run_files) walk(folder / name, look_for_links);
  for (const char* name : run_folders) walk(folder / name, look_for_links);
  for (const std::string& name : history_entries) walk(folder / name, look_for_links);
  if (links.empty()) return;
  throw InputError(
      "{} {}, and what is written or removed there would be elsewhere; put the files themselves in {} place, or name a "
      "folder on another disk as a whole",
      list_of(links), links.size() == 1 ? "is a link" : "are links", links.size() == 1 ? "its" : "their");
}

/// Whether this file is a resolved experiment as this program prints it, the one to be run or another, and no text of a
/// user's.
bool is_printed(const fs::path& experiment, const std::string& resolved) {
  try {
    const std::string text = read_file(experiment);
    return text == resolved || print_experiment(parse_experiment(text, experiment.string())) == text;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

RunFolder::RunFolder(std::filesystem::path folder, FolderUse use) : path_(std::move(folder)) {
  make_folder(path_);
  // The folder itself is locked, so that no file is left behind; the system drops the lock with the process, however it
  // ends. Some network folders know no locks: there nothing holds two runs apart.
  lock_ = FileDescriptor(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock_file(lock_, use == FolderUse::shared)) {
    throw BusyError(
        "another run{} is working in '{}', and both would write the same files; wait for its end or choose another "
        "folder",
        use == FolderUse::shared ? "" : " or shard", path_.string());
  }
  if (use != FolderUse::read) require_no_links(path_);
  if (use != FolderUse::alone) return;
  for (const char* part : {"", "ensembles", "piles", "figures"}) leftovers_removed_ += remove_leftovers(path_ / part);
}

void require_no_history(const fs::path& folder) {
  std::error_code none;
  const fs::path whole = fs::absolute(folder, none).lexically_normal();
  const fs::path named = whole.has_filename() ? whole : whole.parent_path();
  const bool part = among(history_entries, named.filename()) || named.parent_path().filename() == "reports" ||
                    named.parent_path().filename() == "canary";
  for (const fs::path& of : {named, named.parent_path(), named.parent_path().parent_path()}) {
    if (!fs::exists(of / "history.sqlite", none) || (of != named && !part)) continue;
    throw InputError(
        "{}: this folder belongs to a history (granuscope nightly), and a run's files would be mixed with it; choose "
        "another --out",
        folder.string());
  }
}

void require_experiment_kept(const fs::path& folder, const fs::path& experiment) {
  std::error_code none;
  const fs::path within = fs::weakly_canonical(experiment, none).lexically_relative(fs::weakly_canonical(folder, none));
  if (within == run_files.front() || (!among(run_files, within) && !among(history_entries, within))) return;
  throw InputError("{}: results are written there, in the place of this experiment; rename it or choose another folder",
                   experiment.string());
}

void require_own_results(const fs::path& folder, const std::string& resolved) {
  require_no_links(folder);
  const std::optional<std::string> key = experiment_key_of_run(folder);
  std::error_code none;
  const fs::path experiment = folder / "experiment.toml";
  const bool printed = is_printed(experiment, resolved);
  const bool told = printed && (path_exists(folder / "manifest.json") || path_exists(folder / "timings.json"));
  std::vector<fs::path> foreign;
  if (!key && !told) {
    const auto add = [&](const fs::path& path, const fs::file_status& status) {
      const bool in_place = path.parent_path() != folder || among(run_files, path.filename());
      const auto end = path.extension();
      const bool of_shards = printed && (path == experiment || end == ".h5" || end == ".notes");
      if (in_place && !of_shards && fs::is_regular_file(status) && fs::file_size(path, none) > 0)
        foreign.push_back(path);
    };
    for (const char* name : run_files) walk(folder / name, add);
    for (const char* name : {"ensembles", "piles", "figures"}) walk(folder / name, add);
  } else if (fs::is_regular_file(experiment, none) && !printed && key != cache_key(read_file(experiment))) {
    foreign.push_back(experiment);
  }
  if (foreign.empty()) return;
  throw InputError(
      "{}: no run of granuscope left {} there, and the results would take {} place; name another folder, or move {} "
      "away (`granuscope run` has --force)",
      list_of(foreign), foreign.size() == 1 ? "this file" : "these files", foreign.size() == 1 ? "its" : "their",
      foreign.size() == 1 ? "it" : "them");
}

bool remove_own_files(const fs::path& folder, const std::function<bool(std::string_view)>& ours) {
  std::error_code ignored;
  if (!fs::is_directory(fs::symlink_status(folder, ignored))) return !fs::exists(folder, ignored);
  for (const fs::path& entry : entries_of(folder)) {
    if (fs::is_regular_file(fs::symlink_status(entry, ignored)) && ours(entry.filename().string())) {
      fs::remove(entry, ignored);
    }
  }
  remove_leftovers(folder);
  return fs::remove(folder, ignored);  // an empty folder only
}

void remove_run(const fs::path& folder) {
  std::vector<fs::path> all, foreign;
  std::set<std::string> figures;
  for (const fs::path file : earlier_figure_files(folder)) {
    for (const char* of : {"", "last-", "earlier-"})
      figures.insert(file.parent_path() / (of + file.filename().string()));
  }
  walk(folder, [&](const fs::path& path, const fs::file_status& status) {
    all.push_back(path);
    const fs::path within = path.lexically_relative(folder);
    const bool scratch =
        within.begin()->string().starts_with(".granuscope-") || path.filename().string().starts_with(".granuscope-");
    const bool in_place = among(run_folders, *within.begin());
    if (path == folder || scratch) return;
    const bool ours = fs::is_directory(status)
                          ? in_place
                          : fs::is_regular_file(status) &&
                                (among(run_files, within) || figures.contains(within.string()) || is_drawn_by_us(path));
    if (!ours) foreign.push_back(path);
  });
  if (!foreign.empty()) {
    throw InputError(
        "{}: no run of granuscope leaves this in '{}', which is to be removed, so that nothing was; move it away and "
        "start again",
        list_of(foreign), folder.string());
  }
  std::ranges::reverse(all);  // what is in a folder before the folder
  for (const fs::path& path : all) {
    std::error_code error;
    fs::remove(path, error);
    if (error) {
      throw EnvironmentError("cannot remove '{}': {}; tonight's results would be mixed with it. Remove it by hand",
                             path.string(), error.message());
    }
  }
}

}  // namespace granuscope
