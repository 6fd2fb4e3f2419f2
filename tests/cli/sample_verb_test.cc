#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "cli/in_process.h"
#include "ensemble/ensemble_runner.h"
#include "kit/temporary_folder.h"
#include "model/audit.h"
#include "storage/pile_file.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

std::vector<std::string> keys_of(const nlohmann::ordered_json& object) {
  std::vector<std::string> keys;
  for (const auto& item : object.items()) keys.push_back(item.key());
  return keys;
}

}  // namespace

TEST_CASE("sample --statistics prints one JSON object with the documented keys and nothing else") {
  const auto result = granuscope_command({"sample", "--mu", "0.3", "--columns", "12", "--layers", "5", "--samples",
                                          "128", "--seed", "11", "--statistics"});
  REQUIRE(result.code == 0);
  const auto object = nlohmann::ordered_json::parse(result.out);
  CHECK(keys_of(object) == std::vector<std::string>{"law", "mu", "columns", "layers", "samples", "tries",
                                                    "draws_per_bead", "repaired_per_bead", "backtracked_per_bead",
                                                    "seconds", "per_layer", "audit", "rounded_per_bead",
                                                    "effective_samples"});
  CHECK(object["law"] == "granusolve");
  CHECK(object["mu"] == 0.3);
  CHECK(object["columns"] == 12);
  CHECK(object["layers"] == 5);
  CHECK(object["samples"] == 128);
  CHECK(object["draws_per_bead"] >= 1.0);
  REQUIRE(object["per_layer"].size() == 5);
  for (std::size_t n = 0; n < 5; ++n) {
    const auto& layer = object["per_layer"][n];
    CHECK(keys_of(layer) == std::vector<std::string>{"layer", "alpha", "weight_variance"});
    CHECK(layer["layer"] == n);
    CHECK(layer["alpha"]["stderr"] > 0.0);
  }
  // Every top bead carries exactly 1, and hands it on as two halves: layers 0 and 1 have no variance.
  for (std::size_t n : {0, 1}) {
    CHECK(object["per_layer"][n]["weight_variance"]["value"].get<double>() == Approx(0).margin(1e-25));
  }
  CHECK(keys_of(object["audit"]) == std::vector<std::string>{"max_balance_residual", "max_cone_violation"});
  CHECK(object["audit"]["max_balance_residual"] <= 1e-12);
  CHECK(object["audit"]["max_cone_violation"] <= 1e-12);
  CHECK_THAT(result.err, Contains("audited 128 of 128 piles"));
}

TEST_CASE("every law draws small piles by its name; a chain tells how it was run and what its piles are worth") {
  const auto measured = [](std::vector<std::string> more) {
    std::vector<std::string> command{"sample", "--mu",      "0.3", "--columns", "6", "--layers",
                                     "4",      "--samples", "512", "--seed",    "3", "--statistics"};
    command.insert(command.end(), more.begin(), more.end());
    const auto result = granuscope_command(command);
    REQUIRE(result.code == 0);
    return json::parse(result.out);
  };
  for (const std::string law : {"granusolve", "eloy-clement", "rejection", "polytope"}) {
    const auto object = measured({"--law", law});
    CAPTURE(law);
    CHECK(object["law"] == law);
    CHECK(object["samples"] == 512);
    CHECK(object["audit"]["max_balance_residual"] <= 1e-12);
    CHECK(object["audit"]["max_cone_violation"] <= 1e-12);
    CHECK(object.contains("chain") == (law == "polytope"));
  }
  const auto chosen = measured({"--law", "polytope", "--lambda", "0.25"});
  CHECK(chosen["chain"]["lambda"] == 0.25);
  CHECK(chosen["chain"]["burn_in"] > chosen["chain"]["thinning"]);
  CHECK(chosen["chain"]["accepted"] > 0.5);
  // Independent piles are worth their number (32 blocks: to a quarter), neighbours in a chain far less. Only the groups
  // of eight are independent of each other.
  const double independent = measured({"--law", "rejection"})["effective_samples"]["value"];
  CHECK(independent > 512 / 3.0);
  CHECK(independent < 512 * 3.0);
  const auto dense = measured({"--law", "polytope", "--burn-in", "500", "--thinning", "1"});
  CHECK(dense["chain"]["burn_in"] == 500);
  CHECK(dense["chain"]["thinning"] == 1);
  CHECK(dense["effective_samples"]["value"] < 512 / 3.0);
  CHECK(dense["effective_samples"]["value"] > 512 / 32.0);
}

TEST_CASE("options of one law are refused under another") {
  for (const char* option : {"--lambda", "--burn-in", "--thinning"}) {
    const auto result = granuscope_command({"sample", "--mu", "0.3", option, "0.5", "--statistics"});
    CHECK(result.code == 2);
  }
  const auto result = granuscope_command({"sample", "--mu", "0.3", "--lambda", "0.5", "--statistics"});
  CHECK_THAT(result.err, Contains("--lambda: it belongs to the law polytope"));
  for (const char* lambda : {"-0.1", "1.5", "nan"}) {
    CHECK(granuscope_command({"sample", "--law", "polytope", "--lambda", lambda, "--statistics"}).code == 2);
  }
}

TEST_CASE("sample --statistics does not depend on the number of threads") {
  const auto numbers = [](const std::string& threads) {
    auto object = json::parse(granuscope_command({"sample", "--mu", "0.3", "--columns", "20", "--layers", "20",
                                                  "--samples", "300", "--statistics", "--threads", threads})
                                  .out);
    object.erase("seconds");
    return object;
  };
  const auto one = numbers("1");
  CHECK(one == numbers("2"));
  CHECK(one == numbers("5"));
}

TEST_CASE("sample --distributions writes densities with errors that add up, and of the top those of uniform splits") {
  const test::TemporaryFolder folder;
  const auto distributed = [&](const std::string& mu, const std::string& layers, const std::string& band,
                               const std::string& threads) {
    const auto file = folder / (band + "-" + threads + ".csv");
    const CommandResult result =
        granuscope_command({"sample", "--statistics", "--mu", mu, "--columns", "100", "--layers", layers, "--samples",
                            "128", "--band", band, "-j", threads, "--distributions", file.string()});
    INFO(result.err);
    REQUIRE(result.code == 0);
    CHECK(nlohmann::json::parse(result.out)["per_layer"][0].contains("sliding"));
    return read_file(file);
  };
  struct Sums {
    double area = 0, mean = 0, last = 0, width = 1;
  };
  const auto sums_of = [](const std::string& csv) {
    std::map<std::string, Sums> all;
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    CHECK(line == "of,x,density,standard_error");
    while (std::getline(lines, line)) {
      Sums& of = all[line.substr(0, line.find(','))];
      double x = 0, density = 0, error = 0;
      REQUIRE(std::sscanf(line.c_str() + line.find(','), ",%lf,%lf,%lf", &x, &density, &error) == 3);
      CHECK(error >= 0);
      if (of.area > 0) of.width = std::min(of.width, x - of.last);
      of.last = x;
      of.area += density;
      of.mean += density * x;
    }
    return all;
  };
  const std::string deep = distributed("0.3", "60", "20,39", "1");
  CHECK((deep == distributed("0.3", "60", "20,39", "2")));
  std::map<std::string, Sums> sums = sums_of(deep);
  REQUIRE(sums.size() == 4);
  for (const char* of : {"w/<w>", "N/<N>"}) {  // but for some bins of the tail that are hardly known
    INFO(of);
    CHECK(sums[of].area * sums[of].width == Approx(1).epsilon(2e-3));
    CHECK(sums[of].mean * sums[of].width == Approx(1).epsilon(5e-3));
  }
  CHECK(sums["|T|/(mu N)"].area * sums["|T|/(mu N)"].width + sums["share that slides"].area == Approx(1));
  // In layer 0 H is uniform between the limits of the cone, on either contact alike: the mean of |T|/(mu N) is that of
  // |atan(H/V) - 30 degrees| in tangents, by a sum over H. (Deeper piles draw some of it again.)
  sums = sums_of(distributed("0.1", "3", "0,0", "2"));
  const double mu = 0.1, low = (tan30 - mu) / (1 + tan30 * mu), high = (tan30 + mu) / (1 - tan30 * mu);
  const auto mobilised = [&](double t) { return std::abs(t - tan30) / (1 + t * tan30) / mu; };
  double expected = 0;
  constexpr int steps = 4000;
  for (int k = 0; k < steps; ++k) expected += mobilised(low + (high - low) * (k + 0.5) / steps) / steps;
  const Sums& top = sums["|T|/(mu N)"];
  CHECK(top.mean * top.width == Approx(expected).epsilon(0.02));
  for (const auto& [band, told] : std::vector<std::pair<std::string, std::string>>{
           {"5", "is not FIRST,LAST"}, {"30,60", "the pile has 0 to 59"}, {"9,5", "counts layers 9 to 5"}}) {
    const CommandResult refused =
        granuscope_command({"sample", "--statistics", "--mu", "0.3", "--columns", "20", "--layers", "60", "--band",
                            band, "--distributions", (folder / "none.csv").string()});
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains(told));
  }
  for (const auto& [band, told] : std::vector<std::pair<std::string, bool>>{{"20, 39", false}, {"20,40", true}}) {
    const CommandResult done =
        granuscope_command({"sample", "--statistics", "--mu", "0.3", "--columns", "20", "--layers", "60", "--band",
                            band, "--samples", "64", "--distributions", (folder / "band.csv").string()});
    CHECK(done.code == 0);
    CHECK((done.err.find("ends below layer 39: the layers from there on follow another law") != std::string::npos) ==
          told);
  }
  const std::string again = (folder / "again.csv").string();
  for (int time = 0; time < 2; ++time) {  // its own file is replaced
    CHECK(granuscope_command({"sample", "--statistics", "--mu", "0.3", "--columns", "20", "--layers", "30", "--samples",
                              "64", "--distributions", again})
              .code == 0);
  }
  const std::string none = (folder / "none.csv").string();
  const CommandResult failed =
      granuscope_command({"sample", "--statistics", "--law", "rejection", "--mu", "1.5", "--columns", "8", "--layers",
                          "8", "--max-tries", "1000", "--samples", "64", "--distributions", none});
  CHECK(failed.code == 2);
  CHECK_THAT(failed.err, Contains("no pile was completed"));
  CHECK_FALSE(std::filesystem::exists(none));
}

TEST_CASE("Few samples give values without standard errors, and say so") {
  const auto few = json::parse(granuscope_command({"sample", "--mu", "0.3", "--columns", "20", "--layers", "4",
                                                   "--samples", "63", "--statistics"})
                                   .out);
  const auto enough = json::parse(granuscope_command({"sample", "--mu", "0.3", "--columns", "20", "--layers", "4",
                                                      "--samples", "64", "--statistics"})
                                      .out);
  for (std::size_t n = 0; n < 4; ++n) {
    const auto& alpha = few["per_layer"][n]["alpha"];
    CHECK(alpha["stderr"].is_null());
    CHECK_THAT(alpha["reason"].get<std::string>(), Contains("64 samples"));
    // One more sample of 20 beads can move a mean of 63 by no more than a few of its standard errors.
    const auto& better = enough["per_layer"][n]["alpha"];
    CHECK(alpha["value"].get<double>() ==
          Approx(better["value"].get<double>()).margin(2 * better["stderr"].get<double>()));
  }
}

TEST_CASE("Without friction the thrust ratio is exactly 1 with a standard error of 0") {
  const auto object = json::parse(granuscope_command({"sample", "--mu", "0", "--columns", "16", "--layers", "30",
                                                      "--samples", "64", "--statistics"})
                                      .out);
  for (const auto& layer : object["per_layer"]) {
    CHECK(layer["alpha"]["value"].get<double>() == Approx(1).epsilon(1e-14));
    CHECK(layer["alpha"]["stderr"].get<double>() == Approx(0).margin(1e-14));
  }
}

TEST_CASE("sample --out stores the pile that its key names, and audit accepts it") {
  const test::TemporaryFolder scratch;
  const std::vector<std::string> command{"sample", "--mu",  "0.3",    "--columns", "30",       "--layers", "25",
                                         "--load", "point", "--seed", "5",         "--sample", "17",       "--out"};
  for (const char* name : {"a.h5", "b.h5"}) {
    auto arguments = command;
    arguments.push_back((scratch / name).string());
    REQUIRE(granuscope_command(arguments).code == 0);
  }
  CHECK(read_file(scratch / "a.h5") == read_file(scratch / "b.h5"));
  const Pile pile = read_pile(scratch / "a.h5");
  CHECK(pile.mu == 0.3);
  CHECK(pile.seed == 5);
  CHECK(pile.sample == 17);
  CHECK(pile.load[15] == 2);
  CHECK(pile.load[14] == 1);
  const auto audited = granuscope_command({"audit", (scratch / "a.h5").string()});
  CHECK(audited.code == 0);
  CHECK_THAT(audited.out, Contains("largest balance residual"));
}

TEST_CASE(
    "sample stores a pile with opened contacts, and refuses models without contacts and options without a model") {
  const test::TemporaryFolder scratch;
  const std::vector<std::string> small{"sample", "--mu", "0.3", "--columns", "12", "--layers", "8", "--out"};
  const auto with = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments = small;
    arguments.push_back((scratch / "pile.h5").string());
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return granuscope_command(arguments);
  };
  CHECK_THAT(with({"--model", "q-model"}).err, Contains("have no contacts that could be stored"));
  CHECK_THAT(with({"--opened-share", "0.1"}).err, Contains("--model diluted-beads"));
  CHECK_THAT(with({"--model", "diluted-beads", "--opened-share", "0.3"}).err, Contains("--opened-share: "));
  CHECK_FALSE(std::filesystem::exists(scratch / "pile.h5"));
  REQUIRE(with({"--model", "diluted-beads", "--opened-share", "0.06"}).code == 0);
  const Pile pile = read_pile(scratch / "pile.h5");
  const auto opened =
      std::count(pile.V_R.begin(), pile.V_R.end(), 0.0) + std::count(pile.V_L.begin(), pile.V_L.end(), 0.0);
  CHECK(opened == std::lround(0.06 * 2 * 12 * 7));
  CHECK(granuscope_command({"audit", (scratch / "pile.h5").string()}).code == 0);
}

TEST_CASE("A changed pile does not pass the audit") {
  const test::TemporaryFolder scratch;
  REQUIRE(granuscope_command(
              {"sample", "--mu", "0.3", "--columns", "30", "--layers", "25", "--out", (scratch / "good.h5").string()})
              .code == 0);
  Pile pile = read_pile(scratch / "good.h5");
  const double correct = pile.H_R[pile.lattice.index(10, 4)];
  pile.H_R[pile.lattice.index(10, 4)] = correct * (1 + 1e-9);
  write_pile(scratch / "bad.h5", pile);
  const auto result = granuscope_command({"audit", (scratch / "bad.h5").string()});
  CHECK(result.code == 2);
  CHECK_THAT(result.err, Contains("no equilibrium"));
  CHECK_THAT(result.out, Contains("largest balance residual"));
}

TEST_CASE("Piles that do not exist or are none are input errors") {
  const test::TemporaryFolder scratch;
  std::ofstream(scratch / "text.h5") << "this is no pile";
  std::ofstream(scratch / "empty.h5");
  for (const auto& file : {scratch / "missing.h5", scratch / "text.h5", scratch / "empty.h5", scratch.path()}) {
    INFO(file);
    const auto result = granuscope_command({"audit", file.string()});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(file.string()));
  }
}

TEST_CASE("What the model cannot do is refused before anything is drawn") {
  const std::vector<std::pair<std::vector<std::string>, int>> cases{
      {{"--mu", "-0.1"}, 2},
      {{"--mu", "1.7321"}, 2},
      {{"--mu", "nan"}, 2},
      {{"--mu", "inf"}, 2},
      {{"--columns", "3"}, 2},
      {{"--layers", "0"}, 2},
      {{"--layers", "-5"}, 2},
      {{"--law", "nonsense"}, 2},
      {{"--load", "nonsense"}, 2},
      {{"--samples", "0"}, 2},
      {{"--effort", "nan"}, 2},
      {{"--effort", "0"}, 2},
      {{"--columns", "2000000000", "--layers", "2000000000"}, 3},
  };
  for (const auto& [change, code] : cases) {
    std::vector<std::string> arguments{"sample", "--statistics"};
    arguments.insert(arguments.end(), change.begin(), change.end());
    INFO(fmt::format("{}", fmt::join(arguments, " ")));
    const auto result = granuscope_command(arguments);
    CHECK(result.code == code);
    CHECK(result.out.empty());
  }
}

TEST_CASE("A file that cannot be written is an error of the environment and leaves nothing behind") {
  const test::TemporaryFolder scratch;
  const auto result = granuscope_command(
      {"sample", "--columns", "10", "--layers", "5", "--out", (scratch / "no/such/folder/pile.h5").string()});
  CHECK(result.code == 3);
  CHECK(std::filesystem::is_empty(scratch.path()));
}

TEST_CASE("A pile that cannot be completed within its effort is told with its layer") {
  // 30 x 30 beads at mu = 0.5 are rejected as good as always.
  const auto result = granuscope_command({"sample", "--mu", "0.5", "--law", "rejection", "--columns", "30", "--layers",
                                          "30", "--max-tries", "20", "--statistics", "--samples", "2"});
  CHECK(result.code == 2);
  const auto object = json::parse(result.out);
  CHECK(object["samples"] == 0);
  CHECK(object["per_layer"][3]["alpha"]["value"].is_null());
  CHECK(object["audit"]["max_balance_residual"].is_null());
  CHECK(object["audit"]["reason"].is_string());
  CHECK_THAT(result.err, Contains("sample 0 could not be completed") && Contains("granuscope sample --law rejection"));
  const auto stored = granuscope_command({"sample", "--mu", "0.5", "--law", "rejection", "--columns", "30", "--layers",
                                          "30", "--max-tries", "20", "--out", "never.h5"});
  CHECK(stored.code == 2);
  CHECK_THAT(stored.err, Contains("could not be completed"));
  CHECK_FALSE(std::filesystem::exists("never.h5"));
}

TEST_CASE("Many piles that cannot be completed are counted, and the first of them named") {
  const auto result = granuscope_command({"sample", "--mu", "0.3", "--columns", "20", "--layers", "20", "--effort", "1",
                                          "--statistics", "--samples", "72"});
  CHECK(result.code == 2);
  CHECK(json::parse(result.out)["samples"] == 0);
  CHECK_THAT(result.err, Contains("sample 7 could not be completed") && !Contains("sample 8 could not") &&
                             Contains("64 more of 72 samples could not be completed"));
}

TEST_CASE("the command that an ensemble names for a failed pile meets the failure, and draws the others") {
  const test::TemporaryFolder scratch;
  const auto replayed = scratch / "replayed.h5";
  for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
    for (const bool opposite : {false, true}) {
      if (opposite && estimator != EstimatorName::multiplexed) continue;
      EnsembleSpec spec;
      spec.response.estimator = estimator;
      spec.response.opposite = opposite;
      spec.response.sign_run = opposite ? 2 : 1;
      spec.response.overload = 2;
      spec.response.epsilon = 0.5;
      spec.sampler.mu = 0.3;
      spec.sampler.seed = 5;
      spec.sampler.effort = 1.2;
      spec.sampler.bead_weight = 0.25;
      spec.lattice = {20, 30};
      spec.response.samples = 64;
      spec.response.blocks = 8;
      EnsembleRecord record = run_ensemble(spec, 1, nullptr);
      while (record.failed.size() > 32 && spec.sampler.effort < 4) {  // until some piles fail and some do not
        spec.sampler.effort += 0.05;
        record = run_ensemble(spec, 1, nullptr);
      }
      INFO(name_of(estimator) << ", failed " << record.failed.size());
      REQUIRE(!record.failed.empty());
      REQUIRE(record.failed.size() < spec.response.samples);
      const auto repeat = [&](std::uint64_t sample) {
        std::istringstream words(replay_command(spec, sample));
        std::vector<std::string> arguments;
        for (std::string word; words >> word;) arguments.push_back(word);
        REQUIRE(arguments.front() == "granuscope");
        arguments.erase(arguments.begin());
        arguments.back() = replayed.string();
        return granuscope_command(arguments);
      };
      std::set<std::uint64_t> failed;
      for (const FailedSample& one : record.failed) {
        failed.insert(one.sample);
        CHECK(one.replay == replay_command(spec, one.sample));
        const auto result = repeat(one.sample);
        CHECK(result.code == 2);
        CHECK_THAT(result.err, Contains(fmt::format("it got stuck in layer {})", one.layer)));
      }
      for (std::uint64_t sample = 0; sample < 64; ++sample) {
        if (failed.contains(sample)) continue;
        CHECK(repeat(sample).code == 0);
        const Pile pile = read_pile(replayed);
        CHECK(pile.sample == sample);
        const double load = pile.load[static_cast<std::size_t>(pile.lattice.middle())];
        CHECK((estimator == EstimatorName::multiplexed ? std::abs(load - 1) == 0.5 : load == 3));
        break;
      }
    }
  }
  const auto refused = granuscope_command({"sample", "--load", "multiplexed", "--statistics", "--samples", "64"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("--load uniform or point"));
  CHECK(granuscope_command({"sample", "--opposite", "--out", "x.h5"}).code == 2);
}

TEST_CASE("A load is one of those that the help names, and an overload that nothing bears is refused") {
  const test::TemporaryFolder folder;
  const std::string pile = (folder / "pile.h5").string();
  const auto drawn = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"sample", "--mu", "0.3", "--columns", "20", "--layers", "24", "--out", pile});
    return granuscope_command(words);
  };
  CHECK_THAT(drawn({"--load", "Point"}).err, Contains("uniform,point,paired,multiplexed"));
  CHECK_THAT(drawn({"--overload", "3"}).err, Contains("give --load point"));
  CHECK(drawn({"--load", "point", "--overload", "3"}).code == 0);
  // The pile under the uniform load that an ensemble compares with: its command runs.
  EnsembleSpec spec;
  spec.response.overload = 3;
  spec.load = Load::uniform;
  CHECK(replay_command(spec, 0).find("--load uniform") != std::string::npos);
  CHECK(replay_command(spec, 0).find("--overload") == std::string::npos);
  spec.load = Load::point;
  CHECK(replay_command(spec, 0).find("--overload 3 ") != std::string::npos);
}
