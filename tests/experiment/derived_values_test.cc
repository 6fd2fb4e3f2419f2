#include "experiment/derived_values.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

std::string refusal_of_values(const std::string& text) {
  try {
    parse_experiment(text, "x.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

int depths_of(const FitSpec& fit) { return (fit.last_layer - fit.first_layer) / fit.layer_step + 1; }

}  // namespace

TEST_CASE("Where nothing is written the defaults come out") {
  const Experiment derived = parse_experiment("", "x.toml");
  CHECK(print_experiment(derived) == print_experiment(Experiment{}));
}

TEST_CASE("What is derived reads back as it is") {
  const Experiment derived = parse_experiment("[lattice]\nlayers = 120\n[friction]\nmu = 0.25\n", "x.toml");
  const std::string text = print_experiment(derived);
  CHECK(print_experiment(parse_experiment(text, "y.toml")) == text);
}

TEST_CASE("One line is an experiment, with brackets or without") {
  for (const char* mu : {"0.25", "[0.25]"}) {
    const Experiment e = parse_experiment(fmt::format("[friction]\nmu = {}\n", mu), "x.toml");
    CHECK(e.mu == std::vector<double>{0.25});
    CHECK(e.figures.profile_mu == 0.25);
    CHECK(e.force_chains.mu == 0.25);
  }
  CHECK(parse_experiment("[fit]\nother_scaling_windows = [0.1, 0.4]\n", "x.toml").fit.other_scaling_windows ==
        std::vector<std::array<double, 2>>{{0.1, 0.4}});
  CHECK(parse_experiment("[figures.response_profiles]\nlayers = 100\n", "x.toml").figures.profile_layers ==
        std::vector<int>{100});
}

TEST_CASE("Every friction, size, estimator and model runs, or says in one message why it cannot") {
  const std::vector<std::string> frictions = {"0.25", "[0.2, 0.4]", "[0.1, 0.2, 0.3]", "[0, 0.05, 0.1, 0.3, 0.6, 1.2]",
                                              "0"};
  const std::vector<std::string> sizes = {"layers = 40", "layers = 120", "layers = 500", "layers = 2000\ncolumns = 64",
                                          "columns = 40"};
  const std::vector<std::string> estimators = {"point", "paired", "multiplexed", "fluctuation"};
  const std::vector<std::string> models = {"frictional-beads", "q-model", "three-leg", "stochastic-osl",
                                           "diluted-beads"};
  int accepted = 0, refused = 0;
  for (const std::string& model : models) {
    for (const std::string& estimator : estimators) {
      for (const std::string& size : sizes) {
        for (const std::string& mu : frictions) {
          const std::string text = fmt::format(
              "[model]\nname = \"{}\"\n[response]\nestimator = \"{}\"\n[lattice]\n{}\n[friction]\nmu = {}\n", model,
              estimator, size, mu);
          CAPTURE(text);
          try {
            const Experiment e = parse_experiment(text, "x.toml");
            CHECK(find_problems(e).empty());
            CHECK(depths_of(e.fit) >= least_window_depths);
            CHECK(e.fit.last_layer < e.lattice.layers);
            CHECK((!e.sampling.model.has_contacts() || std::ranges::count(e.mu, e.force_chains.mu) == 1));
            ++accepted;
          } catch (const InputError& error) {
            ++refused;
            CHECK(error.messages().size() == 1);
            const bool deep_enough = estimator != "fluctuation" || size.find("2000") != std::string::npos;
            // The models without a split, the piles solved as a whole, and layers that are too few to fluctuate.
            CHECK_THAT(error.what(), (Contains("x.toml:4:1: response.estimator: ") && Contains(model)) ||
                                         (Contains("x.toml:6:1: lattice.layers: ") && Contains("too few")) ||
                                         (Contains("lattice.") && Contains("opened contacts")) ||
                                         (Contains("lattice.columns: ") && Contains("meet behind the ring")) ||
                                         (Contains(":1: friction.mu: ") && Contains("give one")));
            CHECK((model != "frictional-beads" || !deep_enough));
          }
        }
      }
    }
  }
  INFO(accepted << " accepted, " << refused << " refused");
  CHECK(accepted > 300);
}

TEST_CASE("Laws of small piles get piles that they can complete") {
  const Experiment e = parse_experiment("[sampling]\nlaw = \"polytope\"\n", "x.toml");
  CHECK(e.lattice.columns * e.lattice.layers <= 4096);
  CHECK(e.force_chains.columns * e.force_chains.computed_layers() <= 4096);
  CHECK_THAT(refusal_of_values("[sampling]\nlaw = \"rejection\"\n"),
             Contains("x.toml:2:1: sampling.law: ") && Contains("256"));
}

TEST_CASE("Windows and figures follow the layers") {
  const Experiment shallow = parse_experiment("[lattice]\nlayers = 120\n", "x.toml");
  CHECK(shallow.fit.last_layer == 99);
  CHECK(shallow.fit.first_layer == 32);
  CHECK(shallow.figures.profile_layers == std::vector<int>{61, 94});
  const Experiment deep = parse_experiment("[lattice]\nlayers = 2000\n", "x.toml");
  CHECK(deep.fit.last_layer == 1979);
  CHECK(deep.fit.layer_step % 2 == 1);
  CHECK(depths_of(deep.fit) < 60);
  CHECK(deep.lattice.columns > 2000);
  const Experiment by_window = parse_experiment("[fit]\nlast_layer = 300\n", "x.toml");
  CHECK(by_window.lattice.layers == 321);
  const Experiment narrow = parse_experiment("[lattice]\ncolumns = 100\n", "x.toml");
  CHECK(narrow.fit.last_layer < 100);
  CHECK(narrow.lattice.layers == narrow.fit.last_layer + 21);
  const Experiment of_friction = parse_experiment("[friction]\nmu = [0.4, 0.6, 0.8, 1]\n", "x.toml");
  CHECK(of_friction.fit.scaling_window == std::array{0.4, 1.0});
  CHECK(of_friction.figures.profile_mu == 0.4);
}

TEST_CASE("A window that the columns end is told with those that would hold it") {
  const std::string narrow = "[lattice]\nlayers = 60\ncolumns = ";
  const Experiment cut = parse_experiment(narrow + "40\n", "x.toml");
  REQUIRE(cut.fit.last_layer < 39);
  const std::string note = note_of_short_window(cut);
  CHECK_THAT(note, Contains(fmt::format("ends at layer {} of 39", cut.fit.last_layer)));
  const std::size_t told = note.find("columns, and ") + 13;
  const std::string enough = note.substr(told, note.find(' ', told) - told);
  const Experiment whole = parse_experiment(narrow + enough + "\n", "x.toml");
  CHECK(whole.fit.last_layer == 39);
  CHECK(note_of_short_window(whole).empty());
  CHECK(parse_experiment(narrow + std::to_string(std::stoi(enough) - 1) + "\n", "x.toml").fit.last_layer == 38);
  CHECK(note_of_short_window(parse_experiment("[fit]\nlast_layer = 60\n", "x.toml")).empty());
  CHECK_THAT(note_of_short_window(parse_experiment("[lattice]\nlayers = 30\n", "x.toml")),
             Contains("to 9, where peaks are hardly wider") && Contains("give more lattice.layers."));
  const std::string saturated = "friction.mu = 0.01\nlattice.layers = 2049\nresponse.estimator = \"fluctuation\"\n";
  CHECK_THAT(note_of_short_window(parse_experiment(saturated, "x.toml")), Contains("or a smaller response.first_base"));
}

TEST_CASE("Samples and blocks follow each other") {
  const std::string deep = "[studies.deep_response]\nmu = 0.3\nsamples = ";
  CHECK(parse_experiment(deep + "64\n", "x.toml").response.blocks == 8);
  CHECK(parse_experiment(deep + "512\n", "x.toml").response.blocks == 32);
  CHECK_THROWS_WITH(parse_experiment(deep + "63\n", "x.toml"), Contains("63 samples in 8 blocks"));
  CHECK_THROWS_WITH(parse_experiment(deep + "64\n[response]\nblocks = 32\n", "x.toml"), Contains("in 32 blocks"));
  CHECK(parse_experiment("[response]\nblocks = 1000\n", "x.toml").response.samples == 8000);
  CHECK(parse_experiment("[response]\nsamples = 100\n", "x.toml").response.blocks == 12);
  // Loads beside the centres are held against the experiment's own friction.
  CHECK(refusal_of_values("[friction]\nmu = 0.3\n[sampling]\nload_offset = 0.2\n") == "(accepted)");
  CHECK_THAT(refusal_of_values("[friction]\nmu = 0.1\n[sampling]\nload_offset = 0.2\n"), Contains("at mu = 0.1"));
  CHECK_THAT(refusal_of_values("[friction]\nmu = [0,3]\n"),
             Contains("3 is out of range") && Contains("0.3 has a point"));
  CHECK_THAT(refusal_of_values("[sampling]\nmodel = \"q-model\"\n"), Contains("did you mean model.name?"));
  CHECK_THAT(refusal_of_values("\x89HDF\r\n"), Contains("this is an HDF5 file"));
  const std::string weight = "[friction]\nmu = 0.3\n[scan]\nparameter = \"bead_weight\"\nvalues = [0.1, 0.5]\n";
  CHECK(parse_experiment(weight, "x.toml").fit.scaling_window == std::array{0.1, 0.5});
  CHECK_THAT(refusal_of_values("[response]\nsamples = 50\n"), Contains("x.toml:2:1: response.samples: "));
  CHECK(parse_experiment("[response]\nsamples = 200000\n[precision]\nc = 1e-4\n", "x.toml").precision.most_samples ==
        200000);
  CHECK(refusal_of_values("[response]\nblocks = 500\n[studies.chain_share]\nsamples = 8000\n") == "(accepted)");
}

TEST_CASE("Keys of beads are told to change nothing under a model without friction") {
  const std::string keys = "[friction]\nmu = [0.2]\n[sampling]\neffort = 5\n";
  CHECK_THAT(note_of_idle_keys(parse_experiment(keys + "[model]\nname = \"q-model\"\n", "x.toml")),
             Contains("\"q-model\"") && Contains(": friction.mu, sampling.effort."));
  CHECK(note_of_idle_keys(parse_experiment("[model]\nname = \"three-leg\"\n", "x.toml")).empty());
  for (const char* model : {"frictional-beads", "diluted-beads"})
    CHECK(
        note_of_idle_keys(parse_experiment(fmt::format("{}[model]\nname = \"{}\"\n", keys, model), "x.toml")).empty());
}

TEST_CASE("What is wrong in a file is told at once, in its order") {
  try {
    parse_experiment(
        "[friction]\nmu = [0.3, 2.0]\n[response]\nsampels = 512\noverload = \"much\"\n[fit]\nlayer_step = 0\n",
        "x.toml", {"report.pfd=false"});
    FAIL("accepted");
  } catch (const InputError& error) {
    const std::vector<std::string>& all = error.messages();
    REQUIRE(all.size() == 5);
    CHECK_THAT(all[0], Contains("x.toml:2:1: friction.mu: 2 is out of range"));
    CHECK_THAT(all[1], Contains("x.toml:4:1: unknown key response.sampels") && Contains("response.samples?"));
    CHECK_THAT(all[2], Contains("x.toml:5:1: response.overload must be a number but is the string"));
    CHECK_THAT(all[3], Contains("x.toml:7:1: fit.layer_step: 0 is out of range"));
    CHECK_THAT(all[4], Contains("--set report.pfd=false: unknown key report.pfd"));
  }
  // Rules across keys that are in range do not wait for the others; those that hang on the others do.
  const std::string across = refusal_of_values(
      "[lattice]\ncolumns = 64\nlayers = 100\n[response]\nsamples = 3\n"
      "[fit]\nmin_identifiable_width = -1\nfirst_layer = 40\nlast_layer = 30\n"
      "[figures.response_profiles]\nmu = 0.7\nlayers = [99]\n[scenes.force_chains]\nmu = \"x\"\nwidth_px = 100\n");
  for (const char* told : {"response.samples: 3", "fit.min_identifiable_width: -1", "scenes.force_chains.mu must be",
                           "fit.first_layer: ", "response_profiles.layers: layer 99", "force_chains.width_px: "})
    CHECK_THAT(across, Contains(told));
  CHECK_THAT(refusal_of_values("[response]\nestimator = \"multiplexd\"\nsign_run = 2\n"), !Contains("sign_run"));
  const std::string many_bad = refusal_of_values("[lattice]\nlayers = 5\n[fit]\nfirst_layer = 40\nlast_layer = 90\n");
  CHECK_THAT(many_bad, Contains("lattice.layers: 5") && !Contains("fit."));
  std::string many = "[lattice]\n";
  for (int k = 0; k < 50; ++k) many += fmt::format("key_{} = 1\n", k);
  CHECK_THAT(refusal_of_values(many), Contains("30 more things are wrong"));
}

TEST_CASE("An experiment without a name has that of its file") {
  const test::TemporaryFolder scratch;
  const auto file = scratch / "soft sand.toml";
  write_file(file, "[friction]\nmu = 0.3\n");
  CHECK(read_experiment(file).name == "soft sand");
  write_file(scratch / " .toml", "[friction]\nmu = 0.3\n");
  CHECK(read_experiment(scratch / " .toml").name == "experiment");
  CHECK(read_experiment(file, {"experiment.name=other"}).name == "other");
}

TEST_CASE("What a refusal advises is accepted, and a default is never its reason") {
  const std::string shallow = "[friction]\nmu = [0.2, 0.3]\n[lattice]\nlayers = 60\n";
  CHECK_THAT(refusal_of_values(shallow + "columns = 200\n[response]\noverloads = 4\n"),
             Contains("response.overloads: 4 overloads on 200 columns: down to layer 39 they need 416 columns") &&
                 Contains("give 0 for as many as fit, or lattice.columns = 416"));
  CHECK(refusal_of_values(shallow + "columns = 416\n[response]\noverloads = 4\n") == "(accepted)");
  CHECK(refusal_of_values(shallow + "columns = 200\n[response]\noverloads = 0\n") == "(accepted)");
  CHECK(parse_experiment("[response]\noverloads = 3\n", "x.toml").lattice.columns % 3 == 0);
  CHECK_THAT(refusal_of_values("[response]\nsamples = -5\n"), Contains("give 64 to 1000000000"));
  CHECK(refusal_of_values("[response]\nsamples = 64\n") == "(accepted)");
  const std::string studies = "[studies.small_friction]\nmu = [0.2, 0.3]\n";
  CHECK(parse_experiment("[friction]\nmu = []\n" + studies, "x.toml").mu == std::vector<double>{0});
  CHECK_THAT(refusal_of_values("[friction]\nmu = []\n"), Contains("friction.mu: the list is empty"));
}

TEST_CASE("What is wrong with report and gate is told at once") {
  const std::string all = refusal_of_values(
      "[report]\nabout = \"nonsense\"\nkey_figure = \"dispersoin\"\n[gate.expect]\nfoo = \"reproduced\"\nnoise = "
      "\"maybe\"\n");
  CHECK_THAT(all, Contains("x.toml:2:1: report.about: ") && Contains("x.toml:3:1: report.key_figure: ") &&
                      Contains("did you mean dispersion?") && Contains("x.toml:5:1: gate.expect.foo: ") &&
                      Contains("x.toml:6:1: gate.expect.noise: "));
}

TEST_CASE("A window that says where it begins goes as deep as the piles allow") {
  for (const int first : {60, 100}) {
    const Experiment one = parse_experiment(fmt::format("[fit]\nfirst_layer = {}\n", first), "x.toml");
    INFO(first << " to " << one.fit.last_layer << " of " << one.lattice.layers);
    CHECK(one.fit.last_layer >= 179);
    CHECK(one.fit.last_layer - first >= 70);
  }
  const Experiment deep = parse_experiment("[fit]\nfirst_layer = 180\n", "x.toml");
  CHECK(deep.fit.last_layer > 300);
  CHECK(deep.lattice.layers == deep.fit.last_layer + 21);
}

TEST_CASE(
    "Rules across keys are told together, whichever of them the fit breaks, and a scan of friction keeps its range") {
  const auto messages_of = [](const char* text) -> std::vector<std::string> {
    try {
      (void)parse_experiment(text, "x.toml");
    } catch (const InputError& error) {
      return error.messages();
    }
    return {};
  };
  const auto all = messages_of(
      "[lattice]\nlayers = 120\n[friction]\nmu = [0.1, 0.2, 0.3]\n[fit]\nlast_layer = 119\n"
      "[figures.response_profiles]\nmu = 0.5\nlayers = [110]\n");
  REQUIRE(all.size() == 3);
  const std::string joined = fmt::format("{}", fmt::join(all, "\n"));
  for (const char* key : {"fit.last_layer", "figures.response_profiles.mu", "figures.response_profiles.layers"})
    CHECK_THAT(joined, Contains(key));
  const auto scan = messages_of("[scan]\nvalues = [1, 2]\n");
  REQUIRE_FALSE(scan.empty());
  CHECK_THAT(scan.front(), Contains("x.toml:2") && Contains("friction.mu: 2 is out of range") && Contains("1.732"));
}
