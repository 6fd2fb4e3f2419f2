// The scripts at the top, called the way that does nothing, with a word they do not know; and how ./check reads the
// logs of tests.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "kit/temporary_folder.h"

namespace fs = std::filesystem;
using namespace granuscope;

namespace {

/// What the functions of cmake/test_log.sh print, called as `command` where $log is a file that holds `log`.
std::string said_of(const std::string& log, const std::string& command) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "log") << log;
  const std::string line =
      "log='" + (folder / "log").string() + "'; . '" GRANUSCOPE_SOURCE_DIR "/cmake/test_log.sh'; " + command;
  std::ofstream(folder / "script") << "set -euo pipefail\n" << line << '\n';
  const int status = std::system(  // NOLINT(concurrency-mt-unsafe): nothing else runs
      ("bash '" + (folder / "script").string() + "' >'" + (folder / "said").string() + "'").c_str());
  REQUIRE(status == 0);
  std::ostringstream said;
  said << std::ifstream(folder / "said").rdbuf();
  return said.str();
}

}  // namespace

TEST_CASE("the scripts find their folder from elsewhere and through a link") {
  const test::TemporaryFolder folder;
  const fs::path scratch = folder / "with a space";
  fs::create_directories(scratch);
  for (const char* script : {"reproduce", "check"}) {
    CAPTURE(script);
    fs::create_symlink(fs::path(GRANUSCOPE_SOURCE_DIR) / script, scratch / script);
    for (const fs::path& name : {fs::path(GRANUSCOPE_SOURCE_DIR) / script, scratch / script}) {
      const std::string command =
          "cd / && '" + name.string() + "' unknown-word >'" + (scratch / "said").string() + "' 2>&1";
      const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): nothing else runs
      REQUIRE(WIFEXITED(status));
      CHECK(WEXITSTATUS(status) == 2);  // usage
    }
  }
}

TEST_CASE("stages of the Dockerfile stand on each other, copy what is there, and have commands that bash reads") {
  std::ostringstream text;
  text << std::ifstream(GRANUSCOPE_SOURCE_DIR "/Dockerfile").rdbuf();
  std::istringstream lines(std::regex_replace(text.str(), std::regex("\\\\\n"), " "));
  const test::TemporaryFolder folder;
  std::set<std::string> stages;
  for (std::string line; std::getline(lines, line);) {
    CAPTURE(line);
    std::istringstream words(line);
    std::string instruction, first, as, name;
    words >> instruction >> first >> as >> name;
    if (instruction == "FROM") {
      CHECK((first == "debian:12-slim" || stages.contains(first)));
      stages.insert(name);
    } else if (instruction == "COPY" && first.starts_with("--from=")) {
      CHECK(stages.contains(first.substr(7)));
    } else if (instruction == "COPY") {
      CHECK(fs::exists(fs::path(GRANUSCOPE_SOURCE_DIR) / first));
    } else if (instruction == "RUN") {
      std::ofstream(folder / "run") << line.substr(4) << '\n';
      const int status = std::system(  // NOLINT(concurrency-mt-unsafe): nothing else runs
          ("bash -n '" + (folder / "run").string() + "'").c_str());
      CHECK(status == 0);
    }
  }
  CHECK(stages == std::set<std::string>{"build", "gl", "pdf", "slim"});
}

TEST_CASE("the slowest cases are named with their run and program, and cases are counted") {
  const std::string log = R"(Start testing
1/3 Test: model
Command: "test_model" "-d" "yes"
0.002 s: One: with a colon
12.500 s: 10 beads
All tests passed (5 assertions in 2 test cases)

2/3 Test: plot.long
3.000 s: Three
0.500 s: a section
3.500 s: Three
not a time: 99.0 s: words
test cases: 4 | 1 passed | 3 failed
3/3 Test: cli
100.250 s: The last word of a program that crashed
)";
  CHECK(said_of(log, "counts_of \"$log\"") == "3 4\n");
  CHECK(said_of(log, "case_times release quick \"$log\" | slowest_cases 3") ==
        "   100.2 s  release quick, cli: The last word of a program that crashed\n"
        "    12.5 s  release quick, model: 10 beads\n"
        "     6.5 s  release quick, plot.long: Three\n");
  CHECK(said_of("", "case_times release quick \"$log\" | slowest_cases 3").empty());
}
