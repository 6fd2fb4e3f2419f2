// A figure that cannot be made costs nothing but itself.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/pipeline.h"
#include "quiet_run.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Script of a gnuplot that complains about scripts of this name, and else plots as always.
std::string fussy_gnuplot(const std::string& script) {
  const auto real = find_program("gnuplot");
  REQUIRE(real);
  return "case \"$2\" in " + script + ") echo '\"a.gp\" line 1: a warning' >&2;; esac\nexec " + real->string() +
         " \"$@\"";
}

Experiment experiment_with_few_figures() {
  Experiment experiment = small_experiment();
  experiment.mu = {0.0, 0.3};
  experiment.figures.propagation_against_diffusion = false;
  experiment.figures.scaling_with_friction = false;
  experiment.force_chains.show = false;
  experiment.report.pdf = false;
  return experiment;
}

std::string report_in(const fs::path& folder) { return read_file(folder / "report.html"); }

TEST_CASE("a figure that gnuplot does not draw is named in its place, and all else is made") {
  const TemporaryFolder whole, lacking;
  const Experiment experiment = experiment_with_few_figures();
  CHECK(run_experiment(experiment, quiet(whole.path())).failure.empty());
  CHECK(report_in(whole.path()).find("Not made.") == std::string::npos);

  {
    const test::FakePrograms programs(lacking / "programs");
    programs.only("gnuplot", fussy_gnuplot("response-profiles*"));
    const RunResult result = run_experiment(experiment, quiet(lacking.path()));
    CHECK_THAT(result.failure, Contains("figure response-profiles could not be made") && Contains("a warning"));
  }
  for (const char* file : {"summary.json", "summary.md", "claims.xml", "figures/transport-with-depth.svg"}) {
    INFO(file);
    CHECK(read_file(lacking / file) == read_file(whole / file));
  }
  CHECK_FALSE(fs::exists(lacking / "figures/response-profiles.svg"));
  const std::string report = report_in(lacking.path());
  const std::size_t title = report.rfind("\">Figure 2."), next = report.rfind("\">Figure 3."),
                    reason = report.find("a warning");
  REQUIRE(title != std::string::npos);
  CHECK(reason > title);
  CHECK(reason < next);
  CHECK(report.find("fonts-dejavu-core are as expected. Files of its name", reason) < next);
  CHECK(report.find("src=\"\"") == std::string::npos);  // no picture without contents
  const auto manifest = nlohmann::json::parse(read_file(lacking / "manifest.json"));
  CHECK(manifest["status"] == "failed");
  CHECK(manifest["exit_code"] == 3);
  CHECK_THAT(manifest["error"].get<std::string>(), Contains("response-profiles"));
  CHECK(manifest["files"].size() > 5);

  // The next run, with a gnuplot that works, has nothing left to sample and makes it whole.
  CHECK(run_experiment(experiment, quiet(lacking.path())).failure.empty());
  CHECK(read_file(lacking / "figures/response-profiles.svg") == read_file(whole / "figures/response-profiles.svg"));
  CHECK(nlohmann::json::parse(read_file(lacking / "manifest.json"))["status"] == "done");
}

TEST_CASE("a drawing of an earlier run stands for one that fails only if script and data are the same") {
  const TemporaryFolder folder;
  Experiment experiment = experiment_with_few_figures();
  run_experiment(experiment, quiet(folder.path()));
  const test::FakePrograms programs(folder / "programs");
  programs.only("gnuplot", fussy_gnuplot("*"));
  CHECK_THAT(run_experiment(experiment, quiet(folder.path())).failure, Contains("could not be made"));
  const std::string same = report_in(folder.path());
  CHECK(same.find("made from the same script and data by an earlier run") != std::string::npos);
  CHECK(same.find("data:image/svg+xml") != std::string::npos);

  experiment.sampling.seed = 12;
  CHECK_THAT(run_experiment(experiment, quiet(folder.path())).failure, Contains("could not be made"));
  CHECK(report_in(folder.path()).find("data:image/svg+xml") == std::string::npos);
}

}  // namespace
