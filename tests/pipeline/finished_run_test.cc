// A run whose results are all there does nothing.
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "experiment/experiment_file.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/quiet_run.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

Experiment experiment() {
  Experiment small = parse_experiment(smallest_experiment_text, "small.toml");
  small.report.pdf = false;
  return small;
}

std::map<std::string, fs::file_time_type> times_in(const fs::path& folder) {
  std::map<std::string, fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) times[entry.path().string()] = fs::last_write_time(entry.path());
  }
  return times;
}

}  // namespace

TEST_CASE("An unchanged experiment run again does nothing") {
  const TemporaryFolder folder;
  Experiment small = experiment();
  small.expected_verdicts["frictionless"] = "not reproduced";
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto begin = now();
  const RunResult first = run_experiment(small, quiet(folder.path()));
  const auto of_first = now() - begin;
  REQUIRE(first.unexpected.size() == 1);
  const auto before = times_in(folder.path());
  const auto start = now();
  const RunResult again = run_experiment(small, quiet(folder.path()));
  CHECK(now() - start < of_first / 2);
  CHECK(times_in(folder.path()) == before);
  CHECK(again.unexpected == first.unexpected);
  CHECK(again.files.html == first.files.html);
  CHECK(again.failure.empty());
  // What is part of it is there, too.
  run_experiment(small, quiet(folder.path(), {Stage::analyse}));
  CHECK(times_in(folder.path()) == before);
}

TEST_CASE("What is missing, damaged or asked for otherwise is made again") {
  const TemporaryFolder folder;
  Experiment small = experiment();
  run_experiment(small, quiet(folder.path(), {Stage::analyse}));
  CHECK_FALSE(fs::exists(folder / "summary.json"));
  run_experiment(small, quiet(folder.path()));  // more stages than are there
  const std::string summary = read_file(folder / "summary.json"), figure = "figures/response-profiles.svg";
  const std::string plot = read_file(folder / figure);

  fs::remove(folder / figure);
  run_experiment(small, quiet(folder.path()));
  CHECK((read_file(folder / figure) == plot));
  std::string damaged = plot;
  damaged[damaged.size() / 2] ^= 1;
  write_file(folder / figure, damaged);
  run_experiment(small, quiet(folder.path()));
  CHECK((read_file(folder / figure) == plot));

  small.fit.layer_step = 3;
  run_experiment(small, quiet(folder.path()));
  CHECK(read_file(folder / "summary.json") != summary);
  small.fit.layer_step = 2;
  run_experiment(small, quiet(folder.path()));
  CHECK((read_file(folder / "summary.json") == summary));
}

TEST_CASE("Figures of an earlier experiment leave the folder, and nothing else does") {
  const TemporaryFolder folder;
  Experiment small = experiment();
  run_experiment(small, quiet(folder.path()));
  REQUIRE(fs::exists(folder / "figures/response-profiles.svg"));
  REQUIRE(fs::exists(folder / "figures/force-chains.png"));
  write_file(folder / "figures/notes.txt", "somebody's own");
  const std::string chains = read_file(folder / "figures/force-chains.png");
  small.figures.response_profiles = false;
  run_experiment(small, quiet(folder.path(), {Stage::sample}));  // has no figures of its own
  CHECK(fs::exists(folder / "figures/response-profiles.svg"));
  run_experiment(small, quiet(folder.path()));
  for (const auto& entry : fs::directory_iterator(folder / "figures")) {
    CHECK(entry.path().filename().string().find("response-profiles") == std::string::npos);
  }
  CHECK(fs::exists(folder / "figures/notes.txt"));
  CHECK((read_file(folder / "figures/force-chains.png") == chains));
  CHECK(fs::exists(folder / "ensembles/mu-0.3.h5"));
}

TEST_CASE("What is all there is planned as nothing") {
  const TemporaryFolder folder;
  const Experiment small = experiment();
  CHECK_FALSE(is_all_there(small, quiet(folder.path())));
  run_experiment(small, quiet(folder.path(), {Stage::analyse}));
  CHECK_FALSE(is_all_there(small, quiet(folder.path())));
  CHECK(is_all_there(small, quiet(folder.path(), {Stage::sample})));
  fs::remove(folder / "ensembles/mu-0.3.h5");
  CHECK_FALSE(is_all_there(small, quiet(folder.path(), {Stage::sample})));
}

TEST_CASE("An interrupted ensemble keeps what was drawn, however long ago the last part was") {
  const TemporaryFolder folder;
  Experiment large = experiment();
  large.response.samples = 32 * group_size * 2000;
  const PartPolicy never_by_itself{1e9, 0};
  std::vector<PlannedEnsemble> planned = plan_ensembles(large, folder.path());
  std::thread stopper([] {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    request_interruption(true);
  });
  CHECK_THROWS_AS(obtain_ensemble(planned[1], folder.path(), 2, ProgressStyle::silent, never_by_itself), Interrupted);
  stopper.join();
  request_interruption(false);
  CHECK(fs::exists(folder.path() / part_file(planned[1])));
  CHECK(plan_ensembles(large, folder.path())[1].begun > 0);
}

TEST_CASE("A manifest that was edited is not gone by") {
  const TemporaryFolder folder;
  Experiment small = experiment();
  small.expected_verdicts["frictionless"] = "not reproduced";
  run_experiment(small, quiet(folder.path(), {Stage::analyse}));
  auto manifest = nlohmann::ordered_json::parse(read_file(folder / "manifest.json"));
  REQUIRE(manifest["unexpected"].size() == 1);
  manifest["unexpected"] = nlohmann::ordered_json::array();
  write_file(folder / "manifest.json", manifest.dump(2));
  CHECK(run_experiment(small, quiet(folder.path(), {Stage::analyse})).unexpected.size() == 1);
}
