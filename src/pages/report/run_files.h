#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "report/report_data.h"

namespace granuscope {
inline constexpr std::array report_names = {"summary.json", "summary.md", "claims.xml", "report.html", "report.pdf"};
inline constexpr std::array pile_files = {"piles/force-chains.h5", "piles/overloaded.h5", "piles/uniform.h5"};

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
/// come to this stage, so that what is there is of an earlier one; BusyError while that run is at work. A folder
/// without a manifest is let through.
void require_results_of_last_run(const std::filesystem::path& run_folder, const std::string& stage);

/// The command that makes what is in this folder again, or goes on with it.
std::string run_again(const std::filesystem::path& run_folder);

/// The first file of a run whose path begins so and ends so, and that is not what its manifest lists or lies elsewhere;
/// "manifest.json" if that was changed; "" if there is none. Scripts are meant to be edited, and are passed over.
/// `whole`: they are not, and no file may be missing.
std::string changed_since_run(const std::filesystem::path& run_folder, const std::string& begins = "",
                              const std::string& ends = "", bool whole = false);
/// Throws InputError if there is one.
void require_unchanged(const std::filesystem::path& run_folder, const std::string& begins,
                       const std::string& ends = "");

/// Renames reports and figures that are not what the last run left there, by its manifest, to NAME.kept, so that the
/// next one replaces nobody's work; `dry`: leaves them. Their names. None where that run was killed.
std::vector<std::filesystem::path> keep_changed(const std::filesystem::path& run_folder, bool dry = false);

/// A figure as the report numbers it, from 1 on.
struct ListedFigure {
  std::string id, title;  ///< the latter empty where no report tells it
  bool plotted = true;    ///< otherwise a picture of beads
};

/// The figures of a run's report in its order, then the plots in its folder that are not in it. Throws InputError if
/// there is no folder of figures.
std::vector<ListedFigure> list_figures(const std::filesystem::path& run_folder);

/// What its manifest says that it left out: sentences, with a blank before each.
std::string left_out_by_run(const std::filesystem::path& run_folder);

/// How a run ended.
struct RunOutcome {
  std::string status = "done";       ///< "done", "failed", "interrupted", or "unfinished": at work, or killed since
  std::optional<int> exit_code = 0;  ///< of an unfinished run none
  std::string error;                 ///< the message, empty if all went well
  FinishedRun finished = {};         ///< for later runs
  std::map<std::string, StageTiming> earlier_timings = {};  ///< of stages that this run has not come to
  std::set<std::string> figure_files = {};                  ///< of figures in the folder, of this run or an earlier one
};

/// Provenance, environment, timings, what was skipped, how the run ended, and the SHA-256 and size of every file of a
/// run in `run_folder` except manifest.json itself and hidden (temporary) files; what others keep there is not looked
/// at. Everything that differs between machines or moments is here. A file that cannot be read is listed with a null
/// hash, so that a failing run still gets a manifest. The files of an unfinished run change, and none is listed.
std::string manifest_json(const ReportData& data, const std::filesystem::path& run_folder, const RunOutcome& outcome);

/// What each stage took as the manifest of an earlier run in this folder gives them, so that what is reused keeps the
/// time it took. Empty where there is no such manifest or it is damaged.
std::map<std::string, StageTiming> earlier_timings(const std::filesystem::path& run_folder);

/// The key of the experiment of which manifest.json tells (cache_key of experiment.toml); nothing if no run of this
/// program has left a manifest there.
std::optional<std::string> experiment_key_of_run(const std::filesystem::path& run_folder);

/// The files of piles, and of figures that runs have left in this folder, as its manifest lists them.
std::set<std::string> earlier_figure_files(const std::filesystem::path& run_folder);

/// The wall times of the stages: timings.json.
std::string timings_json(const ReportData& data, const RunOutcome& outcome);

/// manifest_json into manifest.json, and before it, once the run has ended, timings_json into timings.json, each
/// atomically. Call it before anything else is written, and last.
void write_manifest(const ReportData& data, const std::filesystem::path& run_folder, const RunOutcome& outcome);

}  // namespace granuscope
