// The main line of models that are not beads: the same stages, figures and report.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "quiet_run.h"
#include "support/files.h"

using namespace granuscope;
using test::TemporaryFolder;

namespace {

const std::string small = R"(
[lattice]
columns = 160
layers = 64
[response]
estimator = "multiplexed"
epsilon = 0.3
samples = 512
blocks = 16
[fit]
first_layer = 14
last_layer = 42
layer_step = 1
shallow_layer = 8
scaling_window = [0.05, 0.5]
[figures.response_profiles]
layers = [30, 42]
[scenes.force_chains]
columns = 40
layers = 30
width_px = 300
dpi = 150
[report]
pdf = false
)";

nlohmann::json run(const std::string& text, const std::filesystem::path& folder,
                   const std::vector<std::string>& changes = {}) {
  run_experiment(parse_experiment(small + text, "model.toml", changes), quiet(folder));
  return nlohmann::json::parse(read_file(folder / "summary.json"));
}

}  // namespace

TEST_CASE("A scan of the free three-leg model finds its exact c and D, and tells its own parameter everywhere") {
  const TemporaryFolder folder;
  const nlohmann::json summary =
      run("[model]\nname = \"three-leg\"\n[model.three_leg]\nnoise = 0.05\n[scan]\nvalues = [0.2, 0.3, 0.4, 0.5]\n",
          folder.path());
  CHECK(summary["scan"]["parameter"] == "middle");
  REQUIRE(summary["results"].size() == 4);
  for (const auto& result : summary["results"]) {
    const double p = result["middle"];
    CHECK_FALSE(result.contains("mu"));
    CHECK(result["law"] == "three-leg, free");
    INFO("p = " << p);
    const auto agrees = [](const nlohmann::json& measured, double exact) {
      const double value = measured["value"], error = measured["stderr"];
      CHECK(error < 0.1 * exact);
      CHECK(std::abs(value - exact) < 5 * error + 0.01 * exact);  // narrow peaks on a lattice are not quite Gaussian
    };
    agrees(result["c"], std::sqrt((1 - p) / 3));
    agrees(result["D"], p / (2 * std::sqrt(3.0)));
  }
  for (const auto& claim : summary["claims"]) {
    if (claim["id"] == "c-of-mu" || claim["id"] == "double-peak") CHECK(claim["verdict"] == "not tested");
    if (claim["id"] == "diffusive-width") CHECK(claim["verdict"] != "not tested");
  }
  for (const char* name :
       {"model-weights.png", "response-field.png", "scaling-with-friction.svg", "main-finding.svg"}) {
    CHECK(std::filesystem::exists(folder.path() / "figures" / name));
  }
  CHECK(std::filesystem::exists(folder.path() / "ensembles/middle-0.3.h5"));
  // Nothing that is said of this run is said of friction, but for what the paper says.
  const std::string script = read_file(folder.path() / "figures/scaling-with-friction.gp");
  CHECK(script.find("mean share of the middle leg p") != std::string::npos);
  CHECK(script.find("friction coefficient") == std::string::npos);
  CHECK(read_file(folder.path() / "figures/main-finding-gamma-slopes.csv").find("middle") != std::string::npos);
  const std::string page = read_file(folder.path() / "report.html");
  CHECK(page.find("mean share of the middle leg") != std::string::npos);
  CHECK(page.find("Coulomb’s condition") == std::string::npos);
  CHECK(read_file(folder.path() / "summary.md").find("| p | c | D |") != std::string::npos);
}

TEST_CASE("The q-model runs under the estimator point: one peak, no c, and a report that says so") {
  const TemporaryFolder folder;
  const nlohmann::json summary = run(R"([model]
name = "q-model"
)",
                                     folder.path());
  REQUIRE(summary["results"].size() == 1);
  CHECK(summary["results"][0]["disorder"] == 1);
  CHECK(summary["results"][0]["law"] == "q-model, uniform");
  CHECK(summary["results"][0]["c"]["value"].is_null());
  CHECK(std::filesystem::exists(folder.path() / "report.html"));
}

TEST_CASE("Stochastic OSL is slowed down by its noise, and its report has pictures", "[unsanitized]") {
  const TemporaryFolder folder;
  const nlohmann::json summary =
      run(R"(
[model]
name = "stochastic-osl"
[model.stochastic_osl]
cell_columns = 2
cell_rows = 2
[scan]
values = [0.25, 0.35]
)",
          folder.path(), {"lattice.layers=90", "response.samples=2048", "fit.first_layer=20", "fit.last_layer=68"});
  REQUIRE(summary["results"].size() == 2);
  const nlohmann::json &weak = summary["results"][0]["c"], &strong = summary["results"][1]["c"];
  REQUIRE(weak["value"].is_number());
  REQUIRE(strong["value"].is_number());
  const double error = std::hypot(weak["stderr"].get<double>(), strong["stderr"].get<double>());
  CHECK(weak["value"].get<double>() - strong["value"].get<double>() > 5 * error);
  CHECK(0.57735 - weak["value"].get<double>() > 5 * weak["stderr"].get<double>());
  CHECK(std::filesystem::exists(folder.path() / "figures/model-weights.png"));
}

TEST_CASE("Fluctuations of free legs give the exact c and D without any load") {
  const TemporaryFolder folder;
  const nlohmann::json summary =
      run("[model]\nname = \"three-leg\"\n[scan]\nvalues = [0.2, 0.4]\n", folder.path(),
          {"response.estimator=fluctuation", "response.reference_lag=8", "lattice.layers=150"});
  for (const auto& result : summary["results"]) {
    const double p = result["middle"];
    INFO("p = " << p);
    const auto agrees = [](const nlohmann::json& measured, double exact) {
      const double value = measured["value"], error = measured["stderr"];
      CHECK(error < 0.1 * exact);
      CHECK(std::abs(value - exact) < 5 * error + 0.01 * exact);
    };
    agrees(result["c"], std::sqrt((1 - p) / 3));
    agrees(result["D"], p / (2 * std::sqrt(3.0)));
  }
}

TEST_CASE("Diluted beads go through the main line, with their opened contacts in the pictures", "[long]") {
  const TemporaryFolder folder;
  const std::vector<std::string> changes{"lattice.columns=20",
                                         "lattice.layers=12",
                                         "response.opposite=true",
                                         "response.samples=64",
                                         "response.blocks=8",
                                         "fit.first_layer=4",
                                         "fit.last_layer=6",
                                         "fit.shallow_layer=3",
                                         "fit.scaling_window=[0, 0.1]",
                                         "figures.response_profiles.layers=[5, 6]",
                                         "scenes.force_chains.columns=16",
                                         "scenes.force_chains.layers=8",
                                         "scenes.force_chains.mu=0.3",
                                         "scenes.weight.show=true"};
  const nlohmann::json summary =
      run("[model]\nname = \"diluted-beads\"\n[friction]\nmu = [0.3]\n[scan]\nvalues = [0.0, 0.06]\n", folder.path(),
          changes);
  REQUIRE(summary["results"].size() == 2);
  CHECK(summary["scan"]["parameter"] == "opened_share");
  CHECK(summary["results"][1]["opened_share"] == 0.06);
  CHECK(summary["results"][1]["mu"] == 0.3);
  for (const char* name : {"force-chains.png", "bead-weights.png", "response-field.png"}) {
    INFO(name);
    CHECK(std::filesystem::exists(folder.path() / "figures" / name));
  }
}
