#include "cli/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>

#include "cli/in_process.h"
#include "experiment/experiment_file.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

TEST_CASE("Help and version are results, on standard output, with status 0") {
  for (const char* help : {"--help", "-h"}) {
    const auto result = granuscope_command({help});
    CHECK(result.code == 0);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("Exit status: 0 all was made") && Contains("sample") && Contains("doctor"));
    CHECK_THAT(result.out, !Contains("reference"));  // for maintainers
  }
  CHECK_THAT(granuscope_command({"--version"}).out, StartsWith("granuscope 0."));
  for (const char* verb : {"run", "sample", "render", "audit", "doctor"}) {
    INFO(verb);
    const auto result = granuscope_command({verb, "--help"});
    CHECK(result.code == 0);
    CHECK_THAT(result.out, Contains(std::string("granuscope ") + verb));
  }
}

TEST_CASE("The help of a verb states units and defaults") {
  const std::string help = granuscope_command({"sample", "--help"}).out;
  CHECK_THAT(help, (Contains("--columns INT=500") || Contains("--columns INT [500]")) &&  // of CLI11 2.1 and of 2.4
                       (Contains("--mu FLOAT=0.1") || Contains("--mu FLOAT [0.1]")) && Contains("sqrt(3)"));
}

TEST_CASE("Bad usage is status 2 with one message and no output") {
  const std::vector<std::vector<std::string>> misuses{
      {"nonsense"},
      {"--nonsense"},
      {"sample", "--nonsense"},
      {"sample", "surplus"},
      {"sample", "--mu"},
      {"sample", "--mu", "much", "--statistics"},
      {"sample", "--columns", "99999999999", "--statistics"},
      {"sample", "--columns", "1e3", "--statistics"},
      {"sample", "--samples", "-4", "--statistics"},
      {"sample", "--seed", "-1", "--statistics"},
      {"sample", "--threads", "-1", "--statistics"},
      {"sample"},
      {"audit"},
      {"audit", "one", "two"},
      {"run"},
      {"render"},
  };
  for (const auto& arguments : misuses) {
    INFO(fmt::format("{}", fmt::join(arguments, " ")));
    const auto result = granuscope_command(arguments);
    CHECK(result.code == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, StartsWith("granuscope: "));
    CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  }
}

TEST_CASE("A mistyped verb is answered with the nearest one") {
  CHECK_THAT(granuscope_command({"sampel"}).err, Contains("there is no verb \"sampel\"; did you mean sample?"));
  CHECK_THAT(granuscope_command({"zzzzzzzzzz"}).err, Contains("the verbs are run, ") && Contains(", doctor, "));
  CHECK_THAT(granuscope_command({"help", "sampel"}).err, Contains("did you mean sample?"));
}

TEST_CASE("Output that cannot be written is an error of the environment") {
  std::ofstream full("/dev/full");
  std::ostringstream err;
  const char* argv[] = {"granuscope", "reference"};
  CHECK(run_command_line(2, argv, full, err) == 3);
  for (const char* result : {"--help", "--version"}) {
    std::ofstream also_full("/dev/full");
    const char* words[] = {"granuscope", result};
    CHECK(run_command_line(2, words, also_full, err) == 3);
  }
  CHECK_THAT(err.str(), Contains("standard output cannot be written"));
}

std::string document(const std::string& name) {
  std::ifstream file(GRANUSCOPE_SOURCE_DIR + ("/" + name));
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_CASE("docs/reference.md shows the program's own table of keys") {
  const auto result = granuscope_command({"reference"});
  CHECK(result.code == 0);
  CHECK(result.out == describe_experiment_keys());
  INFO("docs/reference.md is out of date: `make -f Makefile.docs reference` renews it");
  CHECK(document("docs/reference.md").find(result.out) != std::string::npos);
}

TEST_CASE("README is short, and every document that it names is there") {
  const std::string text = document("README.md");
  CHECK(std::count(text.begin(), text.end(), '\n') <= 120);
  for (const char* name : {"guide", "results", "performance", "reference"}) {
    const std::string path = fmt::format("docs/{}.md", name);
    INFO(path);
    CHECK_THAT(text, Contains(path));
    CHECK(document(path).size() > 1000);
  }
}

TEST_CASE("The reference of verbs holds every flag that --help of a verb lists") {
  const auto reference = granuscope_command({"reference", "--verbs"});
  CHECK(reference.code == 0);
  for (const std::string verb : {"run", "sample", "render", "audit", "doctor"}) {
    const auto begin = reference.out.find("### granuscope " + verb + "\n");
    REQUIRE(begin != std::string::npos);
    const std::string section = reference.out.substr(begin, reference.out.find("\n### ", begin) - begin);
    std::istringstream help(granuscope_command({verb.c_str(), "--help"}).out);
    int flags = 0;
    for (std::string line; std::getline(help, line);) {
      std::string flag;
      std::istringstream(line) >> flag;
      if (flag.empty() || flag[0] != '-') continue;
      INFO(verb << ' ' << flag);
      CHECK_THAT(section, Contains("| `" + flag + "` |"));
      ++flags;
    }
    CHECK(flags > 0);
  }
  CHECK_THAT(reference.out, !Contains("### granuscope reference"));
}

TEST_CASE("doctor names what it looked at") {
  const auto result = granuscope_command({"doctor"});
  CHECK((result.code == 0 || result.code == 3));
  for (const char* subject : {"OpenGL", "fonts", "gnuplot", "weasyprint", "results", "machine"}) {
    CHECK_THAT(result.out, Contains(subject));
  }
  if (result.code == 3) CHECK_THAT(result.out, Contains("\n--") || StartsWith("--"));
}

TEST_CASE("doctor refuses a folder where nothing can be written") {
  const auto result = granuscope_command({"doctor", "--out", "/dev/null/results"});
  CHECK(result.code == 3);
  CHECK_THAT(result.out, Contains("choose another --out"));
}
