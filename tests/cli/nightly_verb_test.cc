// nightly, history and compare as cron and CI meet them.
#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): SIGKILL
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/in_process.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string program = std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope";

std::string write_config(const test::TemporaryFolder& scratch) {
  std::ofstream(scratch / "small.toml") << one_plot_text;
  return (scratch / "small.toml").string();
}

}  // namespace

TEST_CASE("A night says nothing while all is well, alarms with 1, and is told by history") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch), folder = (scratch / "nights").string();
  const auto night = [&](const std::vector<std::string>& more = {}) {
    ProcessSpec spec;
    spec.arguments = {program, "nightly", config, "--history", folder, "-j", "2"};
    spec.arguments.insert(spec.arguments.end(), more.begin(), more.end());
    return run_process(spec);
  };
  const ProcessResult first = night();
  CHECK(first.exit_code == 0);
  CHECK(first.standard_error.empty());
  CHECK(first.standard_output.empty());
  const ProcessResult alarmed = night({"--set", "sampling.seed=77"});
  CHECK(alarmed.exit_code == 1);
  CHECK(alarmed.standard_error.empty());
  CHECK_THAT(alarmed.standard_output, Contains("experiment (open): "));
  CHECK_THAT(read_file(scratch / "nights/alert.md"), Contains("sampling.seed = 77 where 1 was"));

  const CommandResult list = granuscope_command({"history", folder, "list"});
  CHECK(list.code == 0);
  CHECK_THAT(list.out, Contains("1 ") && Contains("fine, 256 samples") && Contains("experiment (open)"));
  const auto shown = nlohmann::json::parse(granuscope_command({"history", folder, "show", "1"}).out);
  CHECK(shown["nights"][0]["numbers"][0]["name"] == "c at mu = 0");
  const std::string csv = granuscope_command({"history", folder, "export", "--format", "csv"}).out;
  CHECK_THAT(csv, Contains("night,date,status,samples,name,value,stderr") && Contains("c_thrust at mu = 0.3"));
  CHECK(granuscope_command({"history", folder, "accept", "2"}).code == 0);
  CHECK_FALSE(fs::exists(scratch / "nights/alert.md"));
  CHECK(granuscope_command({"history", folder, "forget", "2"}).code == 0);
  CHECK(granuscope_command({"history", folder, "show", "2"}).code == 2);
  CHECK(granuscope_command({"history", folder, "show"}).code == 2);
  CHECK(granuscope_command({"history", scratch.path().string(), "list"}).code == 2);

  const int lock = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  REQUIRE(::flock(lock, LOCK_EX | LOCK_NB) == 0);
  const ProcessResult busy = night();
  CHECK(busy.exit_code == 5);
  CHECK_THAT(busy.standard_error, Contains("choose another folder"));
  CHECK(granuscope_command({"history", folder, "forget", "1"}).code == 5);
  ::close(lock);
  CHECK(night({"--grow", "0"}).exit_code == 2);
  const CommandResult run = granuscope_command({"run", config, "--out", folder});
  CHECK(run.code == 2);
  CHECK_THAT(run.err, Contains("folder of a history"));
}

TEST_CASE("A night without gnuplot has its numbers, and ends with 3") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch), folder = (scratch / "nights").string();
  const test::SearchPath none((scratch / "no-programs").string());
  const CommandResult night = granuscope_command({"nightly", config, "--history", folder, "--grow", "10", "--verbose"});
  CHECK(night.code == 3);
  CHECK_THAT(night.out, Contains("report (open): ") && Contains("gnuplot is not installed"));
  CHECK_THAT(night.err, Contains("--grow 10 is rounded up to 256"));
  CHECK_THAT(granuscope_command({"history", folder, "show", "1"}).out, Contains("c at mu = 0.3"));
}

TEST_CASE("A night that is killed is gone on with by the next one, to the same pool", "[long]") {
  const test::TemporaryFolder killed, whole;
  const auto night = [&](const test::TemporaryFolder& scratch) {
    ProcessSpec spec;
    spec.arguments = {program, "nightly", write_config(scratch), "--history", (scratch / "nights").string()};
    return run_process(spec).exit_code;
  };
  REQUIRE(night(whole) == 0);
  REQUIRE(night(whole) == 0);
  for (int n = 0; n < 2; ++n) {
    {
      // While the figure of the pool is plotted, when the pool's ensembles have grown.
      const test::FakePrograms programs(killed / "programs");
      programs.only("gnuplot", "kill -KILL $PPID");
      REQUIRE(night(killed) == 128 + SIGKILL);
    }
    const std::string listed = granuscope_command({"history", (killed / "nights").string(), "list"}).out;
    CHECK(std::count(listed.begin(), listed.end(), '\n') == n);
    REQUIRE(night(killed) == 0);
  }
  for (const char* file : {"summary.json", "ensembles/mu-0.3.h5", "figures/response-profiles.svg"}) {
    INFO(file);
    CHECK((read_file(killed / "nights/pool" / file) == read_file(whole / "nights/pool" / file)));
  }
  const auto numbers = [](const test::TemporaryFolder& scratch) {
    auto json = nlohmann::json::parse(granuscope_command({"history", (scratch / "nights").string(), "show", "2"}).out);
    return json["nights"][0]["numbers"];
  };
  CHECK(numbers(killed) == numbers(whole));
}

TEST_CASE("compare answers in one line and, as a gate, by its status") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch);
  const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", config, "--quiet", "--out", (scratch / name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    REQUIRE(granuscope_command(arguments).code == 0);
    return (scratch / name).string();
  };
  const std::string one = run("one", {}), two = run("two", {"-j", "1"});
  const std::string seed = run("seed", {"--set", "sampling.seed=5"}),
                    wide = run("wide", {"--set", "lattice.columns=62"});
  CommandResult result = granuscope_command({"compare", one, two, "--gate"});
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Matchers::StartsWith("same: every value and error is equal"));
  result = granuscope_command({"compare", one, seed, "--gate", "--json", (scratch / "a.json").string()});
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Matchers::StartsWith("same experiment but for sampling.seed = 5 where 1 was"));
  CHECK(nlohmann::json::parse(read_file(scratch / "a.json"))["likeness"] == "other samples");
  CHECK(granuscope_command({"compare", one, wide}).code == 0);
  result = granuscope_command({"compare", one, wide, "--gate"});
  CHECK(result.code == 1);
  CHECK_THAT(result.out, Contains("other experiments: lattice.columns = 62 where 60 was"));
  CHECK(granuscope_command({"compare", one, (scratch / "none").string()}).code == 2);
}
