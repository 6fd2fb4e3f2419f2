#include "experiment/experiment_file.h"

#include <fmt/core.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "ensemble/ensemble_spec.h"
#include "experiment/experiment.h"
#include "experiment/experiment_keys.h"
#include "kit/set_key.h"
#include "kit/temporary_folder.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

std::string refusal_of_file(const std::string& text) {
  try {
    parse_experiment(text, "mine.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

void require_equal(Experiment a, Experiment b) {
  const std::vector<Key> keys = keys_of(a), others = keys_of(b);
  for (std::size_t k = 0; k < keys.size(); ++k) {
    INFO(keys[k].path());
    CHECK(keys[k].get() == others[k].get());
  }
  CHECK(a.expected_verdicts == b.expected_verdicts);
}

/// Every field differs from its default.
Experiment unusual_experiment() {
  Experiment e;
  e.name = "a \"quoted\" name \\ with µ";
  e.description = "two\nlines\tand a tab";
  e.lattice = {801, 333};
  e.mu = {0.0, 1e-5, 1.0 / 3, 0.7, 1.7};
  e.sampling.seed = 9223372036854775807u;
  e.sampling.effort = 1234.5;
  e.sampling.max_tries = 77;
  e.sampling.order = LayerOrder::fixed;
  e.response.overload = 0.25;
  e.response.estimator = EstimatorName::multiplexed;
  e.response.epsilon = 0.125;
  e.response.opposite = true;
  e.response.sign_run = 3;
  e.response.samples = 1001;
  e.response.blocks = 16;
  e.sampling.load_angle = 5.5;
  e.sampling.lean_excess = true;
  e.fit.first_layer = 61;
  e.fit.last_layer = 200;
  e.fit.layer_step = 5;
  e.fit.shallow_layer = 11;
  e.fit.min_identifiable_width = 0.75;
  e.fit.scaling_window = {0.05, 0.35};
  e.fit.other_scaling_windows = {{0.1, 1.0 / 3.0}, {0.2, 0.9}};
  e.precision = {.c = 2e-4, .D = 3e-3, .most_samples = 55555};
  e.claims = {.decisive_chi2 = 36.5, .highest_mu = 1.6, .exponent_tolerance = 0.015};
  e.figures.response_profiles = true;
  e.figures.profile_mu = 0.7;
  e.figures.profile_layers = {40, 90, 222};
  e.figures.transport_with_depth = false;
  e.figures.propagation_against_diffusion = false;
  set_key(e, "studies.redrawn_beads.mu", numbers({0.15, 0.3}));
  set_key(e, "studies.redrawn_beads.samples", std::int64_t{555});
  set_key(e, "studies.counted_work.mu", numbers({0.0, 1.6}));
  set_key(e, "studies.counted_work.sizes", whole_numbers({30, 60, 90, 120}));
  set_key(e, "studies.counted_work.samples", std::int64_t{72});
  set_key(e, "studies.small_friction.mu", numbers({0.05, 0.1}));
  set_key(e, "studies.small_friction.columns", std::int64_t{48});
  set_key(e, "studies.small_friction.depth", 6.5);
  set_key(e, "studies.small_friction.samples", std::int64_t{520});
  set_key(e, "studies.chain_share.samples", std::int64_t{640});
  set_key(e, "studies.chain_share.least_share", 0.6);
  set_key(e, "studies.law_comparison.mu", 0.25);
  set_key(e, "studies.law_comparison.columns", std::int64_t{8});
  set_key(e, "studies.law_comparison.layers", std::int64_t{20});
  set_key(e, "studies.law_comparison.samples", std::int64_t{768});
  set_key(e, "studies.law_comparison.cost_mu", numbers({0.1, 0.2}));
  set_key(e, "studies.law_comparison.cost_sizes", whole_numbers({5, 7}));
  set_key(e, "studies.law_comparison.response_samples", std::int64_t{512});
  set_key(e, "studies.law_comparison.response_columns", std::int64_t{30});
  set_key(e, "studies.law_comparison.response_layers", std::int64_t{28});
  set_key(e, "studies.law_comparison.response_burn_in", std::int64_t{100});
  set_key(e, "studies.law_comparison.response_thinning", std::int64_t{50});
  set_key(e, "studies.rejection_thrust.mu", numbers({0.15, 0.2}));
  set_key(e, "studies.rejection_thrust.samples", std::int64_t{1024});
  set_key(e, "studies.deep_response.mu", numbers({0.1, 0.3}));
  set_key(e, "studies.deep_response.octaves", std::int64_t{3});
  set_key(e, "studies.deep_response.columns", std::int64_t{400});
  set_key(e, "studies.deep_response.samples", std::int64_t{512});
  set_key(e, "studies.numerical_stability.layers", std::int64_t{400});
  set_key(e, "studies.numerical_stability.columns", std::int64_t{24});
  e.sampling.rules = RepairRules::no_arcs;
  e.sampling.drawn = DrawnVariable::ratio;
  set_key(e, "studies.error_against_time.repetitions", std::int64_t{24});
  set_key(e, "studies.error_against_time.mu", 0.25);
  set_key(e, "studies.error_against_time.columns", std::int64_t{300});
  set_key(e, "studies.error_against_time.layers", std::int64_t{150});
  set_key(e, "studies.nonlinearity.mu", numbers({0.1, 0.2}));
  set_key(e, "studies.nonlinearity.epsilons", numbers({0.05, 0.125}));
  set_key(e, "studies.nonlinearity.overloads", numbers({0.5, 2}));
  set_key(e, "studies.nonlinearity.multiplexed_samples", std::int64_t{2048});
  set_key(e, "studies.nonlinearity.point_samples", std::int64_t{4096});
  e.figures.bead_forces = false;
  e.figures.scaling_with_friction = false;
  e.figures.propagation_and_thrust = false;
  e.force_chains.show = false;
  e.force_chains.columns = 48;
  e.force_chains.layers = 33;
  e.force_chains.mu = 0.2;
  e.force_chains.sample = 5;
  e.force_chains.scene.width_px = 999;
  e.force_chains.scene.dpi = 150;
  e.force_chains.scene.colour_map = "viridis";
  e.force_chains.scene.backend = "osmesa";
  e.force_chains.scene.skip_invisible = false;
  e.force_chains.weight = true;
  e.force_chains.friction = true;
  e.force_chains.response = false;
  e.response_field.show = false;
  e.report.pdf = false;
  e.report.headline = "found: \"nothing\"";
  e.report.key_figure = "response-profiles";
  e.report.about = "deep_response";
  e.claims.largest_remainder = 0.1;
  e.expected_verdicts = {{"D-of-mu", "reproduced"}, {"c-of-mu", "not reproduced"}};
  return e;
}

}  // namespace

TEST_CASE("An empty file is the default experiment") { require_equal(parse_experiment("", "x"), Experiment{}); }

TEST_CASE("A printed experiment reads back to an equal one, and prints to the same bytes again") {
  for (const Experiment& written : {Experiment{}, unusual_experiment()}) {
    const std::string text = print_experiment(written);
    const Experiment read = parse_experiment(text, "printed.toml");
    require_equal(read, written);
    CHECK(print_experiment(read) == text);
  }
}

TEST_CASE("The changes of an experiment are its lines that are not the default ones, under their tables") {
  CHECK(print_changes(Experiment{}).empty());
  Experiment changed;
  changed.lattice.columns = 77;
  changed.report.pdf = false;
  changed.expected_verdicts = {{"D-of-mu", "reproduced"}};
  CHECK(print_changes(changed) ==
        "[lattice]\ncolumns = 77\n\n[report]\npdf = false\n\n[gate.expect]\nD-of-mu = \"reproduced\"\n");
}

TEST_CASE("The unusual experiment exercises every key of the main line") {
  // Guards the test above: a key it leaves at its default would not be tested.
  const Experiment unusual = unusual_experiment();
  const Experiment usual;
  Experiment one = unusual, other = usual;
  const std::vector<Key> keys = keys_of(one), others = keys_of(other);
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const Key& key = keys[k];
    if (key.table.starts_with("studies.") || key.table == "scan" || key.table.starts_with("model")) continue;
    if (key.path() == "response.reference_lag" || key.path() == "response.first_base" ||
        key.path() == "response.base_step" || key.path() == "figures.response_profiles.show" ||
        key.path() == "lattice.angle" || key.path() == "sampling.law" || key.path() == "sampling.load_offset" ||
        key.path() == "sampling.bead_weight" || key.path() == "response.estimator" || key.path() == "sampling.lambda" ||
        key.path() == "sampling.burn_in" || key.path() == "sampling.thinning" || key.path() == "response.overloads" ||
        key.path() == "response.coupled") {
      continue;  // its other value would make the rest meaningless or is tested below, or there is no other value
    }
    INFO(key.path());
    CHECK(key.get() != others[k].get());
  }
}

TEST_CASE("The keys of the estimator fluctuation read back as they were printed") {
  Experiment written;
  written.lattice.layers = 500;
  written.response.estimator = EstimatorName::fluctuation;
  written.response.reference_lag = 30;
  written.response.first_base = 70;
  written.response.base_step = 9;
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
}

TEST_CASE("The angle of the contacts reads back as it was printed, and bounds friction, studies and loads") {
  Experiment written;
  written.lattice.angle = 45;
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
  const auto key_of_problem = [&](auto change) {
    Experiment changed = written;
    change(changed);
    const std::vector<KeyProblem> found = find_problems(changed);
    return found.empty() ? std::string() : found.front().key;
  };
  CHECK(key_of_problem([](Experiment&) {}).empty());
  CHECK(key_of_problem([](Experiment& e) { e.mu.push_back(1); }) == "friction.mu");
  CHECK(key_of_problem([](Experiment& e) { e.force_chains.mu = 1; }) == "scenes.force_chains.mu");
  CHECK(key_of_problem([](Experiment& e) { e.sampling.load_angle = 2; }) == "sampling.load_angle");
  CHECK(key_of_problem([](Experiment& e) { e.lattice.angle = 61; }) == "lattice.angle");
  const auto with_study = [&](const std::string& id, double mu) {
    return key_of_problem([&](Experiment& e) {
      for (const auto& study : e.studies) {
        for (const Key& key : study->keys()) {
          if (key.path() == "studies." + id + ".mu") key.set(std::vector<double>{mu});
        }
      }
    });
  };
  CHECK(with_study("deep_response", 0.3) == "studies.deep_response");
  // Of these all formulas take the angle.
  CHECK(with_study("force_statistics", 0.3).empty());
  CHECK(with_study("tensor_response", 0.3).empty());
  CHECK(with_study("tensor_response", 1).starts_with("studies.tensor_response"));  // from 1/tan(45 degrees) on
}

TEST_CASE("The keys of the overloads read back as they were printed") {
  Experiment written;
  written.response.coupled = true;
  written.response.overloads = 2;
  written.mu = {0.1, 0.2, 0.3};
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
  written.response.overloads = 0;
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
}

TEST_CASE("The weight of beads reads back as it was printed, and is refused where layers must be alike") {
  Experiment written;
  written.sampling.bead_weight = 0.1;
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
  written.response.estimator = EstimatorName::fluctuation;
  written.lattice.layers = 500;
  CHECK_THROWS_WITH(parse_experiment(print_experiment(written), "printed.toml"), Contains("beads of weight 0.1"));
}

TEST_CASE("The keys of the law polytope read back as they were printed") {
  Experiment written;
  written.lattice = {64, 44};
  written.mu = {0.0};
  written.sampling.law = Law::polytope;
  written.sampling.lambda = 1.0 / 3;
  written.sampling.burn_in = 1234;
  written.sampling.thinning = 56;
  written.fit.first_layer = 8;
  written.fit.last_layer = 20;
  written.fit.shallow_layer = 4;
  written.figures.response_profiles = false;
  written.force_chains.show = false;
  require_equal(parse_experiment(print_experiment(written), "printed.toml"), written);
}

TEST_CASE("A printed experiment holds every key with its meaning") {
  const std::string text = print_experiment(Experiment{});
  Experiment defaults;
  for (const Key& key : keys_of(defaults)) {
    CHECK_THAT(text, Contains("# " + key.meaning));
    CHECK_THAT(text, Contains("\n" + key.name + " = "));
  }
  CHECK_THAT(text, Contains("\ncolumns = 500\n"));
  CHECK_THAT(text, Contains("\nmu = [0.0, 0.1, 0.2, 0.3]\n"));
}

TEST_CASE("A friction coefficient of minus zero is zero, in numbers, file names and commands") {
  const Experiment e = parse_experiment("[friction]\nmu = [-0.0, 0.1, 0.2, 0.3]\n", "mine.toml");
  CHECK_FALSE(std::signbit(e.mu.front()));
}

TEST_CASE("The reference names every key once, with unit and default") {
  const std::string reference = describe_experiment_keys();
  Experiment defaults;
  for (const Key& key : keys_of(defaults)) {
    const std::string cell = "| `" + key.path() + "` |";
    INFO(cell);
    const auto at = reference.find(cell);
    REQUIRE(at != std::string::npos);
    CHECK(reference.find(cell, at + 1) == std::string::npos);
    CHECK(!key.meaning.empty());
  }
  CHECK_THAT(reference, Contains("| `lattice.columns` | `500` | beads | "));
  // Each example of a study could be run, and asks for it.
  const std::string open = "```toml\n";
  int studies = 0;
  for (auto at = reference.find(open); at != std::string::npos; at = reference.find(open, at + 1)) {
    const std::string example = reference.substr(at + open.size(), reference.find("\n```", at) - at - open.size());
    if (!example.starts_with("[studies.")) continue;
    ++studies;
    INFO(example);
    const std::string heading = example.substr(0, example.find('\n'));
    CHECK_THAT(print_changes(parse_experiment(example + "\n", "example.toml")), Contains(heading));
  }
  CHECK(studies > 10);
}

TEST_CASE("What is wrong in two studies is told at once") {
  std::string told;
  try {
    parse_experiment(
        "[studies.force_statistics]\nmu = [0.3]\nsamples = 8\n[studies.redrawn_beads]\nmu = [0.3]\nsamples = 8\n",
        "mine.toml");
  } catch (const InputError& error) {
    told = error.what();
  }
  CHECK_THAT(told, Contains("studies.force_statistics.samples") && Contains("studies.redrawn_beads.samples"));
}

namespace {

/// Sets a key to a value that it can take and does not have.
void change(const Key& key) {
  struct Changer {
    std::vector<KeyValue> operator()(bool on) const { return {!on}; }
    std::vector<KeyValue> operator()(std::int64_t number) const { return {number + 1}; }
    std::vector<KeyValue> operator()(double number) const { return {number + 0.125}; }
    std::vector<KeyValue> operator()(const std::string& text) const {
      return {"rejection", "eloy-clement", "multiplexed", "point",    "fixed",    "no-pair", "osmesa",
              "q-model",   "critical",     "free",        "positive", "gaussian", "angle",   text + "x"};
    }
    std::vector<KeyValue> operator()(std::vector<std::int64_t> list) const {
      list.push_back(7);
      return {list};
    }
    std::vector<KeyValue> operator()(std::vector<double> list) const {
      std::vector<double> longer = list;
      longer.push_back(0.75);
      if (!list.empty()) list.back() += 0.125;
      return {longer, list};  // a window has two ends
    }
    std::vector<KeyValue> operator()(NumberPairs list) const {
      list.push_back({0.25, 0.5});
      return {list};
    }
  };
  const KeyValue before = key.get();
  for (const KeyValue& other : std::visit(Changer{}, before)) {
    try {
      key.set(other);
      if (key.get() != before) return;
    } catch (const InputError&) {  // a name of another key
    }
  }
  FAIL(key.path() << " has no other value");
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("Every key that is changed is seen in the resolved experiment, and where it matters in what is drawn") {
  Experiment defaults;
  const std::size_t count = keys_of(defaults).size();
  std::size_t read_back = 0;
  for (std::size_t k = 0; k < count; ++k) {
    std::size_t other_draws = 0;
    std::string table, path;
    // What it takes for some keys to matter.
    for (const Law law : {Law::granusolve, Law::rejection, Law::polytope}) {
      for (const EstimatorName estimator :
           {EstimatorName::point, EstimatorName::multiplexed, EstimatorName::fluctuation}) {
        Experiment e;
        e.sampling.law = law;
        e.response.estimator = estimator;
        const auto drawn = [&e] {
          EnsembleSpec spec = e.ensemble_at(0.3, e.lattice, e.response.samples);
          spec.sampler.model = e.sampling.model;
          spec.response = e.response;
          return configuration_text(spec);
        };
        const std::string before = drawn();
        const Key key = keys_of(e)[k];
        table = key.table, path = key.path();
        INFO(path);
        const std::vector<std::string> lines = lines_of(print_experiment(e));
        change(key);
        const std::vector<std::string> changed = lines_of(print_experiment(e));
        REQUIRE(changed.size() == lines.size());
        std::size_t differing = 0;
        for (std::size_t i = 0; i < lines.size(); ++i) {
          if (changed[i] == lines[i]) continue;
          ++differing;
          CHECK_THAT(changed[i], StartsWith(key.name + " = "));
        }
        CHECK(differing == 1);
        if (drawn() != before) ++other_draws;
        if (!find_problems(e).empty() || path == "scan.values") continue;  // not by itself; of friction, mu has these
        require_equal(parse_experiment(print_experiment(e), "printed.toml"), e);
        ++read_back;
      }
    }
    INFO(path);
    if (table.starts_with("model.")) continue;  // each matters to its own model: model_run_test, row_models_test
    const bool drawn_by = table == "lattice" || table == "model" || table == "sampling" || table == "response";
    CHECK((other_draws > 0) == drawn_by);
  }
  CHECK(count > 80);
  CHECK(read_back > count / 2);
}

TEST_CASE("Pictures have names of their own, read back as printed, and are refused before there is a pile") {
  const std::string head = "[scenes.force_chains]\ncolumns = 40\nlayers = 20\n[scenes.pictures.left-edge]\n";
  const Experiment read =
      parse_experiment(head +
                           "scene = \"friction\"\nwindow = [-20, -5, 0, 9]\nrange = [0, 0.5]\nwidth_px = 900\n"
                           "[scenes.pictures.plain]\n",
                       "x");
  REQUIRE(read.pictures.size() == 2);
  CHECK(read.pictures.at("left-edge").scene == "friction");
  CHECK(read.pictures.at("left-edge").window == std::vector<double>{-20, -5, 0, 9});
  CHECK(read.pictures.at("plain").scene == "forces");
  const std::string printed = print_experiment(read);
  CHECK(print_experiment(parse_experiment(printed, "y")) == printed);
  CHECK_THAT(describe_experiment_keys(), Catch::Contains("`scenes.pictures.<name>.range`"));

  const auto refused = [&](const std::string& line, const std::string& reason) {
    CAPTURE(line);
    CHECK_THROWS_WITH(parse_experiment(head + line + "\n", "x"), Catch::Contains(reason));
  };
  refused("scene = \"chains\"", "no scene 'chains'");
  refused("window = [0, 1]", "four numbers");
  refused("window = [-21, 0, 0, 5]", "around the ring");
  refused("window = [-5, 5, 0, 60]", "layers that the pile does not have");
  refused("range = [1, 1]", "empty");
  refused("scene = \"response\"\nrange = [0, 1]", "symmetric");
  refused("scene = \"response\"\ncolour_map = \"grey\"", "both signs");
  refused("width_px = 0", "0 pixels");
  refused("width_px = 1000000", "1000000 pixels");
  refused("rnage = [0, 1]", "did you mean scenes.pictures.left-edge.range");
  refused("[scenes.pictures.\"a/b\"]", "letters, digits");
  refused("[scenes.force_chains.x]", "unknown key");
  CHECK_THROWS_WITH(parse_experiment("[scenes.pictures]\na = 1\n", "x"), Catch::Contains("must be a table"));
  CHECK_THROWS_WITH(parse_experiment("[scenes.force_chains]\nmu = 0\n[scenes.pictures.a]\nscene = \"friction\"\n", "x"),
                    Catch::Contains("mobilised"));
}

TEST_CASE("Lists are sorted when read, numbers may be written whole") {
  const Experiment e = parse_experiment("[friction]\nmu = [0.3, 0, 1]\n[response]\noverload = 2\n", "x");
  CHECK(e.mu == std::vector<double>{0, 0.3, 1});
  CHECK(e.response.overload == 2);
  CHECK(parse_experiment("figures.response_profiles.layers = [170, 20]", "x").figures.profile_layers ==
        std::vector<int>{20, 170});
}

TEST_CASE("An unknown key is refused with file, line, column and the nearest known key") {
  CHECK(refusal_of_file("[lattice]\ncolumns = 500\nlayer = 200\n") ==
        "mine.toml:3:1: unknown key lattice.layer: a mistyped key would silently keep its default; did you mean "
        "lattice.layers?");
  CHECK_THAT(refusal_of_file("[latice]\ncolumns = 500\n"),
             StartsWith("mine.toml:1:2: ") && Contains("did you mean lattice?"));
  // The right key in the wrong table.
  CHECK_THAT(refusal_of_file("[response]\nseed = 3\n"), Contains("did you mean sampling.seed?"));
  CHECK_THAT(refusal_of_file("[figures.response_profile]\nmu = 0.3\n"),
             Contains("did you mean figures.response_profiles?"));
  CHECK_THAT(refusal_of_file("[lattice]\nqqqqqqqqqqq = 3\n"), Contains("[lattice] knows angle, columns, layers"));
  CHECK_THAT(refusal_of_file("zzzzzzzzzzzzzzz = 3\n"), Contains("the tables are claims, experiment,"));
  CHECK_THAT(refusal_of_file("seed = 3\n"), Contains("did you mean sampling.seed?"));
  // Where several tables have it, the one that is meant most often.
  CHECK_THAT(refusal_of_file("columns = 60\n"), Contains("did you mean lattice.columns?"));
  CHECK_THAT(refusal_of_file("[experiment]\nsamples = 60\n"), Contains("did you mean response.samples?"));
  CHECK_THAT(refusal_of_file("mu = [0.1]\n"), Contains("did you mean friction.mu?"));
  CHECK_THAT(refusal_of_file("\"" + std::string(5000, 'k') + "\" = 3\n"), Contains("unknown key"));
}

TEST_CASE("A value of the wrong type is refused with what is expected") {
  CHECK(refusal_of_file("[lattice]\n  columns = 500.5\n") ==
        "mine.toml:2:3: lattice.columns must be a whole number but is the number 500.5; write columns = 500, "
        "for example: beads per layer, "
        "periodic in x; even or odd (4 to 1000000)");
  // What was written is shown, and its value where that is plain.
  for (const auto& [written, told] : std::vector<std::pair<std::string, std::string>>{
           {"[lattice]\ncolumns = \"640\"", "whole number but is the string \"640\"; write columns = 640: beads"},
           {"[lattice]\ncolumns = [640]", "is the list [640]; write columns = 640: "},
           {"[lattice]\ncolumns = \"6,4\"", "(there is a comma in it; write digits alone); write columns = 500, for"},
           {"[lattice]\ncolumns = \"1e3\"", "write columns = 1000: "},
           {"[response]\noverload = \"0,5\"", "there is a decimal comma in it; write a point); write overload = 0.5: "},
           {"[friction]\nmu = \"0.3\"", "write mu = [0.3]: "},
           {"[friction]\nmu = \"0.1, 0.3\"", "write mu = [0.1, 0.3]: "},
           {"[friction]\nmu = [0.3, \"0.4\"]", "is the list [0.3, \"0.4\"]; write mu = [0.3, 0.4]: "},
           {"[friction]\nmu = true", "a list of numbers but is true; write mu = [0.0, 0.1, 0.2, 0.3], for example: "},
           {"[friction]\nmu = 2024-01-01", "but is 2024-01-01; write mu = [0.0, 0.1, 0.2, 0.3], for example: "},
           {"[report]\npdf = \"Yes\"", "write pdf = true: "},
           {"[report]\npdf = 0", "but is the number 0; write pdf = false: "},
           {"[experiment]\nname = 5", "write name = \"5\": "},
           {"[lattice]\ncolumns = \"5\\n[x]\"", "write columns = 500, for example: "}}) {
    INFO(written);
    CHECK_THAT(refusal_of_file(written + "\n"), Contains(told));
  }
  CHECK_THAT(refusal_of_file("lattice = 3\n"),
             Contains("lattice must be a table but is the number 3; write [lattice]"));
  CHECK_THAT(refusal_of_file("[[lattice]]\ncolumns = 3\n"), Contains("lattice must be a table"));
  CHECK_THAT(refusal_of_file("[lattice.columns]\nx = 3\n"), Contains("must be a whole number but is a table"));
  CHECK_THAT(refusal_of_file("[report]\npdf = 1\n"), Contains("must be true or false"));
  CHECK_THAT(refusal_of_file("[gate.expect]\nD-of-mu = 1\n"), Contains("gate.expect.D-of-mu must be a string"));
  CHECK_THAT(refusal_of_file("[fit]\nother_scaling_windows = [0.1, 0.3, 0.5]\n"),
             Contains("a list of pairs of numbers"));
  CHECK_THAT(refusal_of_file("[fit]\nscaling_window = [0.1, 0.2, 0.3]\n"), Contains("two ends, not 3 numbers"));
  CHECK_THAT(refusal_of_file("[sampling]\nlaw = \"granulosve\"\n"), StartsWith("mine.toml:2:1: sampling.law: "));
  CHECK_THAT(refusal_of_file("[response]\nestimator = \"pont\"\n"), StartsWith("mine.toml:2:1: response.estimator: "));
  CHECK_THAT(refusal_of_file("[sampling]\nlayer_order = \"left\"\n"), Contains("random, rightwards and fixed"));
  CHECK_THAT(refusal_of_file("[sampling]\nseed = -1\n"), Contains("-1 is out of range; give at least 0"));
  CHECK_THAT(refusal_of_file("[lattice]\ncolumns = 5000000000\n"), Contains("give 4 to 1000000"));
}

TEST_CASE("A whole number may be written with a point or an exponent") {
  CHECK(parse_experiment("[response]\nsamples = 1e3\n[lattice]\ncolumns = 600.0\n", "mine.toml").response.samples ==
        1000);
  CHECK(parse_experiment("[lattice]\ncolumns = 6.0e2\n", "mine.toml").lattice.columns == 600);
  CHECK(parse_experiment("[figures.response_profiles]\nlayers = [2e1, 30.0]\n", "mine.toml").figures.profile_layers ==
        std::vector<int>{20, 30});
  // Sums of 0.1 as they are printed elsewhere; what was measured keeps all its digits.
  CHECK(parse_experiment("[friction]\nmu = [0.1, 0.30000000000000004, 0.7999999999999999]\n", "mine.toml").mu ==
        std::vector<double>{0.1, 0.3, 0.8});
  CHECK(parse_experiment("[friction]\nmu = 0.30000000000001\n", "mine.toml").mu[0] == 0.30000000000001);
  CHECK(parse_experiment("[friction]\nmu = 0.12345678901234568\n", "mine.toml").mu[0] == 0.12345678901234568);
  // Behind --set as behind --mu; one comma alone may be a decimal one.
  CHECK(parse_experiment("[friction]\nmu = 0\n", "x", {"friction.mu=0.2,0.3"}).mu == std::vector<double>{0.2, 0.3});
  CHECK_THROWS_AS(parse_experiment("[friction]\nmu = 0\n", "x", {"friction.mu=0,3"}), InputError);
  CHECK_THAT(refusal_of_file("[response]\nsamples = 1e30\n"), Contains("must be a whole number"));
  CHECK_THAT(refusal_of_file("[response]\nsamples = inf\n"), Contains("must be a whole number"));
}

TEST_CASE("Encodings and signs that TOML does not know are named") {
  CHECK_THAT(refusal_of_file(std::string("\xff\xfe[\0l\0", 6)), Contains("UTF-16"));
  CHECK_THAT(refusal_of_file(std::string("[\0l\0a\0", 6)), Contains("UTF-16"));
  CHECK_THAT(refusal_of_file("[experiment]\nname = \"M\xfcller\"\n"), Contains("Latin-1") && Contains("UTF-8"));
  CHECK_THAT(refusal_of_file("[experiment]\nname = \"Müller\"\n[sampling]\nload_angle = −3\n"),
             StartsWith("mine.toml:4:") && Contains("U+2212"));
  CHECK_THAT(refusal_of_file("[sampling]\nbead_weight = 0,3\n"), Contains("decimal comma"));
  CHECK_THAT(refusal_of_file("[sampling]\nbead_weight = \"0,3\"\n"), Contains("decimal comma"));
  CHECK_THAT(refusal_of_file("[lattice\n"), !Contains("comma") && !Contains("UTF"));
}

TEST_CASE("Text that is not TOML is refused with its place") {
  CHECK_THAT(refusal_of_file("[lattice\ncolumns = 500\n"), StartsWith("mine.toml:1:") && Contains("not valid TOML"));
  CHECK_THAT(refusal_of_file("[lattice]\ncolumns = 500\ncolumns = 600\n"), StartsWith("mine.toml:3:"));
  CHECK_THAT(refusal_of_file("[lattice]\nlayers = \xff\xfe\n"),
             StartsWith("mine.toml:2:") && Contains("not valid TOML"));
  CHECK_THAT(refusal_of_file("[experiment]\nname = \"\xc3\x28\"\n"), Contains("not valid TOML"));
  CHECK_THAT(refusal_of_file("[sampling]\nseed = 99999999999999999999\n"), Contains("not valid TOML"));
  CHECK_THAT(refusal_of_file("a = " + std::string(100'000, '[')), Contains("not valid TOML"));
  CHECK_THAT(refusal_of_file(std::string(2'000'000, '#')), Contains("more than 1000000 bytes are too many"));
}

TEST_CASE("What is no readable file is refused") {
  const test::TemporaryFolder scratch;
  CHECK_THROWS_WITH(read_experiment(scratch / "missing.toml"), Contains("no such file"));
  CHECK_THROWS_WITH(read_experiment(scratch.path()), Contains("this is a folder"));
  CHECK_THROWS_WITH(read_experiment("/dev/zero"), Contains("not a plain file"));
  std::ofstream(scratch / "huge.toml") << std::string(3'000'000, ' ');
  CHECK_THROWS_WITH(read_experiment(scratch / "huge.toml"), Contains("too many"));
  std::ofstream(scratch / "good.toml") << "[lattice]\ncolumns = 600\n";
  CHECK(read_experiment(scratch / "good.toml").lattice.columns == 600);
}

TEST_CASE("Every example can be read") {
  std::size_t examples = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(GRANUSCOPE_SOURCE_DIR) / "examples")) {
    if (entry.path().extension() != ".toml") continue;
    ++examples;
    INFO(entry.path());
    CHECK_NOTHROW(read_experiment(entry.path()));
  }
  CHECK(examples >= 1);
}

TEST_CASE("A character that no key can begin with is an error of the file in every build") {
  for (const char* text :
       {"[\\x]\n", "[figures.\\x]\n", "[[\\x]]\n", "a.\\x = 1\n", "\\x = 1\n", "\u00e9 = 1\n", "a.\u00b5 = 1\n"}) {
    CAPTURE(text);
    CHECK_THROWS_WITH(parse_experiment(text, "x.toml"), Contains("x.toml:1:") && Contains("not valid TOML"));
  }
}
