// What a refusal tells to do is accepted at once.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "experiment/experiment.h"
#include "experiment/experiment_file.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse_experiment(text, "x.toml", overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

/// An experiment, words of its refusal, and what they tell to do: values by --set, or lines to leave out ("-").
struct Refused {
  std::string text, advice;
  std::vector<std::string> followed;
};

const std::vector<Refused> refusals = {
    // Sizes
    {"[lattice]\ncolumns = 3\n", "leave this out", {"-columns = 3"}},
    {"[lattice]\ncolumns = 4\n", "give more than 14 columns", {"lattice.columns=15"}},
    {"[lattice]\ncolumns = 100\n[fit]\nlast_layer = 179\n", "or stop at layer 76", {"fit.last_layer=76"}},
    {"[lattice]\nlayers = 23\n", "give at least 24", {"lattice.layers=24"}},
    {"[lattice]\nlayers = 100000000000\n", "give 24 to 1000000", {"lattice.layers=24"}},
    {"[model]\nname = \"q-model\"\n[lattice]\nlayers = 3\n", "give at least 4", {"lattice.layers=6"}},
    {"[model]\nname = \"three-leg\"\n[lattice]\ncolumns = 101\n[model.three_leg]\ncell_columns = 4\n",
     "give a divisor of it",
     {"model.three_leg.cell_columns=1"}},
    // Windows
    {"[lattice]\nlayers = 200\n[fit]\nlast_layer = 300\n", "end the window at 179", {"fit.last_layer=179"}},
    {"[lattice]\nlayers = 200\n[fit]\nlast_layer = 300\n", "or compute 321 layers", {"lattice.layers=321"}},
    {"[friction]\nmu = [0.01, 0.05]\n[lattice]\nlayers = 100\n[response]\nestimator = \"fluctuation\"\n",
     "of response and 21 at the bottom need 2224; give so many",
     {"lattice.layers=2224"}},
    {"[friction]\nmu = [0.01, 0.05]\n[lattice]\nlayers = 100\n[response]\nestimator = \"fluctuation\"\n",
     "a shallower first base by response.first_base",
     {"response.first_base=10"}},
    {"[fit]\nlayer_step = 100\n", "take steps of at most 60", {"fit.layer_step=60"}},
    {"[lattice]\nlayers = 120\n[fit]\nfirst_layer = 100\n", "begin it at layer 97", {"fit.first_layer=97"}},
    {"[fit]\nfirst_layer = 5\nlast_layer = 10\nlayer_step = 3\n", "steps of at most 2", {"fit.layer_step=2"}},
    {"[fit]\nlayer_step = 0\n", "give at least 1", {"fit.layer_step=1"}},
    {"[fit]\nscaling_window = 0.3\n", "write [low, high]", {"fit.scaling_window=[0.1, 0.3]"}},
    // Friction and scans
    {"[friction]\nmu = [0.1]\n[scan]\nparameter = \"mu\"\nvalues = [0.2]\n",
     "leave one of the two out",
     {"-values = [0.2]"}},
    {"[friction]\nmu = [0.1]\n[scan]\nvalues = [0.2]\n", "leave one of the two out", {"-values = [0.2]"}},
    {"[friction]\nmu = [0.2, 2, -0.1]\n", "2 are out of range", {"friction.mu=0.2"}},
    {"[lattice]\ncolumns = \"640\"\n", "write columns = 640:", {"lattice.columns=640"}},
    {"[friction]\nmu = [0.3, \"0.4\"]\n", "write mu = [0.3, 0.4]:", {"friction.mu=[0.3, 0.4]"}},
    {"[model.q_model]\nsplit = \"beta\"\n", "leave it out", {"-split = \"beta\""}},
    {"[model.q_model]\nsplit = \"beta\"\n", "or give the model that has it", {"model.name=q-model"}},
    {"[model]\nname = \"three-leg\"\n[model.diluted_beads]\nopened_share = 0.1\n",
     "model.name = \"three-leg\"; leave it out",
     {"-opened_share = 0.1"}},
    {"[model]\nname = \"q-model\"\n[sampling]\nlaw = \"polytope\"\n", "leave this out", {"-law = \"polytope\""}},
    {"[friction]\nmu = 1.8\n", "at least 0 and less than 1.732", {"friction.mu=0"}},
    {"[friction]\nmu = []\n", "give 1 to 1000 values", {"friction.mu=[0.3]"}},
    {"[friction]\nmu = [0.3, 0.3]\n", "remove one", {"friction.mu=[0.3]"}},
    {"[friction]\nmu = \"0.2,0.3\"\n", "write mu = [0.2, 0.3]:", {"friction.mu=0.2,0.3"}},
    {"[friction]\nmu = [0,2, 0,3]\n", "or write points where these are decimal commas", {"friction.mu=[0.2, 0.3]"}},
    {"[scan]\nparameter = \"nu\"\nvalues = [0.1]\n", "choose one of: mu, bead_weight", {"scan.parameter=mu"}},
    {"[scan]\nparameter = \"lambda\"\nvalues = [0.1, 2]\n[sampling]\nlaw = \"polytope\"\n",
     "give 0 to 1",
     {"scan.values=[0.1, 1]"}},
    {"[scan]\nparameter = \"bead_weight\"\nvalues = [0, 0.01]\n[friction]\nmu = [0.1, 0.3]\n",
     "give one",
     {"friction.mu=0.3"}},
    // Piles and loads
    {"[response]\nsamples = 50\n", "give 64 to 1000000000", {"response.samples=64"}},
    {"[response]\nsamples = 100\nblocks = 32\n", "or fewer blocks", {"response.blocks=12"}},
    {"[response]\nblocks = 4\n", "give 8 to 10000", {"response.blocks=8"}},
    {"[response]\nblocks = 20000\n", "give 8 to 10000", {"response.blocks=10000"}},
    {"[response]\nestimator = \"Point\"\n", "known are point", {"response.estimator=point"}},
    {"[response]\noverload = 0\n", "give 1e-06 to 1000000", {"response.overload=1e-6"}},
    {"[response]\nsign_run = 4\n", "leave it out", {"-sign_run = 4"}},
    {"[response]\nbase_step = 0\n", "leave it out", {"-base_step = 0"}},  // not 1 to 1000, which would be idle, too
    {"[sampling]\nlambda = 7\n", "leave it out", {"-lambda = 7"}},
    {"[response]\nestimator = \"paired\"\noverloads = 2\n", "or choose that estimator", {"response.estimator=point"}},
    {"[response]\noverloads = 3\n[lattice]\ncolumns = 100\n", "or 0 for as many as fit", {"response.overloads=0"}},
    {"[response]\noverloads = 2\n[friction]\nmu = [0.3, 1.2]\n", "give 1", {"response.overloads=1"}},
    {"[response]\noverloads = 2\n[friction]\nmu = [0.3, 1.2]\n", "or 0", {"response.overloads=0"}},
    {"[model]\nname = \"q-model\"\n[response]\nestimator = \"paired\"\n",
     "choose another",
     {"response.estimator=point"}},
    {"[sampling]\nlaw = \"rejection\"\n", "or polytope", {"sampling.law=polytope"}},
    {"[sampling]\nlaw = \"rejection\"\n[lattice]\ncolumns = 150\nlayers = 60\n",
     "take granusolve, or polytope, which draws the same law on at most 4096 beads",
     {"sampling.law=granusolve"}},
    {"[sampling]\nlaw = \"polytope\"\n[lattice]\nlayers = 200\n", "use granusolve", {"sampling.law=granusolve"}},
    {"[sampling]\nlambda = 0.5\n", "leave it out", {"-lambda = 0.5"}},
    {"[sampling]\nlambda = 0.5\n", "or choose that law", {"sampling.law=polytope"}},
    {"[sampling]\neffort = 0\n", "give 1 to 1000000000", {"sampling.effort=1"}},
    {"[model]\nname = \"beads\"\n", "known are frictional-beads", {"model.name=frictional-beads"}},
    {"[precision]\nc = 0.001\nmost_samples = 10\n", "give 256 to 1000000000", {"precision.most_samples=256"}},
    {"[precision]\nc = 5\n", "give 0, or 1e-09 to 1", {"precision.c=1"}},
    // Figures and pictures
    {"[figures.response_profiles]\nmu = 0.25\n[friction]\nmu = [0.1, 0.3]\n",
     "choose one of them",
     {"figures.response_profiles.mu=0.3"}},
    {"[figures.response_profiles]\nmu = 0.25\n[friction]\nmu = [0.1, 0.3]\n",
     "set figures.response_profiles.show = false",
     {"figures.response_profiles.show=false"}},
    {"[figures.response_profiles]\nlayers = [10, 500]\n[lattice]\nlayers = 200\n",
     "are 0 to 179; choose among them",
     {"figures.response_profiles.layers=[0, 179]"}},
    {"[figures.response_profiles]\nlayers = [10, 500]\n[lattice]\nlayers = 200\n",
     "compute 521 layers",
     {"lattice.layers=521"}},
    {"[figures.response_profiles]\nlayers = []\n", "give 1 to 8", {"figures.response_profiles.layers=100"}},
    {"[scenes.force_chains]\nwidth_px = 100\n", "smallest width is 483 pixels", {"scenes.force_chains.width_px=483"}},
    {"[scenes.force_chains]\nwidth_px = -1\n", "smallest width is 483 pixels", {"scenes.force_chains.width_px=483"}},
    {"[scenes.force_chains]\nwidth_px = 40000\n", "at most 32768", {"scenes.force_chains.width_px=32768"}},
    {"[scenes.force_chains]\ncolumns = 2\n", "give at least 4", {"scenes.force_chains.columns=4"}},
    {"[scenes.force_chains]\ncolour_map = \"jet\"\n", "choose grey", {"scenes.force_chains.colour_map=grey"}},
    {"[scenes.force_chains]\nmu = 0\n[scenes.friction]\nshow = true\n", "write false", {"scenes.friction.show=false"}},
    {"[scenes.force_chains]\nmu = 0\n[scenes.friction]\nshow = true\n",
     "or a mu above 0",
     {"scenes.force_chains.mu=0.3"}},
    {"[scenes.pictures.zoom]\nwindow = [-100, 100, 0, 10]\n",
     "keep X0 and X1 between -35 and 35",
     {"scenes.pictures.zoom.window=[-35, 35, 0, 10]"}},
    {"[scenes.pictures.zoom]\nscene = \"force\"\n",
     "choose one of forces, weight, friction, response",
     {"scenes.pictures.zoom.scene=weight"}},
    // Report and gate
    {"[report]\nabout = \"x\"\n", "leave this empty", {"report.about=\"\""}},
    {"[report]\nkey_figure = \"force-chain\"\n", "did you mean force-chains?", {"report.key_figure=force-chains"}},
    {"[gate.expect]\nD-of-mu = \"yes\"\n", "write one of reproduced", {"gate.expect.D-of-mu=reproduced"}},
    {"[gate.expect]\nD-of-nu = \"reproduced\"\n", "did you mean D-of-mu?", {"-D-of-nu = \"reproduced\""}},
    {"[lattice]\nlayer = 200\n", "did you mean lattice.layers?", {"-layer = 200", "lattice.layers=200"}},
};

}  // namespace

TEST_CASE("Each piece of advice of a refusal is accepted at once") {
  for (const Refused& one : refusals) {
    CAPTURE(one.text, one.advice);
    CHECK_THAT(refusal(one.text), Contains(one.advice));
    std::string text = one.text;
    std::vector<std::string> values;
    for (const std::string& step : one.followed) {
      if (!step.starts_with('-')) {
        values.push_back(step);
        continue;
      }
      const std::size_t at = text.find(step.substr(1) + "\n");
      REQUIRE(at != std::string::npos);
      text.erase(at, step.size());
    }
    CHECK(refusal(text, values) == "(accepted)");
  }
}

TEST_CASE("Only names of figures are taken for the one of page 1") {
  for (const char* id : {"force-chains", "bead-weights", "mobilised-friction", "pile-response", "response-field",
                         "law-comparison", "law-cost", "dispersion", "main-finding"}) {
    CHECK(refusal(std::string("[report]\nkey_figure = \"") + id + "\"\n") == "(accepted)");
  }
  for (const char* id : {"friction", "weight", "response", "law-thrust", "model-pile", "free", "pile"}) {
    CHECK_THAT(refusal(std::string("[report]\nkey_figure = \"") + id + "\"\n"), Contains("there is no figure"));
  }
}

TEST_CASE("What people write for numbers and switches is answered with how it is written") {
  for (const char* line : {"mu = .3", "mu = 3.", "mu = 1/3", "mu = 30%",
                           "mu = \xe2\x80\x9c"
                           "0.3\xe2\x80\x9d"}) {
    CHECK_THAT(refusal(std::string("[friction]\n") + line + "\n"), Contains("x.toml:2:") && Contains("as 0.3 or"));
  }
  for (const char* line : {"pdf = True", "pdf = yes", "pdf = off"}) {
    CHECK_THAT(refusal(std::string("[report]\n") + line + "\n"), Contains("switches as true or false"));
  }
  CHECK_THAT(refusal("[lattice]\nlayers = \"many\"\n"), Contains("(24 to 1000000)"));
  CHECK_THAT(refusal("", {"response.samples=1,000"}), Contains("(there is a comma in it; write digits alone)"));
  CHECK_THAT(refusal("", {"sampling.bead_weight=0,3"}), Contains("write a point"));
  for (const char* line : {"friction.mu=.3", "friction.mu=3.", "friction.mu=[0.1, .3]", "friction.mu=[0.1 0.3]"})
    CHECK_THAT(refusal("", {line}), Contains("as 0.3 or"));
  CHECK_THAT(refusal("[friction]\nmu = \u20130.3\n") + refusal("", {"friction.mu=\u20130.3"}),
             Contains("x.toml:2:") && Contains("--set") && Contains("U+2013"));
}

TEST_CASE("What is wrong is told at once, and what is printed with every default is not wrong") {
  // The load that has no meaning here, and blocks that the piles cannot fill: both in one message.
  const std::string both =
      refusal("[response]\nestimator = \"multiplexed\"\ncoupled = true\nsamples = 100\nblocks = 64\n");
  CHECK_THAT(both, Contains("x.toml:3:1: response.coupled") && Contains("x.toml:4:1: response.samples: 100"));
  const std::string list = refusal("[friction]\nmu = [0.2, 2, -0.1, 0.3]\n");
  CHECK_THAT(list, Contains("friction.mu: -0.1 and 2 are out of range: "));
  CHECK_THAT(refusal("[friction]\nmu = [0.2, 2]\n"), Contains("friction.mu: 2 is out of range: "));
  for (const char* model : {"frictional-beads", "q-model", "three-leg", "stochastic-osl", "diluted-beads"}) {
    const Experiment e = parse_experiment(std::string("[model]\nname = \"") + model + "\"\n", "x.toml");
    CHECK(refusal(print_experiment(e)) == "(accepted)");
  }
  CHECK_THAT(refusal(std::string("PK\x03\x04\x14\0", 6)), Contains("as spreadsheets are"));
  CHECK_THAT(refusal("\n# nothing\n"), Contains("(accepted)"));
}

TEST_CASE("A text that is not closed is called so") {
  for (const char* line : {"law = \"granusolve\n", "law = \"granusolve", "law = 'granusolve\nseed = 1\n"}) {
    CHECK_THAT(refusal(std::string("[sampling]\n") + line),
               Contains("x.toml:2:") && Contains("a text is not closed") && !Contains("control character"));
  }
  CHECK_THAT(refusal("", {"sampling.law=\"granusolve"}), Contains("a text is not closed"));
}

TEST_CASE("A printed experiment hides no character, and reads back") {
  const Experiment e = parse_experiment("[experiment]\nname = \"a\\u202Eb\\u009B31mc \xc3\xa9\"\n", "x.toml");
  const std::string text = print_experiment(e);
  CHECK_THAT(text, Contains("name = \"a\\u202Eb\\u009B31mc \xc3\xa9\"\n"));
  CHECK(parse_experiment(text, "y.toml").name == e.name);
}

TEST_CASE("Every law, load and number of overloads runs, or says in one message why it cannot") {
  int accepted = 0;
  for (const std::string law : {"granusolve", "polytope", "rejection"}) {
    for (const std::string mu : {"0.25", "[0.2, 0.4]", "[0.1, 0.2, 0.3]", "[0, 0.05, 0.1, 0.3, 0.6, 1.2]"}) {
      for (const std::string size : {"layers = 40", "layers = 120", "layers = 500", "layers = 2000\ncolumns = 64"}) {
        for (const std::string load : {"overloads = 0", "overloads = 2", "overloads = 3\ncoupled = true",
                                       "coupled = true", "estimator = \"multiplexed\"\nopposite = true"}) {
          const std::string text = "[sampling]\nlaw = \"" + law + "\"\n[friction]\nmu = " + mu + "\n[lattice]\n" +
                                   size + "\n[response]\n" + load + "\n";
          CAPTURE(text);
          try {
            const Experiment e = parse_experiment(text, "x.toml");
            CHECK(find_problems(e).empty());
            ++accepted;
          } catch (const InputError& error) {
            for (const std::string& message : error.messages()) CHECK_THAT(message, Contains("; "));
            // Nothing that the file does not say is its reason.
            CHECK_THAT(error.what(), Contains(": sampling.law: ") || Contains(": response.overloads: ") ||
                                         Contains(": response.coupled: "));
            const bool too_fast = mu.ends_with("1.2]") && load.starts_with("overloads");
            const bool too_narrow = size.ends_with("64") && load.starts_with("overloads");
            CHECK((law != "granusolve" || too_fast || too_narrow));
          }
        }
      }
    }
  }
  CHECK(accepted > 60);
}
