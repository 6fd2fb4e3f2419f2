#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/in_process.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace fs = std::filesystem;

namespace {

fs::path write_config(const test::TemporaryFolder& scratch, const std::string& text) {
  std::ofstream(scratch / "small.toml") << text;
  return scratch / "small.toml";
}

}  // namespace

TEST_CASE("run --print-config prints the resolved experiment and runs nothing") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result =
      granuscope_command({"run", config.string(), "--print-config", "--out", (scratch / "out").string()});
  REQUIRE(result.code == 0);
  CHECK(result.out == print_experiment(read_experiment(config)));
  CHECK(print_experiment(parse_experiment(result.out, "printed")) == result.out);
  CHECK_FALSE(fs::exists(scratch / "out"));
}

TEST_CASE("run --dry-run tells stages and cost and runs nothing") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "out").string()});
  REQUIRE(result.code == 0);
  CHECK_THAT(result.out, Contains("sample") && Contains("analyse") && Contains("report") && Contains("beads to draw") &&
                             Contains("by a trial of the first piles"));
  CHECK_FALSE(fs::exists(scratch / "out"));
}

TEST_CASE("run leaves the documented files, the same numbers for every number of threads, and resumes") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text + no_pdf);
  const auto first =
      granuscope_command({"run", config.string(), "--threads", "1", "--out", (scratch / "one").string()});
  INFO(first.err);
  REQUIRE(first.code == 0);
  for (const char* name : {"experiment.toml", "manifest.json", "ensembles", "piles", "figures", "summary.json",
                           "claims.xml", "summary.md", "report.html"}) {
    INFO(name);
    CHECK(fs::exists(scratch / "one" / name));
  }
  CHECK(parse_experiment(read_file(scratch / "one" / "experiment.toml"), "resolved").lattice.columns == 120);
  const json summary = json::parse(read_file(scratch / "one" / "summary.json"));
  CHECK(summary["schema"] == 3);
  CHECK(summary["experiment"] == "small");
  REQUIRE(summary["results"].size() == 4);
  CHECK(summary["results"][1]["samples"] == 256);

  REQUIRE(granuscope_command({"run", config.string(), "--threads", "2", "--out", (scratch / "two").string()}).code ==
          0);
  CHECK(read_file(scratch / "one" / "summary.json") == read_file(scratch / "two" / "summary.json"));

  // Again in the same folder: everything that takes time is there already.
  const auto nothing = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "one").string()});
  CHECK_THAT(nothing.out, Contains("nothing would be done"));
  const auto plan = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "one").string(),
                                        "--set", "report.headline=other words"});
  for (const char* mu : {"0", "0.2", "0.3", "0.4"})
    CHECK_THAT(plan.out, Contains(std::string("mu = ") + mu + " (there already)"));
  const std::string before = read_file(scratch / "one" / "summary.json");
  REQUIRE(granuscope_command({"run", config.string(), "--out", (scratch / "one").string()}).code == 0);
  CHECK(read_file(scratch / "one" / "summary.json") == before);
}

TEST_CASE("run --only sample stops after the ensembles") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result =
      granuscope_command({"run", config.string(), "--only", "sample", "--out", (scratch / "out").string()});
  INFO(result.err);
  REQUIRE(result.code == 0);
  CHECK(fs::exists(scratch / "out" / "ensembles"));
  CHECK_FALSE(fs::exists(scratch / "out" / "report.html"));
  const auto unknown = granuscope_command({"run", config.string(), "--only", "smaple"});
  CHECK(unknown.code == 2);
}

TEST_CASE("run --gate ends with 1 if a verdict is not the expected one") {
  const test::TemporaryFolder scratch;
  // Without friction rays go straight, exactly: the opposite is expected here.
  const auto config =
      write_config(scratch, smallest_experiment_text + no_pdf + "[gate.expect]\nfrictionless = \"not reproduced\"\n");
  const std::vector<std::string> command{"run", config.string(), "--out", (scratch / "out").string()};
  CHECK(granuscope_command(command).code == 0);
  auto gated = command;
  gated.push_back("--gate");
  const auto result = granuscope_command(gated);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Contains("frictionless"));
  // Without an analysis there is no verdict to compare: that must not look like a pass.
  gated.insert(gated.end(), {"--only", "sample"});
  CHECK(granuscope_command(gated).code == 2);
}

TEST_CASE("run refuses what it cannot read before it writes anything") {
  const test::TemporaryFolder scratch;
  const std::vector<std::string> bad{"[lattice]\ncolums = 500\n", "[lattice\n", "[friction]\nmu = [2.0]\n"};
  for (const std::string& text : bad) {
    const auto config = write_config(scratch, text);
    const auto result = granuscope_command({"run", config.string(), "--out", (scratch / "out").string()});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("small.toml:"));
    CHECK_FALSE(fs::exists(scratch / "out"));
  }
  CHECK(granuscope_command({"run", (scratch / "missing.toml").string()}).code == 2);
  CHECK(granuscope_command({"run", scratch.path().string()}).code == 2);
  const auto config = write_config(scratch, "[report]\npdf = false\n");
  CHECK(granuscope_command({"run", config.string(), "--require-pdf"}).code == 2);
}

TEST_CASE("run tells a folder that cannot be written as an error of the environment") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  CHECK(granuscope_command({"run", config.string(), "--out", "/dev/null/results"}).code == 3);
  std::ofstream(scratch / "file") << "in the way";
  CHECK(granuscope_command({"run", config.string(), "--out", (scratch / "file").string()}).code == 3);
}
