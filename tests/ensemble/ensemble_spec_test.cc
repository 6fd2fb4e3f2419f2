// Source: the documented limits of an ensemble, and the contracts of progress and interruption.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "kit/standard_error_capture.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

EnsembleSpec sound() {
  EnsembleSpec spec;
  spec.sampler.mu = 0.2;
  spec.lattice = {.columns = 8, .layers = 6};
  spec.response.samples = 80;
  spec.response.blocks = 8;
  return spec;
}

TEST_CASE("ensembles that would mean nothing are refused before a pile is drawn") {
  CHECK_NOTHROW(validate(sound()));
  const auto refused = [](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    CHECK_THROWS_AS(validate(spec), InputError);
    CHECK_THROWS_AS(run_ensemble(spec, 2, nullptr), InputError);
  };
  refused([](EnsembleSpec& s) { s.response.blocks = 7; });
  refused([](EnsembleSpec& s) { s.response.blocks = -1; });
  refused([](EnsembleSpec& s) { s.response.samples = 56; });  // seven groups for eight blocks
  refused([](EnsembleSpec& s) { s.response.samples = 0; });
  refused([](EnsembleSpec& s) { s.response.samples = (std::uint64_t{1} << 32) + 1; });  // more than one seed names
  refused([](EnsembleSpec& s) { s.response.overload = 0; });
  refused([](EnsembleSpec& s) { s.response.overload = -1; });
  refused([](EnsembleSpec& s) { s.response.overload = std::numeric_limits<double>::quiet_NaN(); });
  refused([](EnsembleSpec& s) { s.response.overload = std::numeric_limits<double>::infinity(); });
  refused([](EnsembleSpec& s) { s.layers = {0, 6}; });
  refused([](EnsembleSpec& s) { s.layers = {-1}; });
  refused([](EnsembleSpec& s) { s.layers = {2, 1}; });
  refused([](EnsembleSpec& s) { s.layers = {1, 1}; });
  refused([](EnsembleSpec& s) { s.lattice.columns = 3; });
  refused([](EnsembleSpec& s) { s.lattice.layers = 0; });
}

TEST_CASE("what is wrong is told by the key of the number that should change") {
  const auto key_after = [](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    const auto found = find_problem(spec);
    return found ? found->key : "none";
  };
  CHECK(key_after([](EnsembleSpec&) {}) == "none");
  CHECK(key_after([](EnsembleSpec& s) { s.lattice.layers = 0; }) == "layers");
  CHECK(key_after([](EnsembleSpec& s) { s.sampler.max_tries = 0; }) == "max_tries");
  CHECK(key_after([](EnsembleSpec& s) { s.sampler.lambda = 0.5; }) == "lambda");
  CHECK(key_after([](EnsembleSpec& s) { s.response.epsilon = least_epsilon / 2; }) == "epsilon");
  CHECK(key_after([](EnsembleSpec& s) { s.response.overload = 2e6; }) == "overload");
  CHECK(key_after([](EnsembleSpec& s) { s.response.opposite = true; }) == "opposite");
  CHECK(key_after([](EnsembleSpec& s) { s.response = multiplexed_response(0.25, true, 2); }) == "sign_run");
  CHECK(key_after([](EnsembleSpec& s) { s.response.samples = 56; }) == "samples");
  EnsembleSpec spec = sound();
  spec.response.blocks = 7;
  CHECK_THROWS_WITH(validate(spec), Catch::StartsWith("blocks: 7 is out of range"));
}

TEST_CASE("a sampler that cannot be made is told from any thread") {
  EnsembleSpec spec = sound();
  spec.sampler.mu = 1.8;
  CHECK_THROWS_AS(run_ensemble(spec, 3, nullptr), InputError);
  spec = sound();
  spec.sampler.effort = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(run_ensemble(spec, 3, nullptr), InputError);
}

TEST_CASE("absurd numbers of samples are called too many") {
  EnsembleSpec spec = sound();
  spec.response.samples = std::numeric_limits<std::uint64_t>::max();
  CHECK_THROWS_WITH(validate(spec), Catch::Contains("too many"));
}

TEST_CASE("a replay command holds whatever decides where a pile fails") {
  EnsembleSpec spec = sound();
  CHECK(replay_command(spec, 3).find("--max-tries") == std::string::npos);
  spec.sampler.law = Law::rejection;
  spec.sampler.max_tries = 50;
  CHECK_THAT(replay_command(spec, 3), Catch::Contains(" --max-tries 50 "));
}

TEST_CASE("the load is one on every top bead, and more on the middle one") {
  EnsembleSpec spec = sound();
  spec.response.overload = 0.25;
  std::vector<double> expected(8, 1.0);
  spec.load = Load::uniform;
  CHECK(top_load(spec) == expected);
  spec.load = Load::point;
  expected[4] = 1.25;
  CHECK(top_load(spec) == expected);
  CHECK(load_named("uniform") == Load::uniform);
  CHECK(load_named("point") == Load::point);
  CHECK_THROWS_AS(load_named("line"), InputError);
}

TEST_CASE("the configuration tells apart whatever changes the numbers, and nothing else") {
  std::set<std::string> texts;
  std::size_t variants = 0;
  const auto variant = [&](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    texts.insert(configuration_text(spec));
    ++variants;
  };
  variant([](EnsembleSpec&) {});
  variant([](EnsembleSpec& s) { s.sampler.mu = std::nextafter(0.2, 1.0); });
  variant([](EnsembleSpec& s) { s.sampler.seed = 2; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::rejection; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::eloy_clement; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::polytope; });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.lambda = 0.5;
  });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.burn_in = 100;
  });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.thinning = 10;
  });
  variant([](EnsembleSpec& s) { s.sampler.effort = 100; });
  variant([](EnsembleSpec& s) { s.sampler.max_tries = 5; });
  variant([](EnsembleSpec& s) { s.sampler.order = LayerOrder::fixed; });
  variant([](EnsembleSpec& s) { s.lattice.columns = 9; });
  variant([](EnsembleSpec& s) { s.lattice.layers = 7; });
  variant([](EnsembleSpec& s) { s.load = Load::uniform; });
  variant([](EnsembleSpec& s) { s.response.overload = 0.5; });
  variant([](EnsembleSpec& s) { s.response.samples = 81; });
  variant([](EnsembleSpec& s) { s.response.blocks = 9; });
  variant([](EnsembleSpec& s) { s.layers = {2}; });
  variant([](EnsembleSpec& s) { s.record_profiles = false; });
  variant([](EnsembleSpec& s) { s.record_H = true; });
  CHECK(texts.size() == variants);
  // All layers by name or by default, and an overload that a uniform load does not have, are the same ensemble.
  EnsembleSpec named = sound();
  named.layers = {0, 1, 2, 3, 4, 5};
  CHECK(configuration_text(named) == configuration_text(sound()));
  EnsembleSpec a = sound(), b = sound();
  a.load = b.load = Load::uniform;
  b.response.overload = 3;
  CHECK(configuration_text(a) == configuration_text(b));
}

TEST_CASE("a stored configuration is read back as the ensemble that it tells of") {
  std::vector<EnsembleSpec> all(6, sound());
  all[1].sampler.law = Law::polytope;
  all[1].sampler.lambda = 0.1;
  all[1].sampler.burn_in = 7;
  all[1].sampler.seed = ~std::uint64_t{0};
  all[1].layers = {1, 4};
  all[1].response.estimator = EstimatorName::paired;
  all[2].response = multiplexed_response(1.0 / 3, true, 2);
  all[2].sampler.load_angle = -1.5;
  all[2].record_H = true;
  all[2].record_profiles = false;
  all[3].response.estimator = EstimatorName::fluctuation;
  all[3].response.base_step = 5;
  all[4].load = Load::uniform;
  all[4].sampler.model.name = ModelName::three_leg;
  all[4].sampler.model.three_leg = {.law = MiddleLaw::clipped, .noise = 0.01};
  all[5].sampler.model.name = ModelName::stochastic_osl;
  all[5].sampler.model.stochastic_osl = {
      .disorder = 0.1, .cell_columns = 2, .cell_rows = 3, .noise = NoiseLaw::gaussian};
  for (const ModelName model : {ModelName::q_model, ModelName::diluted_beads}) {
    all.push_back(sound());
    all.back().sampler.model.name = model;
    all.back().sampler.model.q_model = {SplitLaw::beta, 0.5};
    all.back().sampler.model.diluted_beads.share = 0.125;
  }
  for (const EnsembleSpec& spec : all) {
    const std::string text = configuration_text(spec);
    INFO(text);
    CHECK(configuration_text(ensemble_configured(text + "groups_drawn=3\n")) == text);
  }
  CHECK_THROWS_WITH(ensemble_configured("columns=many\n"), Catch::StartsWith("columns: many is not a whole number"));
}

TEST_CASE("progress is advanced by one for each sample, failed ones included") {
  EnsembleSpec spec = sound();
  spec.load = Load::point;
  spec.response.overload = 1e6;  // too isolated to be solved: some piles fail
  spec.sampler.effort = 2;
  test::StandardErrorCapture capture;
  Progress progress("sampling", 80, ProgressStyle::plain);
  const EnsembleRecord record = run_ensemble(spec, 2, &progress);
  progress.finish();
  // Were it not complete, the closing line would read 79/80 or the like.
  CHECK_THAT(capture.text(), Catch::Contains("sampling: 80 in "));
  CHECK_FALSE(record.failed.empty());
}

TEST_CASE("a request to stop ends the ensemble with Interrupted") {
  request_interruption(true);
  CHECK_THROWS_AS(run_ensemble(sound(), 2, nullptr), Interrupted);
  request_interruption(false);
  CHECK_NOTHROW(run_ensemble(sound(), 2, nullptr));
}

}  // namespace
}  // namespace granuscope
