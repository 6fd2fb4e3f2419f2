#include "report/finished_run.h"

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>

#include "support/atomic_file.h"
#include "support/digest.h"

namespace granuscope {

std::optional<FinishedRun> find_finished_run(const std::filesystem::path& run_folder, const std::string& made_from,
                                             const std::set<std::string>& stages) {
  try {
    const auto manifest = nlohmann::ordered_json::parse(read_file(run_folder / "manifest.json"));
    if (manifest.at("status") != "done") return {};
    const FinishedRun run{manifest.at("made_from"), manifest.at("stages"), manifest.at("unexpected"),
                          manifest.at("pdf")};
    if (run.made_from != made_from) return {};
    if (!std::includes(run.stages.begin(), run.stages.end(), stages.begin(), stages.end())) return {};
    for (const auto& file : manifest.at("files")) {
      const std::filesystem::path path = run_folder / file.at("path").get<std::string>();
      if (std::filesystem::file_size(path) != file.at("bytes")) return {};
      if (sha256_of_file(path) != file.at("sha256")) return {};
    }
    return run;
  } catch (const std::exception&) {
    return {};  // missing, of an older program, or damaged: then it is made again
  }
}

}  // namespace granuscope
