// What a run leaves, and what it finds, makes anew and says when it fails.
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "experiment/experiment_file.h"
#include "kit/search_path.h"
#include "kit/set_key.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/pipeline.h"
#include "pipeline/quiet_run.h"
#include "pipeline/sample_stage.h"
#include "quiet_run.h"
#include "storage/pile_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using Catch::Matchers::Contains;
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
  const nlohmann::json manifest = manifest_of(folder.path());
  CHECK(manifest["status"] == "done");
  std::set<std::string> listed = {"manifest.json"};
  for (const auto& file : manifest.at("files")) listed.insert(file.at("path").get<std::string>());
  CHECK(listed == files);
  // The resolved experiment reads back and would give the same run.
  CHECK(print_experiment(parse_experiment(read_file(folder.path() / "experiment.toml"), "experiment.toml")) ==
        print_experiment(experiment));

  const std::string summary = read_file(folder.path() / "summary.json");
  // Nothing of the moment, the machine or the folder.
  CHECK(summary.find(folder.path().string()) == std::string::npos);
  CHECK(summary.find("seconds") == std::string::npos);
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

TEST_CASE("the first file of a run tells whose folder it is, so that a kill after it loses nothing") {
  const TemporaryFolder folder;
  const FileDescriptor watch(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC));
  REQUIRE(::inotify_add_watch(watch.get(), folder.path().c_str(), IN_MOVED_TO) >= 0);
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::render}));
  alignas(inotify_event) std::array<char, 4096> events{};
  REQUIRE(::read(watch.get(), events.data(), events.size()) > 0);
  const std::string first = events.data() + sizeof(inotify_event);
  CHECK(first == "manifest.json");
  for (const char* path : {"experiment.toml", "timings.json", "piles", "figures"}) {
    fs::remove_all(folder.path() / path);
  }
  CHECK_NOTHROW(run_experiment(experiment, quiet(folder.path(), {Stage::render})));
}

TEST_CASE("only what is asked for is made") {
  const TemporaryFolder folder;
  const Experiment experiment = small_experiment();
  run_experiment(experiment, quiet(folder.path(), {Stage::render}));
  std::set<std::string> files = names_in(folder.path());
  CHECK(files == std::set<std::string>{"experiment.toml", "manifest.json", "timings.json", "piles/force-chains.h5",
                                       "piles/overloaded.h5", "piles/uniform.h5", "figures/force-chains.png",
                                       "figures/force-chains-narrow.png", "figures/pile-response.png"});
  run_experiment(experiment, quiet(folder.path(), {Stage::sample}));
  files = names_in(folder.path());
  CHECK(files.contains("ensembles/mu-0.4.h5"));
  CHECK_FALSE(files.contains("summary.json"));
  // No GL context is made for sampling, and the manifest says so.
  CHECK(read_file(folder.path() / "manifest.json").find("no GL context was made") != std::string::npos);
}

TEST_CASE("a damaged ensemble is drawn again, and only that one; one of another seed is none") {
  const TemporaryFolder folder;
  Experiment experiment = small_experiment();
  const RunOptions options = quiet(folder.path(), {Stage::sample});
  const auto reused = [&] {
    std::vector<bool> each;
    for (const PlannedStep& step : plan_run(experiment, options)) each.push_back(step.reused);
    return each;
  };
  run_experiment(experiment, options);
  const fs::path damaged = folder.path() / "ensembles/mu-0.3.h5";
  const std::string whole = read_file(damaged);
  write_file(damaged, std::string_view(whole).substr(0, whole.size() / 2));
  CHECK(reused() == std::vector<bool>{true, true, false, true});
  run_experiment(experiment, options);
  CHECK(read_file(damaged) == whole);
  CHECK(read_file(folder / "manifest.json").find("not drawn again: 3 of 4 ensembles") != std::string::npos);
  experiment.sampling.seed = 12;
  CHECK(reused() == std::vector<bool>(4, false));
}

TEST_CASE("an interrupted run says so and keeps what was finished") {
  const TemporaryFolder stopped;
  const Experiment experiment = small_experiment();
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
  CHECK(
      manifest.find("The figures of c and D against μ and each other are left out: both are precise enough at no μ.") !=
      std::string::npos);
  CHECK(read_file(folder.path() / "report.html").find("are left out: both are precise enough at no μ.") !=
        std::string::npos);
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
  Experiment experiment = unplotted(small_experiment());
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
  Experiment experiment = unplotted(small_experiment());
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
  run_experiment(experiment, quiet(folder.path(), {Stage::report}));
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
    run_experiment(unplotted(estimated_by(estimator)), quiet(folder.path()));
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

// A run whose results are all there does nothing.

namespace {

Experiment experiment() { return parse_experiment(one_plot_text, "small.toml"); }

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
  small.force_chains.show = true;
  run_experiment(small, quiet(folder.path()));
  REQUIRE(fs::exists(folder / "figures/response-profiles.svg"));
  REQUIRE(fs::exists(folder / "figures/force-chains.png"));
  write_file(folder / "figures/notes.txt", "somebody's own");
  const std::string chains = read_file(folder / "figures/force-chains.png");
  small.figures.response_profiles = false;
  const fs::perms own = fs::perms::owner_read | fs::perms::owner_write;
  for (const char* file : {"report.html", "summary.json"}) fs::permissions(folder / file, own);
  run_experiment(small, quiet(folder.path(), {Stage::sample}));  // has no figures of its own
  for (const char* of : {"figures/", "piles/"}) {                // nor passes those for its own
    const std::string name = of[0] == 'f' ? "response-profiles.svg" : "force-chains.h5";
    CHECK_FALSE(fs::exists(folder / (of + name)));
    CHECK(fs::exists(folder / (of + ("earlier-" + name))));
  }
  run_experiment(small, quiet(folder.path()));
  CHECK(fs::exists(folder / "piles/force-chains.h5"));
  CHECK_FALSE(fs::exists(folder / "piles/earlier-force-chains.h5"));
  for (const auto& entry : fs::directory_iterator(folder / "figures")) {
    CHECK(entry.path().filename().string().find("response-profiles") == std::string::npos);
  }
  CHECK(fs::exists(folder / "figures/notes.txt"));
  CHECK((read_file(folder / "figures/force-chains.png") == chains));
  CHECK(fs::exists(folder / "ensembles/mu-0.3.h5"));
  // Who has closed a report to others has closed the next one, too.
  for (const char* file : {"report.html", "summary.json"}) CHECK(fs::status(folder / file).permissions() == own);
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
  // On a busy machine nothing may have been drawn after the first of these.
  for (int milliseconds = 300; milliseconds < 10'000 && !fs::exists(folder.path() / part_file(planned[1]));
       milliseconds *= 3) {
    std::thread stopper([milliseconds] {
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      request_interruption(true);
    });
    CHECK_THROWS_AS(obtain_ensemble(planned[1], folder.path(), 2, ProgressStyle::silent, never_by_itself), Interrupted);
    stopper.join();
    request_interruption(false);
  }
  CHECK(fs::exists(folder.path() / part_file(planned[1])));
  CHECK(plan_ensembles(large, folder.path())[1].begun > 0);
}

// What a folder says of a run that has not ended, or ended badly, and what such a run leaves as it was.

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

TEST_CASE("an experiment of which no pile could be completed has its report, and is one that cannot be used") {
  const TemporaryFolder folder;
  Experiment experiment = unplotted(small_experiment());
  experiment.sampling.effort = 1;
  experiment.mu = {0.3, 0.4};
  for (const std::vector<Stage>& only : {std::vector{Stage::sample}, {Stage::report}, {Stage::report}}) {
    const RunResult result = run_experiment(experiment, quiet(folder.path(), only));
    CHECK(result.code == ExitCode::bad_input);
    CHECK_THAT(result.failure, Contains("no pile of any ensemble could be completed"));
    CHECK_THAT(read_file(folder / "manifest.json"), Contains("\"exit_code\": 2"));
  }
  CHECK(fs::exists(folder / "report.html"));
  experiment.mu = {0, 0.3};  // without friction any pile is completed
  CHECK(run_experiment(experiment, quiet(folder.path(), {Stage::report})).code == ExitCode::done);
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

TEST_CASE("a pipe in the place of the manifest is waited for by nobody") {
  const TemporaryFolder folder;
  REQUIRE(::mkfifo((folder / "manifest.json").c_str(), 0600) == 0);
  CHECK_THROWS_WITH(run_experiment(small_experiment(), quiet(folder.path(), {Stage::sample})),
                    Contains("manifest.json") && Contains("not an ordinary file"));
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
