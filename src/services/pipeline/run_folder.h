#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "support/files.h"

namespace granuscope {

/// Whether a process has a folder for itself, or shares it with others that share it: the shards of a run. Or only
/// reads what must not change meanwhile.
enum class FolderUse { alone, shared, read };

/// The folder of a run, for this run alone, or for its shards, as long as this object lives.
class RunFolder {
 public:
  /// Makes the folder if it is missing and removes what killed runs left half done (unless others may be at work).
  /// Throws EnvironmentError if it cannot be made, BusyError if another run is working in it: both would write the same
  /// files. Throws InputError, which names them all, if it holds links where a run or a history reads, writes and
  /// removes: a folder that comes from elsewhere could lead anywhere by them.
  explicit RunFolder(std::filesystem::path folder, FolderUse use = FolderUse::alone);

  const std::filesystem::path& path() const { return path_; }
  int leftovers_removed() const { return leftovers_removed_; }

 private:
  std::filesystem::path path_;
  FileDescriptor lock_;
  int leftovers_removed_ = 0;
};

/// Refuses (InputError) the folder of a history, and those in it, whose files have the names of a run's.
void require_no_history(const std::filesystem::path& folder);

/// Refuses (InputError) an experiment that has the place of a result, but for experiment.toml, which may be the same.
void require_experiment_kept(const std::filesystem::path& folder, const std::filesystem::path& experiment);

/// Refuses (InputError, which names them all) a folder in which a run would replace files that no run has written: an
/// experiment.toml with somebody's comments; a summary.md where no manifest.json and no experiment tell of a run.
/// `resolved` is the experiment to be run, as it is printed. Writes nothing.
void require_own_results(const std::filesystem::path& folder, const std::string& resolved);

/// Removes from a folder the files whose names `ours` accepts, and the folder once it is empty. What else is there
/// stays. Follows no link. Whether the folder is gone.
bool remove_own_files(const std::filesystem::path& folder, const std::function<bool(std::string_view)>& ours);

/// Removes the folder of a run with all that runs leave in it. Throws InputError, and removes nothing, if it holds
/// anything else; EnvironmentError, if something cannot be removed.
void remove_run(const std::filesystem::path& folder);

}  // namespace granuscope
