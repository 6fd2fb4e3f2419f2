#include "pipeline/pipeline.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "kit/search_path.h"
#include "kit/set_key.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/ensemble_stage.h"
#include "quiet_run.h"
#include "storage/ensemble_file.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), folder).string());
  }
  return names;
}

/// The small experiment by that estimator, without PDF.
Experiment estimated_by(const std::string& estimator) {
  Experiment experiment = without_pdf(small_experiment());
  experiment.response.estimator = estimator_named(estimator);
  experiment.response.epsilon = 0.125;
  if (estimator == "fluctuation") experiment.lattice.layers = 200;
  return experiment;
}

}  // namespace

TEST_CASE("a run leaves everything it promises, and a second one repeats no sampling and changes no byte") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  const RunResult result = run_experiment(experiment, quiet(folder.path()));
  const std::set<std::string> files = names_in(folder.path());
  for (const char* name :
       {"experiment.toml", "manifest.json", "summary.json", "claims.xml", "summary.md", "report.html", "report.pdf",
        "ensembles/mu-0.h5", "ensembles/mu-0.2.h5", "ensembles/mu-0.3.h5", "ensembles/mu-0.4.h5",
        "piles/force-chains.h5", "figures/force-chains.png", "figures/response-profiles.svg",
        "figures/response-profiles.pdf", "figures/response-profiles.gp", "figures/transport-with-depth.svg",
        "figures/propagation-against-diffusion.pdf"}) {
    INFO(name);
    CHECK(files.contains(name));
  }
  for (const std::string& name : files) CHECK(name.find(".granuscope") == std::string::npos);
  CHECK(result.analysis.results.size() == 4);
  CHECK(manifest_of(folder.path())["status"] == "done");
  // The resolved experiment reads back and would give the same run.
  CHECK(print_experiment(parse_experiment(read_file(folder.path() / "experiment.toml"), "experiment.toml")) ==
        print_experiment(experiment));

  const std::string summary = read_file(folder.path() / "summary.json");
  const std::string picture = read_file(folder.path() / "figures/force-chains.png");
  const auto drawn_at = fs::last_write_time(folder.path() / "ensembles/mu-0.3.h5");
  for (const PlannedStep& step : plan_run(experiment, quiet(folder.path()))) {
    if (step.stage == Stage::sample) CHECK(step.reused);
  }
  run_experiment(experiment, quiet(folder.path()));
  CHECK(fs::last_write_time(folder.path() / "ensembles/mu-0.3.h5") == drawn_at);
  CHECK(read_file(folder.path() / "summary.json") == summary);
  CHECK(read_file(folder.path() / "figures/force-chains.png") == picture);
}

TEST_CASE("the summary is the same bytes for every number of threads, by every estimator", "[unsanitized]") {
  for (const std::string estimator : {"point", "paired", "multiplexed", "fluctuation"}) {
    std::string first;
    for (const int threads : {1, 2, 5}) {
      CAPTURE(estimator, threads);
      const TemporaryFolder folder;
      RunOptions options = quiet(folder.path(), {Stage::report});
      options.threads = threads;
      run_experiment(estimated_by(estimator), options);
      const std::string summary = read_file(folder.path() / "summary.json");
      if (first.empty()) first = summary;
      CHECK(summary == first);
      // Nothing of the moment, the machine or the folder.
      CHECK(summary.find(folder.path().string()) == std::string::npos);
      CHECK(summary.find("seconds") == std::string::npos);
    }
  }
}

TEST_CASE("only what is asked for is made") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::render}));
  std::set<std::string> files = names_in(folder.path());
  CHECK(files == std::set<std::string>{"experiment.toml", "manifest.json", "timings.json", "piles/force-chains.h5",
                                       "piles/overloaded.h5", "piles/uniform.h5", "figures/bead-weights.png",
                                       "figures/force-chains.png", "figures/pile-response.png"});
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  files = names_in(folder.path());
  CHECK(files.contains("ensembles/mu-0.4.h5"));
  CHECK_FALSE(files.contains("summary.json"));
  // No GL context is made for sampling, and the manifest says so.
  CHECK(read_file(folder.path() / "manifest.json").find("no GL context was made") != std::string::npos);
}

TEST_CASE("a damaged or different ensemble is drawn again, and only that one") {
  const TemporaryFolder folder;
  Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  const fs::path damaged = folder.path() / "ensembles/mu-0.3.h5";
  const std::string whole = read_file(damaged);
  write_file(damaged, std::string_view(whole).substr(0, whole.size() / 2));
  const auto plan = plan_run(experiment, quiet(folder.path(), {Stage::sample}));
  REQUIRE(plan.size() == 4);
  CHECK(plan[0].reused);
  CHECK(plan[1].reused);
  CHECK_FALSE(plan[2].reused);
  CHECK(plan[3].reused);
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  CHECK(read_file(damaged) == whole);
  experiment.sampling.seed = 12;
  for (const PlannedStep& step : plan_run(experiment, quiet(folder.path(), {Stage::sample}))) {
    CHECK_FALSE(step.reused);
  }
}

TEST_CASE("an ensemble damaged behind its configuration is drawn again, too") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  const fs::path file = folder.path() / "ensembles/mu-0.3.h5";
  const std::string whole = read_file(file);
  const std::string configuration = read_ensemble_configuration(file);
  // The first byte whose change spoils the sums but not the configuration.
  const auto spoils_sums_only = [&] {
    try {
      if (read_ensemble_configuration(file) != configuration) return false;
    } catch (const InputError&) {
      return false;
    }
    try {
      read_ensemble(file);
    } catch (const InputError&) {
      return true;
    }
    return false;
  };
  std::size_t at = 0;
  do {
    REQUIRE(at < whole.size());
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    at += 16;
    write_file(file, damaged);
  } while (!spoils_sums_only());

  CHECK(plan_run(experiment, quiet(folder.path(), {Stage::sample}))[2].reused);  // plans read no further
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  CHECK(read_file(file) == whole);
  const std::string manifest = read_file(folder.path() / "manifest.json");
  CHECK(manifest.find("3 of 4 ensembles were already there") != std::string::npos);
}

TEST_CASE("an interrupted run says so, keeps what was finished and goes on to the same bytes") {
  const TemporaryFolder whole, stopped;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(whole.path(), {Stage::sample}));

  // As if the run had been stopped after two ensembles: they are whole, the rest is missing.
  run_experiment(experiment, quiet(stopped.path(), {Stage::sample}));
  fs::remove(stopped.path() / "ensembles/mu-0.3.h5");
  fs::remove(stopped.path() / "ensembles/mu-0.4.h5");
  request_interruption(true);
  CHECK_THROWS_AS(run_experiment(experiment, quiet(stopped.path(), {Stage::sample})), Interrupted);
  request_interruption(false);
  CHECK(manifest_of(stopped.path())["status"] == "interrupted");
  CHECK(manifest_of(stopped.path())["exit_code"] == 4);
  CHECK(fs::exists(stopped.path() / "ensembles/mu-0.2.h5"));
  CHECK_FALSE(fs::exists(stopped.path() / "ensembles/mu-0.3.h5"));

  run_experiment(experiment, quiet(stopped.path(), {Stage::sample}));
  for (const char* name : {"ensembles/mu-0.2.h5", "ensembles/mu-0.3.h5", "ensembles/mu-0.4.h5"}) {
    CHECK(read_file(stopped.path() / name) == read_file(whole.path() / name));
  }
}

TEST_CASE("figures with nothing to show are left out, the reasons reported") {
  const TemporaryFolder folder;
  Experiment experiment = without_pdf(small_experiment());
  experiment.mu = {0.05};  // peaks narrower than a bead: no depth can be fitted
  experiment.figures.profile_mu = 0.05;
  run_experiment(experiment, quiet(folder.path(), {Stage::report}));
  const auto summary = nlohmann::json::parse(read_file(folder.path() / "summary.json"));
  CHECK(summary["results"][0]["c"]["value"].is_null());
  CHECK_FALSE(summary["results"][0]["c"]["reason"].get<std::string>().empty());
  CHECK(summary["results"][0]["c_thrust"]["value"].is_number());
  const std::string manifest = read_file(folder.path() / "manifest.json");
  CHECK(manifest.find("A figure is left out: the figure of c against D has nothing to show") != std::string::npos);
  CHECK(read_file(folder.path() / "report.html").find("A figure is left out") != std::string::npos);
}

TEST_CASE("a run that fails leaves a manifest that says why") {
  const TemporaryFolder folder;
  // Nothing is installed in an empty folder, least of all gnuplot.
  const TemporaryFolder empty;
  const test::SearchPath without_programs(empty.path());
  CHECK_THROWS_AS(run_experiment(small_experiment(), quiet(folder.path())), EnvironmentError);
  const auto manifest = manifest_of(folder.path());
  CHECK(manifest["status"] == "failed");
  CHECK(manifest["exit_code"] == 3);
  CHECK(manifest["error"].get<std::string>().find("gnuplot") != std::string::npos);
  // It was missed before anything was drawn.
  CHECK_FALSE(fs::exists(folder.path() / "ensembles"));
}

TEST_CASE("a folder that cannot be made is refused before any work") {
  const TemporaryFolder folder;
  fs::create_directories(folder.path());
  write_file(folder.path() / "file", "not a folder");
  CHECK_THROWS_AS(run_experiment(small_experiment(), quiet(folder.path() / "file" / "run")), EnvironmentError);
}

TEST_CASE("failures are listed in the summary and enter no average") {
  const TemporaryFolder folder;
  Experiment experiment = without_pdf(small_experiment());
  experiment.sampling.effort = 1.4;  // enough at mu = 0.2, not for every pile at 0.4
  run_experiment(experiment, quiet(folder.path(), {Stage::report}));
  const auto summary = nlohmann::json::parse(read_file(folder.path() / "summary.json"));
  std::size_t failed = 0;
  for (const auto& result : summary["results"]) {
    failed += result["failed"].size();
    CHECK(result["samples"].get<std::size_t>() + result["failed"].size() == 256);
    for (const auto& failure : result["failed"]) {
      CHECK(failure["replay"].get<std::string>().find("--effort 1.4") != std::string::npos);
    }
  }
  CHECK(failed > 0);
}

TEST_CASE("verdicts that differ from the expected ones are named") {
  const TemporaryFolder folder;
  Experiment experiment = small_experiment();
  experiment.expected_verdicts = {{"frictionless", "reproduced"}};
  CHECK(run_experiment(experiment, quiet(folder.path(), {Stage::analyse})).unexpected.empty());
  experiment.expected_verdicts = {{"frictionless", "not reproduced"}};
  const auto unexpected = run_experiment(experiment, quiet(folder.path(), {Stage::analyse})).unexpected;
  REQUIRE(unexpected.size() == 1);
  CHECK(unexpected[0].find("frictionless") != std::string::npos);
}

TEST_CASE("the pile of the picture is the one its command draws again") {
  const TemporaryFolder folder;
  run_experiment(small_experiment(), quiet(folder.path(), {Stage::render}));
  const Pile pile = read_pile(folder.path() / "piles/force-chains.h5");
  CHECK(pile.lattice.columns() == 40);
  CHECK(pile.lattice.layers() == 20 + bottom_margin);
  CHECK(pile.sample == 0);
  CHECK(pile.seed == 11);
  CHECK(pile.load[20] == 2.0);
}

TEST_CASE("The ensembles of studies are drawn, kept, reused and reported") {
  Experiment experiment = without_pdf(small_experiment());
  set_key(experiment, "studies.small_friction.mu", numbers({0.15, 0.2, 0.3}));
  set_key(experiment, "studies.small_friction.columns", std::int64_t{16});
  set_key(experiment, "studies.small_friction.depth", 2.0);
  set_key(experiment, "studies.small_friction.samples", std::int64_t{256});
  set_key(experiment, "studies.counted_work.mu", numbers({0.0, 0.8}));
  set_key(experiment, "studies.counted_work.sizes", whole_numbers({30, 45, 60}));
  set_key(experiment, "studies.chain_share.samples", std::int64_t{256});
  set_key(experiment, "studies.redrawn_beads.mu", numbers({0.3}));
  set_key(experiment, "studies.redrawn_beads.samples", std::int64_t{256});
  set_key(experiment, "studies.nonlinearity.mu", numbers({0.2, 0.3, 0.4}));
  set_key(experiment, "studies.nonlinearity.epsilons", numbers({0.25, 0.5}));
  set_key(experiment, "studies.nonlinearity.overloads", numbers({1, 2}));
  set_key(experiment, "studies.nonlinearity.multiplexed_samples", std::int64_t{300});
  set_key(experiment, "studies.nonlinearity.point_samples", std::int64_t{1024});
  experiment.force_chains.layers = 25;
  TemporaryFolder folder;
  const auto summary_of = [&](const std::vector<Stage>& only) {
    run_experiment(experiment, quiet(folder.path(), only));
    return nlohmann::json::parse(read_file(folder.path() / "summary.json"));
  };
  const auto first = summary_of({});
  const auto& studies = first.at("studies");
  CHECK(studies.at("small_friction").at("piles").size() == 3);
  CHECK(studies.at("small_friction").at("exponent").at("points") == 3);
  CHECK(studies.at("redrawn_beads")[0].at("whole_pile").at("value") > 0.0);
  CHECK(studies.at("redrawn_beads")[0].at("whole_pile").at("value") <
        studies.at("redrawn_beads")[0].at("below_overload").at("value"));
  CHECK(studies.at("counted_work").size() == 6);
  CHECK(studies.at("counted_work")[0].at("draws_per_bead") == 0.0);  // without friction nothing is drawn
  CHECK(studies.at("counted_work")[5].at("draws_per_bead") > 1.0);
  CHECK(studies.at("chain_share")[0].at("share").at("value") > 0.8);
  const auto& loads = studies.at("nonlinearity");
  REQUIRE(loads.at("responses").size() == 3 * 5);
  CHECK(loads.at("responses")[0].at("reference") == true);
  CHECK(loads.at("responses")[0].at("samples") == 512);  // the next whole round of 32 groups
  CHECK(loads.at("responses")[1].at("samples") == 256);
  CHECK(loads.at("responses")[2].at("samples") == 1024);
  CHECK(loads.at("responses")[3].at("samples") == 512);
  CHECK(loads.at("responses")[0].at("columns") == 64);  // enough for the response down to layer 49
  CHECK(loads.at("responses")[0].at("D_over_linear_minus_1").at("value") == 0.0);
  CHECK(loads.at("exponents").size() == 4);
  CHECK(read_file(folder.path() / "report.html").find("<table class=\"loads\"") != std::string::npos);
  for (const char* file : {"load-point-2-mu-0.3.h5", "load-uniform-mu-0.2.h5", "small-friction-mu-0.15.h5",
                           "counted-work-mu-0.8-60x60.h5", "chain-share.h5"}) {
    CHECK(fs::exists(folder.path() / "ensembles" / file));
  }
  for (const PlannedStep& step : plan_run(experiment, quiet(folder.path()))) {
    if (step.stage == Stage::sample) CHECK(step.reused);
  }
  const auto timings = [&] { return nlohmann::json::parse(read_file(folder.path() / "manifest.json")).at("timings"); };
  const auto drawn = timings();
  fs::remove(folder.path() / "summary.md");  // or else nothing would be done
  CHECK(summary_of({Stage::report}) == first);
  const auto reused = timings();
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    if (drawn[i].at("stage").get<std::string>().rfind("sample ", 0) != 0) continue;
    CHECK(reused[i].at("stage") == drawn[i].at("stage"));
    CHECK(reused[i].at("seconds") == drawn[i].at("seconds"));  // what drawing took is not forgotten
    CHECK(reused[i].at("reused") == true);
  }
  write_file(folder.path() / "manifest.json", "{ damaged");
  CHECK(summary_of({Stage::report}) == first);
  CHECK(timings()[0].at("seconds").is_null());
}

TEST_CASE("every estimator runs to a report that names it beside the numbers") {
  for (const std::string estimator : {"paired", "multiplexed", "fluctuation"}) {
    const TemporaryFolder folder;
    run_experiment(estimated_by(estimator), quiet(folder.path()));
    const std::string summary = read_file(folder.path() / "summary.json");
    const auto results = nlohmann::json::parse(summary).at("results");
    int known = 0;  // piles this shallow leave c open at some friction coefficients
    for (const auto& result : results) {
      CHECK(result.at("estimator") == estimator);
      CHECK(result.contains("epsilon") == (estimator == "multiplexed"));
      CHECK(result.contains("overload") == (estimator == "paired"));
      known += result.at("c").at("value").is_number() ? 1 : 0;
    }
    // What beads keep has been chosen; only without friction have both piles of a pair the same law.
    CHECK((estimator == "paired" ? known == 1 : known >= 2));
    const std::string report = read_file(folder.path() / "report.html");
    CHECK_THAT(report, Catch::Contains(estimator == "paired"        ? "standard procedure, <em>paired</em>"
                                       : estimator == "multiplexed" ? "<em>Multiplexed</em>"
                                                                    : "half the trace of"));
  }
}

TEST_CASE("A precision is reached by whole steps: the same bytes for every number of threads, resumed or not",
          "[unsanitized]") {
  Experiment experiment = without_pdf(small_experiment());
  experiment.response.estimator = EstimatorName::multiplexed;
  experiment.mu = {0.0, 0.3};
  experiment.precision = {2e-3, 0, 16384};
  experiment.fit.scaling_window = {0.2, 0.4};
  const auto run = [&](const TemporaryFolder& folder, int threads) {
    RunOptions options = quiet(folder.path(), {Stage::analyse});
    options.threads = threads;
    fs::remove(folder.path() / "manifest.json");  // or else a finished run would do nothing, and measure nothing
    return run_experiment(experiment, options).analysis.results;
  };
  const TemporaryFolder folder, again;
  const auto dry = [&] {
    std::string text;
    for (const PlannedStep& step : plan_run(experiment, quiet(folder.path()))) text += step.what + "\n";
    return text;
  };
  CHECK_THAT(dry(), Catch::Contains("by a rule of thumb"));
  const std::vector<Transport> first = run(folder, 2);
  REQUIRE(first.size() == 2);
  CHECK_FALSE(first[0].precision.asked);  // without friction nothing is random
  CHECK(first[1].precision.asked);
  CHECK(first[1].precision.reached);
  CHECK(first[1].c.standard_error <= 2e-3);
  CHECK_THAT(dry(), Catch::Contains("by the errors so far"));
  const std::string loose = read_file(folder.path() / "ensembles/mu-0.3.h5");

  // More is asked for: the ensemble goes on from there, to what a run from the beginning gives.
  experiment.precision.c = 0.45 * first[1].c.standard_error;
  const std::vector<Transport> grown = run(folder, 1), from_scratch = run(again, 3);
  CHECK(grown[1].samples > first[1].samples);
  CHECK(grown[1].samples == from_scratch[1].samples);
  CHECK(grown[1].c.standard_error <= experiment.precision.c);
  const std::string precise = read_file(folder.path() / "ensembles/mu-0.3.h5");
  CHECK(precise == read_file(again.path() / "ensembles/mu-0.3.h5"));
  // The next run finds it as it is.
  CHECK(run(folder, 2)[1].samples == grown[1].samples);
  CHECK(read_file(folder.path() / "ensembles/mu-0.3.h5") == precise);
  // Less is asked for: what is there would have been stopped earlier.
  experiment.precision.c = 2e-3;
  CHECK(run(folder, 2)[1].samples == first[1].samples);
  CHECK(read_file(folder.path() / "ensembles/mu-0.3.h5") == loose);

  // Beyond the most that is allowed it says so, and what it would take.
  experiment.precision = {1e-6, 0, 600};
  const RunResult given_up = run_experiment(experiment, quiet(again.path(), {Stage::report}));
  const PrecisionOutcome& outcome = given_up.analysis.results[1].precision;
  CHECK_FALSE(outcome.reached);
  CHECK(given_up.analysis.results[1].samples == 512);
  CHECK_THAT(outcome.reason, Catch::Contains("would be needed") && Catch::Contains("precision.most_samples = 600"));
  REQUIRE_FALSE(given_up.unexpected.empty());
  CHECK_THAT(given_up.unexpected.back(), Catch::Contains("was not reached at mu = 0.3"));
  const auto summary = nlohmann::json::parse(read_file(again.path() / "summary.json"));
  CHECK(summary.at("results")[1].at("precision").at("reached") == false);
  CHECK(summary.at("results")[1].at("precision").at("reason") == outcome.reason);
  CHECK(read_file(again.path() / "report.html").find("that was not reached") != std::string::npos);
}
