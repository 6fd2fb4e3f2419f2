// What a folder says of a run that has not ended, or ended badly, and what such a run leaves as it was.
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/pipeline.h"
#include "quiet_run.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Seconds of each stage that draws an ensemble; -1 where they are not known.
std::map<std::string, double> drawing_times(const fs::path& folder) {
  std::map<std::string, double> times;
  const nlohmann::json manifest = manifest_of(folder);
  for (const auto& timing : manifest.at("timings")) {
    const auto stage = timing.at("stage").get<std::string>();
    if (stage.starts_with("sample ")) {
      times[stage] = timing.at("seconds").is_null() ? -1 : timing.at("seconds").get<double>();
    }
  }
  return times;
}

void damage_last_half(const fs::path& file) {
  std::string bytes = read_file(file);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  std::ofstream(file) << bytes;
}

Experiment growing_experiment() {
  Experiment experiment = small_experiment();
  experiment.response.estimator = EstimatorName::multiplexed;
  experiment.mu = {0.3};
  experiment.precision = {2e-2, 0, 4096};
  return experiment;
}

}  // namespace

TEST_CASE("what drawing took is not forgotten by runs that draw nothing or end badly") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  const auto drawn = drawing_times(folder.path());
  REQUIRE(drawn.size() == 4);
  for (const auto& [stage, seconds] : drawn) CHECK(seconds > 0);

  run_experiment(experiment, quiet(folder.path(), {Stage::render}));
  CHECK(drawing_times(folder.path()) == drawn);

  request_interruption(true);
  CHECK_THROWS_AS(run_experiment(experiment, quiet(folder.path(), {Stage::sample})), Interrupted);
  request_interruption(false);
  CHECK(manifest_of(folder.path())["status"] == "interrupted");
  CHECK(drawing_times(folder.path()) == drawn);

  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  CHECK(manifest_of(folder.path())["status"] == "done");
  CHECK(manifest_of(folder.path())["exit_code"] == 0);
  CHECK(drawing_times(folder.path()) == drawn);

  // A stage that the experiment no longer has is none of its run.
  Experiment smaller = experiment;
  smaller.mu = {0.0, 0.3};
  run_experiment(smaller, quiet(folder.path(), {Stage::sample}));
  CHECK(drawing_times(folder.path()).size() == 2);
}

TEST_CASE("an ensemble that could not be kept is missed before it is drawn") {
  Experiment experiment = small_experiment();
  experiment.mu = {0.3};
  experiment.response.samples = 100'000'000;  // days
  const TemporaryFolder folder;
  const fs::path ensembles = folder / "ensembles";
  std::ofstream(ensembles) << "a file";
  CHECK_THROWS_WITH(run_experiment(experiment, quiet(folder.path(), {Stage::sample})),
                    Contains("ensembles") && Contains("is a file where a folder is needed"));
  fs::remove(ensembles);
  fs::create_symlink(folder / "none/there", ensembles);
  CHECK_THROWS_WITH(run_experiment(experiment, quiet(folder.path(), {Stage::sample})), Contains("is a link"));
  fs::remove(ensembles);
  fs::create_directories(ensembles / "mu-0.3.h5/in the way");
  CHECK_THROWS_WITH(run_experiment(experiment, quiet(folder.path(), {Stage::sample})),
                    Contains("mu-0.3.h5") && Contains("A folder stands"));
  CHECK(manifest_of(folder.path())["status"] == "failed");
}

TEST_CASE("planning a growing ensemble draws nothing, even where what is there is damaged") {
  const TemporaryFolder folder;
  const Experiment experiment = growing_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  const fs::path file = folder / "ensembles/mu-0.3.h5";
  damage_last_half(file);
  const std::string before = read_file(file);
  const std::vector<PlannedStep> plan = plan_run(experiment, quiet(folder.path(), {Stage::sample}));
  CHECK(read_file(file) == before);
  REQUIRE(plan.size() == 1);
  CHECK_FALSE(plan.front().reused);
  CHECK(plan.front().beads > 0);
  CHECK_THAT(plan.front().what,
             Contains("by a rule of thumb") && Contains("replaces the file there") && Contains("the file is damaged"));
}

TEST_CASE("a pile that cannot be completed costs its pictures, not the report") {
  const TemporaryFolder folder;
  Experiment experiment = without_pdf(small_experiment());
  experiment.sampling.effort = 1;  // solves every bead once, so that the first failure ends a pile
  experiment.mu = {0.0, 0.3};
  experiment.fit.scaling_window = {0.2, 0.4};
  run_experiment(experiment, quiet(folder.path()));
  CHECK_THAT(read_file(folder / "report.html"), Contains("the pile of the force-chain picture could not be completed"));
  CHECK(fs::exists(folder / "summary.json"));
  CHECK_FALSE(fs::exists(folder / "figures/force-chains.png"));
}

TEST_CASE("an ensemble that cannot be opened is not taken for a damaged one") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  const fs::path file = folder / "ensembles/mu-0.3.h5";
  const std::string before = read_file(file);
  const auto refused = [&](const std::string& reason) {
    CHECK_THROWS_WITH(run_experiment(experiment, quiet(folder.path(), {Stage::sample})),
                      Contains("cannot open") && Contains("may hold finished work") && Contains(reason));
    CHECK_THROWS_WITH(plan_run(experiment, quiet(folder.path(), {Stage::sample})), Contains(reason));
  };
  if (::geteuid() != 0) {  // root may open everything
    fs::permissions(file, fs::perms::none);
    refused("Permission denied");
    fs::permissions(file, fs::perms::owner_all);
    CHECK(read_file(file) == before);
  }
  fs::rename(file, folder / "kept.h5");
  fs::create_symlink(file.filename(), file);  // leads to itself
  CHECK_THROWS_WITH(run_experiment(experiment, quiet(folder.path(), {Stage::sample})), Contains("is a link"));
  CHECK_THROWS_WITH(plan_run(experiment, quiet(folder.path(), {Stage::sample})),
                    Contains("cannot open") && Contains("Too many levels of symbolic links"));
  CHECK(fs::is_symlink(file));
}

TEST_CASE("the manifest lists every file that a run leaves") {
  const TemporaryFolder folder;
  run_experiment(small_experiment(), quiet(folder.path()));
  std::set<std::string> left, listed;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.is_regular_file()) left.insert(fs::relative(entry.path(), folder.path()).string());
  }
  const nlohmann::json manifest = manifest_of(folder.path());
  for (const auto& file : manifest.at("files")) listed.insert(file.at("path").get<std::string>());
  listed.insert("manifest.json");
  CHECK(listed == left);
}

TEST_CASE("a pipe in the place of the manifest is waited for by nobody") {
  const TemporaryFolder folder;
  REQUIRE(::mkfifo((folder / "manifest.json").c_str(), 0600) == 0);
  CHECK_THROWS_WITH(run_experiment(small_experiment(), quiet(folder.path(), {Stage::sample})),
                    Contains("manifest.json") && Contains("not an ordinary file"));
}
