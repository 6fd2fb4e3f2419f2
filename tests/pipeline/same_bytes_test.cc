#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/files.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// What was timed may stand in these only.
const std::set<std::string> may_differ = {"manifest.json", "timings.json"};

/// The page with all but its section of timings.
std::string without_timings(const std::string& page) {
  const std::string start = "<section aria-labelledby=\"timings\">", end = "</section>";
  const std::size_t from = page.find(start);
  REQUIRE(from != std::string::npos);
  return page.substr(0, from) + page.substr(page.find(end, from));
}

std::map<std::string, std::string> stable_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || may_differ.contains(name)) continue;
    const std::string bytes = read_file(entry.path());
    files[name] = name == "report.html" ? without_timings(bytes) : bytes;
  }
  return files;
}

/// examples/quick.toml with small piles and few of them: its figures and studies are those of the example, but for
/// those that count work, and how the fields couple beside them.
Experiment reduced_quick() {
  // Without the verdicts expected: some are of claims that it does not make here.
  const TemporaryFolder folder;
  const std::string quick = read_file(fs::path(GRANUSCOPE_SOURCE_DIR) / "examples/quick.toml");
  write_file(folder / "reduced.toml", std::string_view(quick).substr(0, quick.find("[gate.expect]")));
  return read_experiment(folder / "reduced.toml", {"lattice.columns=120",
                                                   "lattice.layers=70",
                                                   "friction.mu=[0.0, 0.2, 0.25, 0.3, 0.4]",
                                                   "response.samples=256",
                                                   "fit.first_layer=25",
                                                   "fit.last_layer=49",
                                                   "fit.shallow_layer=13",
                                                   "fit.scaling_window=[0.2, 0.4]",
                                                   "fit.other_scaling_windows=[[0.2, 0.3]]",
                                                   "figures.response_profiles.layers=[31, 49]",
                                                   "studies.error_against_time.repetitions=8",
                                                   "studies.error_against_time.columns=100",
                                                   "studies.error_against_time.layers=60",
                                                   "studies.deep_response.mu=[0.3]",
                                                   "studies.deep_response.octaves=3",
                                                   "studies.deep_response.first_lag=4",
                                                   "studies.deep_response.columns=48",
                                                   "studies.deep_response.samples=256",
                                                   "studies.mode_coupling.mu=[0.5]",
                                                   "studies.mode_coupling.octaves=3",
                                                   "studies.mode_coupling.columns=160",
                                                   "studies.mode_coupling.samples=256",
                                                   "studies.mode_coupling.loaded_samples=256",
                                                   "studies.mode_coupling.fluctuation_layers=[64, 256]",
                                                   "studies.mode_coupling.fluctuation_samples=256",
                                                   "studies.redrawn_beads.samples=256",
                                                   "studies.counted_work.mu=[]",
                                                   "studies.chain_share.samples=256",
                                                   "report.pdf=false"});
}

void check_same(const std::map<std::string, std::string>& first, const std::map<std::string, std::string>& other) {
  for (const auto& [name, bytes] : first) {
    INFO(name);
    REQUIRE(other.contains(name));
    CHECK((other.at(name) == bytes));  // a difference is named by its file, not printed
  }
  CHECK(other.size() == first.size());
}

}  // namespace

TEST_CASE("every file of two runs apart is the same bytes for 1, 2, 3 and 7 threads", "[long]") {
  std::map<std::string, std::string> first;
  for (const int threads : {1, 2, 3, 7}) {
    const TemporaryFolder folder;
    const Experiment experiment = reduced_quick();
    RunOptions options = quiet(folder.path());
    options.threads = threads;
    run_experiment(experiment, options);
    const std::map<std::string, std::string> files = stable_files(folder.path());
    CHECK(files.contains("figures/error-against-time.svg"));
    if (threads == 3) {  // what is reused is told among the timings, too
      run_experiment(experiment, options);
      check_same(files, stable_files(folder.path()));
    }
    if (first.empty()) first = files;
    check_same(first, files);
  }
}
