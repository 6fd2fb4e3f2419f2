// Ensembles that are stopped, and that grow.
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "analysis/jackknife.h"
#include "kit/sanitized.h"
#include "kit/set_key.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/block_files.h"
#include "pipeline/pipeline.h"
#include "pipeline/sample_stage.h"
#include "quiet_run.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"
#include "support/progress.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

// What an ensemble that is stopped leaves behind, and how it is continued.

namespace {

/// Interrupts `draw` once this part of its ensemble is there, which it leaves.
template <typename Draw>
void interrupt_at(const fs::path& part, const Draw& draw) {
  std::atomic<bool> over = false;
  std::thread stopper([&] {
    while (!over && !fs::exists(part)) std::this_thread::yield();
    request_interruption(true);
  });
  CHECK_THROWS_AS(draw(), Interrupted);
  over = true;
  stopper.join();
  request_interruption(false);
  CHECK(fs::exists(part));
}

}  // namespace

TEST_CASE("an ensemble stopped half way is continued from its last part, to the same bytes") {
  const TemporaryFolder whole, stopped;
  Experiment experiment = small_experiment();
  experiment.response.samples = 32 * group_size * (test::sanitized ? 6 : 24);
  const std::size_t one = 2;
  std::vector<PlannedEnsemble> planned = plan_ensembles(experiment, whole.path());
  obtain_ensemble(planned[one], whole.path(), 2, ProgressStyle::silent);

  const PartPolicy after_each_group{0, 0};
  planned = plan_ensembles(experiment, stopped.path());
  CHECK(planned[one].begun == 0);
  const fs::path part = stopped.path() / part_file(planned[one]);
  const auto draw = [&] { obtain_ensemble(planned[one], stopped.path(), 1, ProgressStyle::silent, after_each_group); };
  interrupt_at(part, draw);
  CHECK_FALSE(fs::exists(stopped.path() / planned[one].file));

  // Another experiment does not go on from there, this one does.
  Experiment other = experiment;
  other.sampling.seed += 1;
  CHECK(plan_ensembles(other, stopped.path())[one].begun == 0);
  planned = plan_ensembles(experiment, stopped.path());
  CHECK(planned[one].begun > 0);
  std::string plan;
  for (const PlannedStep& step : plan_run(experiment, quiet(stopped.path()))) plan += step.what + "\n";
  CHECK_THAT(plan, Catch::Contains("of them there already"));
  draw();
  CHECK(read_file(stopped.path() / planned[one].file) == read_file(whole.path() / planned[one].file));
  CHECK_FALSE(fs::exists(part));
}

TEST_CASE("chains are kept part by part, too, though they draw few beads for their time") {
  const TemporaryFolder whole, stopped;
  PlannedEnsemble planned;
  planned.label = "chains";
  planned.file = "ensembles/chains.h5";
  planned.spec.sampler.law = Law::polytope;
  planned.spec.sampler.mu = 0.3;
  planned.spec.sampler.thinning = 10;  // the burn-in is measured, for the same key again when it goes on
  planned.spec.lattice = {6, 6};
  planned.spec.response.samples = 32 * group_size * 4;
  PlannedEnsemble at_once = planned;
  obtain_ensemble(at_once, whole.path(), 2, ProgressStyle::silent);

  const fs::path part = stopped.path() / part_file(planned);
  PartPolicy often;
  often.seconds = 0.01;
  interrupt_at(part, [&] { obtain_ensemble(planned, stopped.path(), 1, ProgressStyle::silent, often); });
  look_for(planned, stopped.path());
  CHECK(planned.begun > 0);
  obtain_ensemble(planned, stopped.path(), 2, ProgressStyle::silent);
  CHECK(read_file(stopped.path() / planned.file) == read_file(whole.path() / planned.file));
}

TEST_CASE("a damaged part of an ensemble is drawn again") {
  const TemporaryFolder whole, folder;
  const Experiment experiment = small_experiment();
  std::vector<PlannedEnsemble> planned = plan_ensembles(experiment, whole.path());
  obtain_ensemble(planned[1], whole.path(), 2, ProgressStyle::silent);
  make_folder(folder.path() / "ensembles");
  write_file(folder.path() / part_file(planned[1]), "no ensemble");
  planned = plan_ensembles(experiment, folder.path());
  CHECK(planned[1].begun == 0);
  planned[1].begun = 1;  // as if only its configuration had been whole
  obtain_ensemble(planned[1], folder.path(), 2, ProgressStyle::silent);
  CHECK(read_file(folder.path() / planned[1].file) == read_file(whole.path() / planned[1].file));
}

// What a run of the program itself says on standard error while an ensemble grows.

namespace {

/// Draws the ensembles of an experiment, and returns what was planned before.
std::vector<PlannedStep> plan_and_draw(const Experiment& experiment, const TemporaryFolder& folder) {
  RunOptions options;
  options.folder = folder.path();
  options.threads = 2;
  options.only = {Stage::sample};
  options.progress = ProgressStyle::silent;
  std::vector<PlannedStep> plan = plan_run(experiment, options);
  run_experiment(experiment, options);
  return plan;
}

}  // namespace

TEST_CASE("a growing ensemble says how many piles it takes and how long that is, from its errors so far",
          "[unsanitized]") {
  Experiment experiment = small_experiment();
  experiment.response.estimator = EstimatorName::multiplexed;
  experiment.mu = {0.3};
  experiment.precision = {8e-4, 0, 20000};
  experiment.figures = {};
  experiment.figures.profile_mu = 0.3;
  experiment.figures.profile_layers = {31, 49};
  experiment.fit.scaling_window = {0.2, 0.4};
  experiment.force_chains.show = false;
  const TemporaryFolder folder;
  write_file(folder / "run.toml", print_experiment(experiment));
  ProcessSpec process;
  process.arguments = {std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope",
                       "run",
                       (folder / "run.toml").string(),
                       "--out",
                       (folder / "out").string(),
                       "--only",
                       "analyse",
                       "--threads",
                       "1"};
  const ProcessResult result = run_process(process);
  CAPTURE(result.standard_error);
  REQUIRE(result.exit_code == 0);
  std::vector<std::array<double, 3>> looks;
  std::istringstream lines(result.standard_error);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find("after ");
    std::array<double, 3> look{};
    if (at == std::string::npos) continue;
    if (std::sscanf(line.c_str() + at, "after %lf piles; about %lf in all are needed, %lf with whole steps", &look[0],
                    &look[1], &look[2]) == 3) {
      looks.push_back(look);
    }
  }
  REQUIRE(looks.size() >= 2);
  RunOptions there;
  there.folder = folder / "out";
  there.only = {Stage::analyse};
  there.progress = ProgressStyle::silent;
  const auto stopped = static_cast<double>(run_experiment(experiment, there).analysis.results.front().samples);
  CHECK(stopped > looks.back()[0]);
  for (const auto& [piles, needed, steps] : looks) {
    INFO("after " << piles << ": " << needed << ", " << steps << "; it stopped after " << stopped);
    CHECK(needed > piles);
    const double rounding = std::pow(10, std::floor(std::log10(needed)) - 1) / 2;  // two digits are printed
    CHECK(steps >= needed - rounding);
    CHECK(steps <= (needed + rounding) * 5 / 3);  // the steps in rounds: 1, 2, 3, 5, 8, ...
    // An error from 32 blocks, squared, is known to a quarter: five of these.
    CHECK(needed < 2.3 * stopped);
    CHECK(needed > stopped / 1.5 / 2.3);
  }
}

TEST_CASE("more samples go on from what is there, to the bytes of one large run") {
  const TemporaryFolder step_by_step, at_once;
  Experiment experiment = small_experiment();
  experiment.mu = {0.0, 0.3};
  const auto run = [&](const TemporaryFolder& folder, std::uint64_t samples) {
    experiment.response.samples = samples;
    return plan_and_draw(experiment, folder);
  };
  const std::uint64_t few = 264, many = 763;  // neither gives each of the 32 blocks as many groups of eight
  run(step_by_step, few);
  const std::vector<PlannedStep> plan = run(step_by_step, many);
  REQUIRE(plan.size() == 2);
  CHECK(plan[0].reused);  // without friction there is nothing to add
  CHECK(plan[1].samples == many - few);
  CHECK(plan[1].what.find("264 of them there already") != std::string::npos);
  CHECK(plan[1].what.find("replaces") == std::string::npos);
  run(at_once, many);
  for (const char* file : {"ensembles/mu-0.h5", "ensembles/mu-0.3.h5"}) {
    INFO(file);
    CHECK((read_file(step_by_step / file) == read_file(at_once / file)));
  }
  // An incomplete group is the beginning of nothing, and so are samples of another seed.
  const std::vector<PlannedStep> incomplete = run(step_by_step, 768);
  CHECK(incomplete[1].samples == 768);
  CHECK(incomplete[1].what.find("multiple of 8") != std::string::npos);
  experiment.sampling.seed += 1;
  const std::vector<PlannedStep> other = run(step_by_step, 1024);
  CHECK(other[1].samples == 1024);
  CHECK(other[1].what.find("seed") != std::string::npos);
  CHECK(other[1].what.find("multiple of 8") == std::string::npos);
  // What is damaged is called so, however many piles are asked for.
  const fs::path file = step_by_step.path() / "ensembles/mu-0.3.h5";
  fs::resize_file(file, fs::file_size(file) - 100);
  const std::vector<PlannedStep> damaged = run(step_by_step, 2048);
  CHECK(damaged[1].samples == 2048);
  CHECK(damaged[1].what.find("cannot read") != std::string::npos);
  CHECK(damaged[1].what.find("another experiment") == std::string::npos);
}

TEST_CASE("more samples of a study go on from what is there, too") {
  const TemporaryFolder step_by_step, at_once;
  Experiment experiment = small_experiment();
  experiment.mu = {0.3};
  set_key(experiment, "studies.deep_response.mu", numbers({0.3}));
  set_key(experiment, "studies.deep_response.first_lag", std::int64_t{4});
  set_key(experiment, "studies.deep_response.octaves", std::int64_t{3});
  set_key(experiment, "studies.deep_response.columns", std::int64_t{48});
  const auto run = [&](const TemporaryFolder& folder, std::int64_t samples) {
    set_key(experiment, "studies.deep_response.samples", samples);
    return plan_and_draw(experiment, folder);
  };
  run(step_by_step, 256);
  const std::vector<PlannedStep> plan = run(step_by_step, 520);
  REQUIRE(plan.size() == 2);
  CHECK(plan[1].samples == 520 - 256);
  CHECK(plan[1].what.find("256 of them there already") != std::string::npos);
  run(at_once, 520);
  const char* const file = "ensembles/deep-response-mu-0.3.h5";
  CHECK((read_file(step_by_step / file) == read_file(at_once / file)));
}

TEST_CASE("chains of a study grow until they are worth the piles asked for, to the bytes of as many samples") {
  const TemporaryFolder growing, at_once;
  Experiment experiment = small_experiment();
  experiment.mu = {0.0};
  experiment.sampling.law = Law::polytope;
  experiment.sampling.lambda = 0;
  experiment.sampling.burn_in = 8;
  experiment.sampling.thinning = 2;  // of piles that take ten sweeps or more
  for (const char* key : {"octaves", "first_lag", "reference_lag", "first_base", "base_step"})
    set_key(experiment, std::string("studies.deep_response.") + key, std::int64_t{key[0] == 'o' ? 3 : 1});
  set_key(experiment, "studies.deep_response.mu", numbers({0.3}));
  set_key(experiment, "studies.deep_response.columns", std::int64_t{24});
  set_key(experiment, "studies.deep_response.samples", std::int64_t{4096});
  set_key(experiment, "studies.deep_response.effective_samples", 300.0);
  const auto configuration = [](const TemporaryFolder& folder) {
    return read_ensemble_configuration(folder / "ensembles/deep-response-mu-0.3.h5");
  };
  const std::vector<PlannedStep> plan = plan_and_draw(experiment, growing);
  CHECK_THAT(plan.back().what, Catch::Contains("by a rule of thumb"));
  const std::uint64_t samples = count_in(configuration(growing), "samples");
  CHECK(samples > 300);
  CHECK(samples < 4096);
  const EnsembleRecord grown = read_ensemble(growing / "ensembles/deep-response-mu-0.3.h5");
  CHECK(effective_samples(grown.sums).value >= 300);
  // As many are there already; more go on from there.
  CHECK(plan_and_draw(experiment, growing).back().reused);
  set_key(experiment, "studies.deep_response.effective_samples", 500.0);
  CHECK_THAT(plan_and_draw(experiment, growing).back().what, Catch::Contains("by the errors so far"));
  const std::uint64_t more = count_in(configuration(growing), "samples");
  CHECK(more > samples);
  set_key(experiment, "studies.deep_response.effective_samples", 0.0);
  set_key(experiment, "studies.deep_response.samples", static_cast<std::int64_t>(more));
  plan_and_draw(experiment, at_once);
  const EnsembleRecord whole = read_ensemble(at_once / "ensembles/deep-response-mu-0.3.h5");
  const EnsembleRecord stepwise = read_ensemble(growing / "ensembles/deep-response-mu-0.3.h5");
  for (const auto& [name, quantity] : whole.sums.quantities) {
    INFO(name);
    CHECK(quantity.sum == stepwise.sums.quantities.at(name).sum);
  }
}

namespace {

/// An ensemble of `groups` groups, drawn whole in `folder`.
PlannedEnsemble drawn(const fs::path& folder, std::uint64_t groups, std::uint64_t grows_from = 0) {
  PlannedEnsemble planned;
  planned.label = "mu = 0.3";
  planned.file = "ensembles/mu-0.3.h5";
  planned.spec = small_experiment().main_ensemble(0.3);
  planned.spec.response.samples = groups * group_size;
  planned.grows_from = grows_from;
  look_for(planned, folder);
  obtain_ensemble(planned, folder, 2, ProgressStyle::silent);
  return planned;
}

}  // namespace

TEST_CASE("a larger ensemble that is stopped goes on from its part, or from the smaller one where that is damaged") {
  const TemporaryFolder whole, stopped;
  const std::uint64_t few = 64, many = 64 * 12;
  drawn(whole.path(), many);
  drawn(stopped.path(), few);
  StudyEnsemble larger{"mu = 0.3", "mu-0.3", small_experiment().main_ensemble(0.3)};
  larger.spec.response.samples = many * group_size;
  PlannedEnsemble planned = plan_ensemble(larger, stopped.path());
  const fs::path part = stopped.path() / part_file(planned);
  interrupt_at(part, [&] { obtain_ensemble(planned, stopped.path(), 1, ProgressStyle::silent, {0, 0}); });

  planned = plan_ensemble(larger, stopped.path());
  CHECK(planned.begun > few);
  CHECK(planned.replaces.empty());  // nothing is: the old file is a beginning of the new one
  std::string bytes = read_file(part);
  bytes.resize(bytes.size() / 2);
  write_file(part, bytes);
  planned = plan_ensemble(larger, stopped.path());
  REQUIRE(planned.smaller);
  CHECK(samples_there(planned) == few * group_size);
  obtain_ensemble(planned, stopped.path(), 2, ProgressStyle::silent);
  CHECK((read_file(stopped.path() / planned.file) == read_file(whole.path() / planned.file)));
  CHECK_FALSE(fs::exists(part));
}

TEST_CASE("a whole ensemble leaves nothing unfinished behind, but keeps what is drawn of its next size") {
  const TemporaryFolder folder;
  PlannedEnsemble planned = drawn(folder.path(), 64, 64 * group_size);
  const fs::path part = folder.path() / part_file(planned);
  const BlockFiles blocks(planned, folder.path());
  // Beginnings of this size, left by a stop, go; a file of the user's stays, and its folder with it.
  const auto leave = [&](std::uint64_t groups) {
    PlannedEnsemble other = planned;
    other.spec.response.samples = groups * group_size;
    EnsembleRecord begun = begin_ensemble(other.spec);
    begun.configuration += "groups_drawn=0\n";
    make_folder(blocks.folder());
    for (const fs::path& file : {part, blocks.file(3), blocks.folder() / "4.part.h5"}) write_ensemble(file, begun);
  };
  for (const std::uint64_t grows_from : {std::uint64_t{0}, planned.grows_from}) {
    INFO(grows_from);
    leave(64);
    planned.grows_from = grows_from;
    look_for(planned, folder.path());
    REQUIRE(planned.reusable);
    obtain_ensemble(planned, folder.path(), 2, ProgressStyle::silent);
    CHECK_FALSE(fs::exists(part));
    CHECK_FALSE(fs::exists(blocks.folder()));
  }
  leave(128);
  look_for(planned, folder.path());
  obtain_ensemble(planned, folder.path(), 2, ProgressStyle::silent);
  for (const fs::path& file : {part, blocks.file(3), blocks.folder() / "4.part.h5"}) CHECK(fs::exists(file));
}
