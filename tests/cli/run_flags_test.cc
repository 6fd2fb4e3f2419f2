// Flags of `run` for machines.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iostream>
#include <sstream>

#include "cli/flag_checks.h"
#include "cli/in_process.h"
#include "experiment/experiment_file.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

std::string write_config(const test::TemporaryFolder& scratch, const std::string& text) {
  std::ofstream(scratch / "small.toml") << text;
  return (scratch / "small.toml").string();
}

Experiment resolved(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "run");
  arguments.emplace_back("--print-config");
  const CommandResult result = granuscope_command(arguments);
  INFO(result.err);
  REQUIRE(result.code == 0);
  return parse_experiment(result.out, "resolved");
}

/// Standard input for the time of one command.
class Input {
 public:
  explicit Input(const std::string& text) : text_(text), before_(std::cin.rdbuf(text_.rdbuf())) {}
  ~Input() { std::cin.rdbuf(before_); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

 private:
  std::istringstream text_;
  std::streambuf* before_;
};

}  // namespace

TEST_CASE("run --set replaces what the file says, and is checked as it") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, small_experiment_text);
  const Experiment set = resolved({config, "--set", "response.samples=512", "--set", "friction.mu = [0.3]", "--set",
                                   "response.estimator=paired", "--set", "experiment.name=two words"});
  CHECK(set.response.samples == 512);
  CHECK(set.mu == std::vector<double>{0.3});
  CHECK(set.response.estimator == EstimatorName::paired);
  CHECK(set.name == "two words");
  CHECK(set.lattice.columns == 120);  // as in the file
  CHECK(resolved({config, "--set", "response.samples=512", "--set", "response.samples=768"}).response.samples == 768);

  const auto refused = [&](const std::string& assignment) {
    const CommandResult result = granuscope_command({"run", config, "--print-config", "--set", assignment});
    CHECK(result.code == 2);
    return result.err;
  };
  CHECK_THAT(refused("response.sample=512"), Contains("--set response.sample=512") && Contains("response.samples"));
  CHECK_THAT(refused("response.samples=many"), Contains("--set response.samples=many") && Contains("whole number"));
  CHECK_THAT(refused("response.samples=8"), Contains("--set response.samples=8"));
  CHECK_THAT(refused("response.samples"), Contains("sets no key"));
  CHECK_THAT(refused("lattice=7"), Contains("must be a table"));
  CHECK_THAT(refused("response.samples=512\n[fit]"), Contains("sets no key"));
  CHECK_THAT(refused("experiment.name='it's'"), Contains("not valid TOML"));
}

TEST_CASE("run - reads the experiment from standard input, and needs a name for the folder") {
  {
    const Input input(small_experiment_text);
    CHECK(resolved({"-"}).lattice.columns == 120);
  }
  {
    const Input input(small_experiment_text);
    const CommandResult result = granuscope_command({"run", "-"});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("--out"));
  }
  const Input input("[lattice]\ncolums = 3\n");
  const CommandResult result = granuscope_command({"run", "-", "--print-config"});
  CHECK(result.code == 2);
  CHECK_THAT(result.err, Contains("standard input:2:1"));
}

TEST_CASE("run --set takes words as people write them") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, "[lattice]\ncolumns = 120\n");
  for (const std::string name : {"The pile of Breton's paper", "a # b", "C:\\piles [new]", "say \"when\""}) {
    CHECK(resolved({config, "--set", "experiment.name=" + name}).name == name);
  }
  CHECK(resolved({config, "--set", "response.samples=1e3"}).response.samples == 1000);
  const auto refused = [&](const std::string& assignment) {
    return granuscope_command({"run", config, "--print-config", "--set", assignment}).err;
  };
  CHECK_THAT(refused("experiment.name='half"), Contains("double quotes"));
  CHECK_THAT(refused("sampling.bead_weight=0,3"), Contains("decimal comma"));
}

TEST_CASE("run reads what the shell has opened for it") {
  const test::TemporaryFolder scratch;
  int ends[2] = {};
  REQUIRE(::pipe(ends) == 0);
  const std::string text = "[lattice]\ncolumns = 130\n";
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  const std::string pipe = "/dev/fd/" + std::to_string(ends[0]);
  CHECK_THAT(granuscope_command({"run", pipe, "--dry-run"}).err, Contains("--out"));  // whose name names no folder
  ::close(ends[0]);
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  CHECK(resolved({"/dev/fd/" + std::to_string(ends[0])}).lattice.columns == 130);
  ::close(ends[0]);
}

TEST_CASE("an experiment without any key is refused") {
  const test::TemporaryFolder scratch;
  for (const char* text : {"", "# cut\n", "[lattice]\n"}) {
    const CommandResult result = granuscope_command({"run", write_config(scratch, text), "--print-config"});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("there is no key in it"));
  }
  CHECK(granuscope_command({"run", write_config(scratch, "[report]\npdf = false\n"), "--print-config"}).code == 0);
}

TEST_CASE("run --print-key names the experiment in one line") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, small_experiment_text);
  const auto key = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", config, "--print-key"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = granuscope_command(arguments);
    REQUIRE(result.code == 0);
    CHECK(std::count(result.out.begin(), result.out.end(), '\n') == 1);
    return result.out;
  };
  CHECK(key({}) == key({"--threads", "3"}));
  CHECK(key({}) == key({"--set", "lattice.columns=120"}));
  CHECK(key({}) != key({"--set", "lattice.columns=121"}));
}

TEST_CASE("a folder at work ends with 5, and --quiet says nothing") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, smallest_experiment_text), out = (scratch / "out").string();
  ProcessSpec spec;
  spec.arguments = {std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope",
                    "run",
                    config,
                    "--out",
                    out,
                    "--quiet",
                    "-j",
                    "2",
                    "--only",
                    "plot"};
  const ProcessResult quiet = run_process(spec);
  CHECK(quiet.exit_code == 0);
  CHECK(quiet.standard_error.empty());
  CHECK(fs::exists(scratch / "out/figures/response-profiles.svg"));

  const int folder = ::open(out.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  REQUIRE(::flock(folder, LOCK_EX | LOCK_NB) == 0);
  const CommandResult busy = granuscope_command({"run", config, "--out", out});
  ::close(folder);
  CHECK(busy.code == 5);
  CHECK_THAT(busy.err, Contains("another run or shard is working"));
}

TEST_CASE("run --keep-going loses only what the machine lacks") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, smallest_experiment_text + "show = false\n[report]\npdf = false\n");
  const test::SearchPath none((scratch / "no-programs").string());
  const std::string out = (scratch / "out").string();
  const CommandResult stopped = granuscope_command({"run", config, "--out", out});
  CHECK(stopped.code == 3);
  CHECK_FALSE(fs::exists(scratch / "out/ensembles"));
  const CommandResult result = granuscope_command({"run", config, "--out", out, "--keep-going"});
  CHECK(result.code == 3);
  CHECK_THAT(result.err, Contains("gnuplot is not installed"));
  CHECK(fs::exists(scratch / "out/summary.json"));
  CHECK_THAT(read_file(scratch / "out/report.html"), Contains("gnuplot is not installed"));
}

TEST_CASE("more memory than there is is refused in words") {
  CHECK_NOTHROW(require_memory(1e6));
  CHECK_THROWS_AS(require_memory(1e18), EnvironmentError);
}
