#include "experiment/experiment.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "analysis/double_gaussian.h"
#include "experiment/experiment_file.h"
#include "kit/set_key.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

/// The problem of the default experiment after a change: "key: message".
std::string problem_after(const std::function<void(Experiment&)>& change) {
  Experiment e;
  change(e);
  const auto found = find_problems(e);
  return found.empty() ? "(none)" : found.front().key + ": " + found.front().message;
}

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("The default experiment can be run") { CHECK(find_problems(Experiment{}).empty()); }

TEST_CASE("Page 1 is about a study that is measured") {
  CHECK_THAT(problem_after([](Experiment& e) { e.report.about = "deep_response"; }),
             Contains("report.about: ") && Contains("is no study of this experiment"));
  const auto of_chains = [](const char* about) {
    return [about](Experiment& e) {
      set_key(e, "studies.chain_share.samples", std::int64_t{256});
      e.report.about = about;
    };
  };
  CHECK_THAT(problem_after(of_chains("deep_response")), Contains("no study of it tells"));
  CHECK_THAT(problem_after(of_chains("chain_share")), Contains("has a table and no sentence for page 1"));
}

TEST_CASE("Friction coefficients outside [0, sqrt 3) are refused") {
  for (const double mu : {-0.1, -1e-300, 1.7320508075688773, 2.0, not_a_number, infinity, -infinity}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.mu = {mu}; }), Contains("friction.mu: ") && Contains("sqrt(3)"));
    CHECK_THAT(problem_after([&](Experiment& e) { e.force_chains.mu = mu; }), Contains("scenes.force_chains.mu: "));
  }
  CHECK(problem_after([](Experiment& e) { e.mu = {0.0, 0.3, 1.73}; }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) { e.mu = {}; }), Contains("empty"));
  CHECK_THAT(problem_after([](Experiment& e) { e.mu = {0.3, 0.3}; }), Contains("0.3 stands in the list twice"));
  CHECK_THAT(problem_after([](Experiment& e) { e.mu = {0.3, 0.1}; }), Contains("must ascend"));
  CHECK_THAT(problem_after([](Experiment& e) { e.mu.assign(2000, 0.1); }), Contains("2000 values"));
}

TEST_CASE("Thresholds of claims that decide nothing are refused") {
  for (const double bad : {0.0, 8.0, 1e7, -25.0, not_a_number, infinity}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.claims.decisive_chi2 = bad; }), Contains("claims.decisive_chi2: "));
  }
  for (const double bad : {-0.01, 0.031, 1.0, not_a_number, infinity}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.claims.exponent_tolerance = bad; }),
               Contains("claims.exponent_tolerance: "));
  }
  for (const double bad : {0.0, 1.0, -0.5, 2.0, not_a_number, infinity}) {
    CHECK_THAT(problem_after([&](Experiment& e) { set_key(e, "studies.chain_share.least_share", bad); }),
               Contains("studies.chain_share.least_share: "));
  }
  CHECK_THAT(problem_after([](Experiment& e) { e.claims.highest_mu = 1.8; }), Contains("claims.highest_mu: "));
}

TEST_CASE("Duplicates in a file are found although the list is sorted when read") {
  CHECK_THROWS_WITH(parse_experiment("[friction]\nmu = [0.3, 0.1, 0.3]\n", "x.toml"),
                    Contains("x.toml:2:1: friction.mu: 0.3"));
  CHECK_THROWS_WITH(parse_experiment("[friction]\nmu = [nan]\n", "x.toml"), Contains("friction.mu: nan"));
}

TEST_CASE("A pile that cannot be held in memory is refused with the memory it would need") {
  // 1e6 x 1e6 beads x 12 numbers x 8 bytes = 96 TB; of the sums no more than some layers.
  CHECK_THAT(problem_after([](Experiment& e) {
               e.lattice = {1'000'000, 1'000'000};
             }),
             Contains("lattice.layers: ") && Contains("96 TB"));
  CHECK_THAT(problem_after([](Experiment& e) { e.lattice = {2147483647, 2147483647}; }), Contains("TB of memory"));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.columns = 2147483647; }),
             Contains("lattice.columns: ") || Contains("scenes.force_chains.columns: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.layers = 2147483647; }), Contains("of memory"));
  CHECK(estimate_memory(Experiment{}) < 1e9);
}

TEST_CASE("Lattices that are too small are refused") {
  CHECK_THAT(problem_after([](Experiment& e) { e.lattice.columns = 3; }), Contains("lattice.columns: 3 columns"));
  CHECK_THAT(problem_after([](Experiment& e) { e.lattice.columns = -1; }), Contains("lattice.columns: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.lattice.layers = 0; }), Contains("lattice.layers: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.layers = 0; }), Contains("scenes.force_chains.layers: "));
}

TEST_CASE("Windows must lie within the usable layers") {
  // 200 layers, the lowest 20 follow another law: the last usable one is 179.
  CHECK(problem_after([](Experiment& e) { e.fit.last_layer = 179; }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.last_layer = 180; }),
             Contains("fit.last_layer: layer 180") && Contains("end the window at 179 or compute 201 layers"));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.last_layer = 2147483647; }), Contains("fit.last_layer: "));
  CHECK_THAT(problem_after([](Experiment& e) {
               e.figures.profile_layers = {110, 180};
             }),
             Contains("figures.response_profiles.layers: layer 180 is not usable") && Contains("0 to 179"));
  CHECK_THAT(problem_after([](Experiment& e) { e.figures.profile_layers = {-1}; }),
             Contains("figures.response_profiles.layers: -1"));
  CHECK_THAT(problem_after([](Experiment& e) { e.figures.profile_layers = {110, 110}; }), Contains("twice"));
  CHECK_THAT(problem_after([](Experiment& e) { e.figures.profile_layers = {}; }), Contains("give 1 to 8"));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.first_layer = 178; }), Contains("holds 1 depth,"));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.layer_step = 0; }), Contains("fit.layer_step: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.layer_step = 100; }), Contains("fit.layer_step: the window"));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.shallow_layer = 59; }), Contains("fit.shallow_layer: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.fit.min_identifiable_width = not_a_number; }),
             Contains("nan is out of range"));
}

TEST_CASE("The profile shown must be one that is computed, if it is shown at all") {
  CHECK_THAT(problem_after([](Experiment& e) { e.figures.profile_mu = 0.25; }),
             Contains("0.25 is not one of friction.mu = [0, 0.1, 0.2, 0.3]"));
  CHECK(problem_after([](Experiment& e) {
          e.figures.profile_mu = 0.25;
          e.figures.response_profiles = false;
        }) == "(none)");
}

TEST_CASE("Peaks that would meet behind the ring are refused with the layer") {
  // At mu = 0 the width is taken as 1; 2 tan30 z_n + 8 = n + 8.577 columns are needed, one more for each layer.
  const auto with_columns = [](int columns) {
    return problem_after([columns](Experiment& e) {
      e.mu = {0.0};
      e.figures.response_profiles = false;
      e.lattice.columns = columns;
    });
  };
  CHECK(with_columns(188) == "(none)");
  CHECK_THAT(with_columns(187), Contains("lattice.columns: ") && Contains("from layer 179 on") &&
                                    Contains("layer 179 is used (fit.last_"));
  CHECK_THAT(with_columns(181), Contains("from layer 173 on") && Contains("give more than 187 columns"));
  // Friction widens the peaks.
  CHECK_THAT(problem_after([](Experiment& e) {
               e.mu = {0.3, 1.0};
               e.lattice.columns = 200;
             }),
             Contains("at mu = 1 meet"));
  // And makes them faster than tan30 beyond mu = 1.
  CHECK(expected_speed(0.5) == expected_speed(0.0));
  CHECK(expected_speed(1.7) > 1.5 * expected_speed(1.0));
  const auto at_high_friction = [](int columns) {
    return problem_after([columns](Experiment& e) {
      e.mu = {1.7};
      e.lattice.layers = 500;
      e.fit.last_layer = 479;
      e.figures.response_profiles = false;
      e.lattice.columns = columns;
    });
  };
  CHECK(at_high_friction(1050) == "(none)");
  CHECK_THAT(at_high_friction(1000), Contains("at mu = 1.7 meet"));
}

TEST_CASE("Samples come in whole groups of eight per block, in at least eight blocks") {
  CHECK(problem_after([](Experiment& e) { e.response.samples = 256; }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) { e.response.samples = 255; }),
             Contains("response.samples: 255 samples in 32 blocks") && Contains("give 256 to"));
  CHECK_THAT(problem_after([](Experiment& e) { e.response.samples = 0; }), Contains("response.samples: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.response.samples = 1u << 31; }), Contains("response.samples: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.response.blocks = 7; }), Contains("fewer than 8 give no reliable"));
  CHECK_THAT(problem_after([](Experiment& e) { e.response.blocks = -8; }), Contains("response.blocks: "));
  CHECK(problem_after([](Experiment& e) { e.response.blocks = 8; }) == "(none)");
}

TEST_CASE("Loads, estimators and laws that cannot work are refused") {
  for (const double overload : {0.0, -1.0, not_a_number, infinity, 1e9, 1e-9}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.response.overload = overload; }), Contains("response.overload: "));
  }
  for (const double epsilon : {0.0, -0.25, 1.0, 1.5, not_a_number, infinity, 1e-9}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.response.epsilon = epsilon; }), Contains("response.epsilon: "));
  }
  for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
    CHECK(problem_after([&](Experiment& e) { e.response.estimator = estimator; }) == "(none)");
  }
  for (const int run : {-1, 0, 63, 500}) {
    CHECK_THAT(problem_after([&](Experiment& e) {
                 e.response.estimator = EstimatorName::multiplexed;
                 e.response.sign_run = run;
               }),
               Contains("response.sign_run: "));
  }
  CHECK_THAT(problem_after([](Experiment& e) { e.response.opposite = true; }),
             Contains("response.opposite: ") && Contains("change nothing under point"));
  CHECK(problem_after([](Experiment& e) {
          e.response.estimator = EstimatorName::multiplexed;
          e.response.opposite = true;
          e.response.sign_run = 62;
        }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.law = Law::rejection; }),
             Contains("sampling.law: ") && Contains("at most 256 beads") && Contains("polytope"));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.law = Law::polytope; }),
             Contains("sampling.law: ") && Contains("the 500 x 200 beads of [lattice]"));
  CHECK_THAT(problem_after([](Experiment& e) {
               e.sampling.law = Law::polytope;
               e.lattice = {64, 64};
             }),
             Contains("sampling.law: ") && Contains("the 70 x 80 beads of scenes.force_chains"));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.lambda = 0.5; }),
             Contains("sampling.lambda: ") && Contains("would change nothing under granusolve"));
  for (const double lambda : {-0.1, 1.1, not_a_number, infinity}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.sampling.lambda = lambda; }), Contains("sampling.lambda: "));
  }
  CHECK_THAT(problem_after([](Experiment& e) {
               e.sampling.law = Law::polytope;
               e.sampling.burn_in = most_sweeps + 1;
             }),
             Contains("sampling.burn_in: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.effort = 0; }), Contains("sampling.effort: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.max_tries = 0; }), Contains("sampling.max_tries: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.max_tries = most_tries + 1; }),
             Contains("sampling.max_tries: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.sampling.seed = ~std::uint64_t{0}; }), Contains("sampling.seed: "));
}

TEST_CASE("Ranges of mu must ascend") {
  for (const auto& window :
       {std::array{0.3, 0.1}, std::array{0.1, 0.1}, std::array{not_a_number, 1.0}, std::array{-1.0, 1.0}}) {
    CHECK_THAT(problem_after([&](Experiment& e) { e.fit.scaling_window = window; }), Contains("fit.scaling_window: "));
    CHECK_THAT(problem_after([&](Experiment& e) { e.fit.other_scaling_windows = {window}; }),
               Contains("fit.other_scaling_windows: "));
  }
}

TEST_CASE("Pictures that nobody could open or read are refused, unless none is drawn") {
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.scene.width_px = 10; }), Contains("width_px: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.scene.width_px = 100'000; }), Contains("width_px: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.scene.dpi = not_a_number; }), Contains("dpi"));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.scene.colour_map = "jet"; }), Contains("colour_map: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.force_chains.scene.backend = "glx"; }), Contains("backend: "));
  CHECK(problem_after([](Experiment& e) {
          e.force_chains.show = false;
          e.force_chains.scene.width_px = 10;
        }) == "(none)");
}

TEST_CASE("Names must fit on one line and verdicts must be known") {
  CHECK_THAT(problem_after([](Experiment& e) { e.name = ""; }), Contains("experiment.name: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.name = "  "; }), Contains("experiment.name: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.name = "two\nlines"; }), Contains("experiment.name: "));
  CHECK_THAT(problem_after([](Experiment& e) { e.description = std::string(20'000, 'x'); }), Contains("description"));
  CHECK_THAT(problem_after([](Experiment& e) { e.expected_verdicts["D-of-mu"] = "true"; }),
             Contains("gate.expect.D-of-mu: \"true\" is not a verdict"));
  CHECK_THAT(problem_after([](Experiment& e) { e.expected_verdicts["D-of-nu"] = "reproduced"; }),
             Contains("gate.expect.D-of-nu: nothing that is asked for tests such a claim") &&
                 Contains("did you mean D-of-mu?"));
}

TEST_CASE("A contradiction names the line of the key that was written, or says that its value follows") {
  CHECK_THROWS_WITH(parse_experiment("[fit]\nlast_layer = 300\n[lattice]\nlayers = 200\n", "x.toml"),
                    Contains("x.toml:2:1: fit.last_layer: layer 300 lies beyond"));
  CHECK_THROWS_WITH(parse_experiment("[lattice]\nlayers = 500\n[model]\nname = \"diluted-beads\"\n", "x.toml"),
                    Contains("x.toml: lattice.columns (which follows from what the file says): ") &&
                        Contains("x 500 beads with opened contacts"));
}

TEST_CASE("A precision that means nothing is refused") {
  CHECK(problem_after([](Experiment& e) { e.precision = {1e-4, 1e-3, 100'000}; }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) { e.precision.c = -1e-4; }), Contains("precision.c: -0.0001"));
  CHECK_THAT(problem_after([](Experiment& e) { e.precision.D = not_a_number; }), Contains("precision.D: nan"));
  CHECK_THAT(problem_after([](Experiment& e) {
               e.precision = {0, 1e-3, 1000};
             }),
             Contains("precision.most_samples: 1000 piles: the ensembles begin with response.samples"));
}

TEST_CASE("Loads that could not be compared are refused") {
  const auto with = [](auto change) {
    return problem_after([&](Experiment& e) {
      set_key(e, "studies.nonlinearity.mu", numbers({0.1, 0.2}));
      change(e);
    });
  };
  CHECK(with([](Experiment&) {}) == "(none)");
  // The eight piles of a chain share their loads, so that no law is too slow for them.
  CHECK(with([](Experiment& e) {
          e.sampling.law = Law::polytope;
          e.mu = {0.2};
          e.lattice = {40, 40};
          e.fit.shallow_layer = e.fit.first_layer = 4;
          e.fit.last_layer = 14;
          e.figures.profile_mu = 0.2;
          e.figures.profile_layers = {6};
          e.force_chains.show = false;
        }) == "(none)");
  CHECK_THAT(with([](Experiment& e) { e.response.epsilon = 0.3; }),
             Contains("studies.nonlinearity.epsilons: response.epsilon = 0.3 is not among [0.1, 0.25, 0.5]"));
  CHECK_THAT(with([](Experiment& e) {
               set_key(e, "studies.nonlinearity.mu", numbers({0.0, 0.1}));
             }),
             Contains("nothing is random"));
  CHECK_THAT(with([](Experiment& e) {
               set_key(e, "studies.nonlinearity.mu", numbers({0.1, 0.5}));
             }),
             Contains("0.5 is above the largest"));
  CHECK_THAT(with([](Experiment& e) {
               set_key(e, "studies.nonlinearity.epsilons", numbers({0.25, 1}));
             }),
             Contains("studies.nonlinearity.epsilons: 1 is out of range"));
  CHECK_THAT(with([](Experiment& e) {
               set_key(e, "studies.nonlinearity.overloads", numbers({1, 0.5}));
             }),
             Contains("must ascend"));
  CHECK_THAT(with([](Experiment& e) { set_key(e, "studies.nonlinearity.overloads", numbers({})); }),
             Contains("studies.nonlinearity.overloads: the list is empty"));
  // At an overload of a quarter it takes four times as many: beyond what one seed has.
  CHECK_THAT(with([](Experiment& e) { set_key(e, "studies.nonlinearity.point_samples", std::int64_t{900'000'000}); }),
             Contains("studies.nonlinearity: ") && Contains("samples are too many"));
  CHECK_THAT(with([](Experiment& e) { set_key(e, "studies.nonlinearity.point_samples", std::int64_t{255}); }),
             Contains("whole group of eight"));
  CHECK_THAT(with([](Experiment& e) { set_key(e, "studies.nonlinearity.multiplexed_samples", std::int64_t{8}); }),
             Contains("multiplexed_samples"));
}

TEST_CASE("Laws that could not be compared are refused") {
  const auto with = [](const std::string& name, const KeyValue& value) {
    return problem_after([&](Experiment& e) {
      set_key(e, "studies.law_comparison.samples", std::int64_t{512});
      set_key(e, "studies.law_comparison.response_samples", std::int64_t{512});
      set_key(e, "studies.law_comparison." + name, value);
    });
  };
  CHECK(with("samples", std::int64_t{512}) == "(none)");
  CHECK_THAT(with("samples", std::int64_t{0}), Contains("set both or neither"));
  CHECK_THAT(with("samples", std::int64_t{100}), Contains("whole group of eight"));
  CHECK_THAT(with("mu", 0.61), Contains("take for ever"));
  CHECK_THAT(with("mu", 0.0), Contains("all laws are one"));
  CHECK_THAT(with("columns", std::int64_t{3}), Contains("at least 4"));
  CHECK_THAT(with("layers", std::int64_t{400}), Contains("4096"));
  CHECK_THAT(with("response_samples", std::int64_t{100}), Contains("whole group of eight"));
  CHECK_THAT(with("response_layers", std::int64_t{26}), Contains("give at least 27"));
  CHECK_THAT(with("response_columns", std::int64_t{12}), Contains("not to meet"));
  CHECK_THAT(with("response_columns", std::int64_t{400}), Contains("4096 beads"));
  CHECK_THAT(with("response_burn_in", static_cast<std::int64_t>(most_sweeps) + 1), Contains("sweeps"));
  CHECK(with("cost_mu", numbers({0.1, 0.6})) == "(none)");
  CHECK_THAT(with("cost_mu", numbers({0.1, 0.61})), Contains("takes for ever"));
  CHECK_THAT(with("cost_mu", numbers({0.2, 0.1})), Contains("must ascend"));
  CHECK_THAT(with("cost_sizes", whole_numbers({4, 4})), Contains("twice"));
  CHECK_THAT(with("cost_sizes", whole_numbers({4, 41})), Contains("4 to 40"));
}

TEST_CASE("The thrust under rejection is asked for by itself, where rejection still draws") {
  const auto with = [](std::vector<double> mu, std::int64_t samples) {
    return problem_after([&](Experiment& e) {
      set_key(e, "studies.rejection_thrust.mu", numbers(std::move(mu)));
      set_key(e, "studies.rejection_thrust.samples", samples);
    });
  };
  CHECK(with({0.1, 0.3}, 256) == "(none)");
  CHECK_THAT(with({0.1, 0.31}, 256), Contains("takes for ever"));
  CHECK_THAT(with({0.3, 0.1}, 256), Contains("must ascend"));
  CHECK_THAT(with({0.1}, 100), Contains("whole group of eight"));
}

TEST_CASE("Studies that could not be made are refused before anything is drawn") {
  CHECK(problem_after([](Experiment& e) {
          set_key(e, "studies.redrawn_beads.mu", numbers({0.1, 0.3}));
          set_key(e, "studies.counted_work.mu", numbers({0.0, 1.7}));
          set_key(e, "studies.small_friction.mu", numbers({0.02, 0.1}));
          set_key(e, "studies.chain_share.samples", std::int64_t{512});
        }) == "(none)");
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.redrawn_beads.mu", numbers({0.0, 0.1}));
             }),
             Contains("studies.redrawn_beads.mu: 0") && Contains("nothing is random"));
  CHECK_THAT(problem_after([](Experiment& e) { set_key(e, "studies.small_friction.mu", numbers({-0.1})); }),
             Contains("studies.small_friction.mu: -0.1"));
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.counted_work.mu", numbers({0.3, 0.3}));
             }),
             Contains("twice"));
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.counted_work.sizes", whole_numbers({100, 200}));
             }),
             Contains("studies.counted_work.sizes: 2 values"));
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.counted_work.mu", numbers({0.3}));
               set_key(e, "studies.counted_work.samples", std::int64_t{63});
             }),
             Contains("studies.counted_work.samples: 63 samples in 8 blocks"));
  // 0.6/mu^2 = 6e9 layers at mu = 1e-5: the pile is refused with the memory it would need.
  CHECK_THAT(problem_after([](Experiment& e) { set_key(e, "studies.small_friction.mu", numbers({1e-5})); }),
             Contains("studies.small_friction.mu: ") && Contains("TB of memory"));
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.small_friction.mu", numbers({0.1}));
               set_key(e, "studies.small_friction.depth", not_a_number);
             }),
             Contains("studies.small_friction.depth: "));
  CHECK_THAT(problem_after([](Experiment& e) {
               set_key(e, "studies.chain_share.samples", std::int64_t{512});
               e.force_chains.columns = 60;
             }),
             Contains("scenes.force_chains.columns: with 60 columns the two rays") && Contains("at least 66 columns"));
}
