#include "report/finished_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>

#include "support/atomic_file.h"
#include "support/digest.h"
#include "support/error.h"

namespace granuscope {

std::optional<FinishedRun> find_finished_run(const std::filesystem::path& run_folder, const std::string& made_from,
                                             const std::set<std::string>& stages) {
  try {
    const auto manifest = nlohmann::ordered_json::parse(read_file(run_folder / "manifest.json"));
    if (manifest.at("status").get<std::string>() != "done") return {};
    const FinishedRun run{manifest.at("made_from"), manifest.at("stages"), manifest.at("unexpected"),
                          manifest.at("pdf")};
    if (run.made_from != made_from) return {};
    if (!std::includes(run.stages.begin(), run.stages.end(), stages.begin(), stages.end())) return {};
    for (const auto& file : manifest.at("files")) {
      const std::string name = file.at("path");
      if (!lies_in(run_folder, name)) return {};
      const std::filesystem::path path = run_folder / name;
      if (std::filesystem::file_size(path) != file.at("bytes").get<std::uintmax_t>()) return {};
      if (sha256_of_file(path) != file.at("sha256").get<std::string>()) return {};
    }
    return run;
  } catch (const std::exception&) {
    return {};  // missing, of an older program, or damaged: then it is made again
  }
}

bool lies_in(const std::filesystem::path& run_folder, const std::filesystem::path& path) {
  if (path.empty() || path.is_absolute() || path != path.lexically_normal() || *path.begin() == "..") return false;
  std::filesystem::path at = run_folder;
  return std::none_of(path.begin(), path.end(), [&](const std::filesystem::path& step) {
    std::error_code none;
    return std::filesystem::is_symlink(at /= step, none);
  });
}

void require_results_of_last_run(const std::filesystem::path& run_folder, const std::string& stage) {
  std::error_code none;
  if (!std::filesystem::exists(run_folder / "manifest.json", none)) return;
  const auto manifest = nlohmann::ordered_json::parse(read_file(run_folder / "manifest.json"), nullptr, false);
  const auto stages = manifest.is_object() ? manifest.value("stages", nlohmann::ordered_json::array())
                                           : nlohmann::ordered_json::array();
  if (std::find(stages.begin(), stages.end(), stage) != stages.end()) return;
  throw InputError(fmt::format(
      "{0}: the last run in this folder did not come to its {1}, so that summary.json and the figures are of "
      "an earlier one and experiment.toml of another; go on with it: granuscope run {0}/experiment.toml "
      "--out {0}",
      run_folder.string(), stage));
}

}  // namespace granuscope
