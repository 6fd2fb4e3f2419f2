// What a run estimates of itself: beads to draw, and the memory for it.
#include <catch2/catch.hpp>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "kit/set_key.h"
#include "kit/small_experiment.h"
#include "kit/standard_error_capture.h"
#include "kit/temporary_folder.h"
#include "pipeline/pipeline.h"
#include "pipeline/sample_stage.h"
#include "quiet_run.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;

namespace {

Experiment multiplexed_experiment(double mu, bool opposite) {
  Experiment experiment = small_experiment();
  experiment.mu = {mu};
  experiment.response.estimator = EstimatorName::multiplexed;
  experiment.response.epsilon = 0.25;
  experiment.response.opposite = opposite;
  return experiment;
}

PlannedStep drawing(const Experiment& experiment) {
  const TemporaryFolder folder;
  RunOptions options;
  options.folder = folder.path();
  options.only = {Stage::sample};
  const std::vector<PlannedStep> plan = plan_run(experiment, options);
  REQUIRE(plan.size() == 1);
  return plan.front();
}

EnsembleSpec pairs(EstimatorName estimator, bool opposite, Law law, double mu) {
  EnsembleSpec spec;
  spec.lattice = {64, 40};
  spec.sampler.mu = mu;
  spec.sampler.law = law;
  spec.response.estimator = estimator;
  spec.response.opposite = opposite;
  spec.response.samples = 256;
  return spec;
}

}  // namespace

TEST_CASE("the plan counts both piles of a pair with opposite loads") {
  const PlannedStep single = drawing(multiplexed_experiment(0.3, false));
  const PlannedStep pair = drawing(multiplexed_experiment(0.3, true));
  CHECK(single.beads == 256U * 120U * 70U);
  CHECK(pair.beads == 2 * single.beads);
  CHECK_THAT(single.what, Contains("256 piles"));
  CHECK_THAT(pair.what, Contains("256 pairs of piles"));
}

TEST_CASE("the beads estimated are those that are drawn") {
  for (const bool opposite : {false, true}) {
    EnsembleSpec spec = pairs(EstimatorName::multiplexed, opposite, Law::granusolve, 0.3);
    spec.response.epsilon = 0.25;
    INFO("opposite: " << opposite);
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    REQUIRE(record.failed.empty());
    CHECK(record.counts.beads == beads_of(spec, spec.response.samples));
  }
}

TEST_CASE("fewer pairs than single piles are estimated for a precision") {
  Experiment experiment = multiplexed_experiment(0.3, false);
  experiment.precision = {2e-4, 0, 1000000};
  const PlannedStep single = drawing(experiment);
  experiment.response.opposite = true;
  const PlannedStep pair = drawing(experiment);
  CHECK_THAT(pair.what, Contains("pairs of piles"));
  // A pair is worth four piles, the steps in rounds are up to 1.65 apart, and its two piles are two piles to draw.
  const double ratio = static_cast<double>(pair.beads) / static_cast<double>(single.beads);
  CHECK(ratio > 0.5 / 1.7);
  CHECK(ratio < 0.5 * 1.7);
}

TEST_CASE("two samplers, and a sampler that is handed both loads at once, need twice the memory") {
  using enum EstimatorName;
  const auto memory = [](const EnsembleSpec& spec) { return drawing_memory(spec); };
  const auto ratio = [&](EstimatorName estimator, Law law, double mu) {
    return memory(pairs(estimator, estimator == multiplexed, law, mu)) / memory(pairs(point, false, law, mu));
  };
  CHECK(ratio(multiplexed, Law::polytope, 0.3) == Approx(2));
  CHECK(ratio(paired, Law::polytope, 0.3) == Approx(2));
  CHECK(ratio(point, Law::polytope, 0.3) == Approx(1));
  // Where two groups are drawn at once they are one of each load.
  const Lattice lattice(pairs(point, false, Law::granusolve, 0.3).lattice);
  for (const double mu : {0.05, 0.3, 0.8}) {
    SamplerSpec sampler;
    sampler.mu = mu;
    INFO("mu = " << mu);
    CHECK(ratio(multiplexed, Law::granusolve, mu) == Approx(piles_at_once(sampler, lattice) > group_lanes ? 1 : 2));
  }
}

TEST_CASE("the time and memory of a plan are those of what is still to be drawn; the time is shorter on more threads") {
  Experiment experiment = small_experiment();
  const TemporaryFolder folder;
  RunOptions options;
  options.folder = folder.path();
  options.only = {Stage::sample};
  options.progress = ProgressStyle::silent;
  const std::vector<PlannedStep> plan = plan_run(experiment, options);
  const PlannedTime one = estimate_time(plan, 1), two = estimate_time(plan, 2);
  CHECK_FALSE(one.at_least);
  CHECK(one.seconds > 0);
  CHECK(two.seconds < 0.8 * one.seconds);
  CHECK(two.seconds > 0.3 * one.seconds);
  const double before = memory_needed(experiment, folder.path(), 1);
  run_experiment(experiment, options);
  CHECK(estimate_time(plan_run(experiment, options), 1).seconds == 0);
  const double drawn = drawing_memory(experiment.main_ensemble(experiment.mu.back()));
  CHECK(before - memory_needed(experiment, folder.path(), 1) == Approx(drawn));
}

TEST_CASE("what comes after the drawing is part of the time of a plan, also where nothing is left to draw") {
  Experiment experiment = small_experiment();
  RunOptions options;
  const auto time = [&] {
    std::vector<PlannedStep> plan = plan_run(experiment, options);
    for (PlannedStep& step : plan) step.samples = 0;
    return estimate_time(plan, 1).seconds;
  };
  const double whole = time();
  CHECK(whole > 3);
  options.only = {Stage::analyse};
  const double fits = time();
  CHECK(fits > 0);
  CHECK(fits < whole);
  experiment.lattice.columns *= 2;
  CHECK(time() == Approx(2 * fits));
  set_key(experiment, "studies.numerical_stability.layers", std::int64_t{100000});
  CHECK(time() > 2 * fits + 5);
}

TEST_CASE("a whole run tells its share and, at the pace of what is done, the time left") {
  CHECK(RunProgress::line(1, 4, 30) == "whole run: 25 %, about 1 min 30 s left");
  CHECK(RunProgress::line(0, 4, 30).empty());  // nothing is known yet
  CHECK(RunProgress::line(4, 4, 30).empty());  // nor is there anything left
  PlannedEnsemble planned;
  planned.spec.sampler.mu = 0.3;
  planned.spec.response.samples = 3200;
  const double whole = seconds_to_draw(planned, 1);
  CHECK(whole > 0);
  CHECK(seconds_to_draw(planned, 2) == Approx(whole / 2));
  planned.blocks_there = planned.spec.response.blocks / 2;
  CHECK(seconds_to_draw(planned, 1) == Approx(whole / 2));
  planned.reusable = true;
  CHECK(seconds_to_draw(planned, 1) == 0);
}

TEST_CASE("the pilot of a chain is part of the time of a plan, and a long one makes it an open one") {
  PlannedStep chains{Stage::sample, "chains"};
  chains.spec = pairs(EstimatorName::point, false, Law::polytope, 0.3);
  chains.spec.lattice = {40, 40};
  chains.spec.sampler.lambda = 0.1;
  chains.samples = 8;
  const PlannedTime on_many = estimate_time({chains}, 64);
  CHECK(on_many.at_least);
  CHECK(on_many.seconds > 60);  // nearly all of it is the pilot's, which one core runs for all
}

TEST_CASE("a run of slow piles tells at its beginning how long it takes, others do not") {
  Experiment experiment = small_experiment();
  experiment.mu = {0.3};
  experiment.response.samples = 64;
  experiment.response.blocks = 8;
  experiment.figures.response_profiles = false;
  for (const ModelName model : {ModelName::diluted_beads, ModelName::frictional_beads}) {
    const TemporaryFolder folder;
    experiment.sampling.model.name = model;
    experiment.lattice = {12, 12};
    experiment.fit.shallow_layer = experiment.fit.first_layer = 1;
    experiment.fit.last_layer = model == ModelName::diluted_beads ? 6 : 3;
    experiment.fit.layer_step = 1;
    if (model == ModelName::frictional_beads) experiment.lattice.layers = 24;
    RunOptions options = quiet(folder.path(), {Stage::sample});
    options.progress = ProgressStyle::plain;
    const test::StandardErrorCapture capture;
    run_experiment(experiment, options);
    const std::string told = capture.text();
    CHECK_THAT(told, Contains("sampling "));
    CHECK((told.find("all together roughly ") < told.find("sampling ")) == (model == ModelName::diluted_beads));
  }
}

TEST_CASE("the chains behind the pictures are part of the time of a plan") {
  Experiment experiment = small_experiment();
  experiment.lattice = {24, 30};
  experiment.sampling.law = Law::polytope;
  experiment.mu = {0.3};
  experiment.force_chains.columns = 24;
  experiment.force_chains.layers = 12;
  experiment.force_chains.mu = 0.2;
  RunOptions options;
  options.only = {Stage::plot, Stage::render};
  const auto chains = [&] {
    int count = 0;
    for (const PlannedStep& step : plan_run(experiment, options)) {
      count += step.stage != Stage::sample && step.samples > 0 && step.spec.sampler.law == Law::polytope ? 1 : 0;
    }
    return count;
  };
  CHECK(chains() == 3);  // the pictures' pile, the same under a uniform load, and that of one bead's forces
  experiment.force_chains.response = false;
  CHECK(chains() == 2);
  experiment.force_chains.mu = experiment.figures.profile_mu;
  CHECK(chains() == 1);
  experiment.sampling.law = Law::granusolve;
  CHECK(chains() == 0);
}
