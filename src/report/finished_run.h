#pragma once
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace granuscope {

/// What a later run need not make again, kept in manifest.json.
struct FinishedRun {
  std::string made_from;                ///< one word for all that the results depend on
  std::set<std::string> stages;         ///< by name, that were done
  std::vector<std::string> unexpected;  ///< sentences: verdicts that are not the expected ones
  bool pdf = false;                     ///< report.pdf is its own, not one that an earlier run left
};

/// The finished run in this folder, if it is made from this and came to these stages, and every file that its manifest
/// lists is there with the bytes that it had. Files are read only if all else fits.
std::optional<FinishedRun> find_finished_run(const std::filesystem::path& run_folder, const std::string& made_from,
                                             const std::set<std::string>& stages);

/// Whether a path that a manifest names lies in the folder of its run: relative, without "..", and no link leads out.
bool lies_in(const std::filesystem::path& run_folder, const std::filesystem::path& path);

/// The door for whoever reads what a run left: throws InputError if the folder has a manifest whose last run did not
/// come to this stage, so that what is there is of an earlier one. A folder without a manifest is let through.
void require_results_of_last_run(const std::filesystem::path& run_folder, const std::string& stage);

}  // namespace granuscope
