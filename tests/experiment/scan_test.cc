#include <catch2/catch.hpp>
#include <string>

#include "experiment/experiment_file.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

const std::string small = R"(
[lattice]
columns = 200
layers = 80
[fit]
first_layer = 20
last_layer = 50
shallow_layer = 10
[figures.response_profiles]
layers = [30, 50]
[response]
)";

Experiment with(const std::string& text) {
  return parse_experiment(small + "estimator = \"multiplexed\"\n" + text, "model.toml");
}

}  // namespace

TEST_CASE("friction.mu is the short form of a scan of mu") {
  const Experiment scanned = with("[scan]\nparameter = \"mu\"\nvalues = [0.3, 0.1]\n");
  CHECK(scanned.mu == std::vector{0.1, 0.3});
  CHECK(print_experiment(scanned) == print_experiment(with("[friction]\nmu = [0.1, 0.3]\n")));
  CHECK(print_experiment(scanned) == print_experiment(with("[scan]\nvalues = [0.1, 0.3]\n")));
  CHECK(&scanned.scanned() == &friction_parameter());
  CHECK(scanned.scan_values() == scanned.mu);
}

TEST_CASE("A scan varies one number of the model and leaves the others") {
  const Experiment e = with(R"(
[model]
name = "three-leg"
[model.three_leg]
law = "clipped"
noise = 0.02
[scan]
values = [0.05, 0.1, 0.4]
)");
  CHECK(std::string(e.scanned().name) == "middle");
  const SamplerSpec sampler = e.sampler_at(0.4);
  CHECK(sampler.model.three_leg.middle == 0.4);
  CHECK(sampler.model.three_leg.noise == 0.02);
  CHECK(e.scanned().at(sampler) == "p = 0.4");
  // What figures of one value show: the last, where the default friction is no value.
  CHECK(e.shown_value(0.3) == 0.4);
  CHECK(e.shown_value(0.1) == 0.1);
  CHECK(print_experiment(parse_experiment(print_experiment(e), "printed.toml")) == print_experiment(e));
  // Studies of beads stay studies of beads.
  CHECK(e.sampler_for(0.2).model.is_beads());
}

TEST_CASE("Without values a model is measured as its own table says") {
  const Experiment e = with("[model]\nname = \"stochastic-osl\"\n[model.stochastic_osl]\ndisorder = 0.35\n");
  CHECK(e.scan_values() == std::vector{0.35});
  CHECK(std::string(e.scanned().symbol) == "Δ");
}

TEST_CASE("A scan that cannot be is refused with what to write") {
  const auto refused = [](const std::string& text, const std::string& why) {
    INFO(text);
    CHECK_THROWS_WITH(with(text), Contains(why));
  };
  refused("[scan]\nparameter = \"share\"\n", "piles of the model frictional-beads do not depend on \"share\"");
  refused("[scan]\nparameter = \"lambda\"\nvalues = [0, 1]\n", "choose one of: mu");
  refused("[scan]\nvalues = [-0.1]\n", "friction.mu: -0.1 is out of range");
  refused("[model]\nname = \"three-leg\"\n[scan]\nparameter = \"disorder\"\n", "choose one of: middle, noise");
  refused("[model]\nname = \"three-leg\"\n[scan]\nvalues = [0.1, 1.2]\n",
          "scan.values: with middle = 1.2 no pile can be");
  refused("[friction]\nmu = [0.3]\n[model]\nname = \"diluted-beads\"\n", "give at most 2048 beads");
  refused("[model]\nname = \"q-models\"\n", "there is no model \"q-models\"");
  refused("[model]\nname = \"q-model\"\n[scenes.force_chains]\nmu = 0.2\n[scenes.friction]\nshow = true\n",
          "has no contacts of beads");
  refused("[model]\nname = \"three-leg\"\n[model.three_leg]\nmiddle = 1.5\n", "model.three_leg.middle");
  CHECK_THROWS_WITH(parse_experiment("[model]\nname = \"q-model\"\n[response]\nestimator = \"paired\"\n", "x"),
                    Contains("which the model q-model does not have"));
  const std::string diluted =
      "[friction]\nmu = [0.3]\n[model]\nname = \"diluted-beads\"\n[lattice]\ncolumns = 24\nlayers = 16\n";
  CHECK_THROWS_WITH(parse_experiment(diluted + "[fit]\nfirst_layer = 5\nshallow_layer = 4\nlast_layer = 11\n", "x"),
                    Contains("the lowest 5 of 16 layers"));
  CHECK_THROWS_WITH(
      parse_experiment(diluted + "[fit]\nfirst_layer = 5\nshallow_layer = 4\nlast_layer = 8\nlayer_step = 1\n" +
                           "[figures.response_profiles]\nshow = false\n[scenes.force_chains]\nshow = false\n" +
                           "[response]\nestimator = \"fluctuation\"\n",
                       "x"),
      Contains("small and solved as a whole"));
}

TEST_CASE("A window too deep for the estimator fluctuation is refused before anything is drawn") {
  for (const char* model : {"frictional-beads", "three-leg"}) {
    CHECK_THROWS_WITH(
        parse_experiment(small + "estimator = \"fluctuation\"\n[model]\nname = \"" + model + "\"\n", "deep.toml"),
        Contains("too few for the estimator fluctuation"));
  }
}
