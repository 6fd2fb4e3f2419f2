// The command line, and text that is ready to copy.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "cli/command_line.h"
#include "cli/in_process.h"
#include "experiment/experiment_file.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
namespace fs = std::filesystem;

TEST_CASE("Help and version are results, on standard output, with status 0") {
  for (const char* help : {"--help", "-h"}) {
    const auto result = granuscope_command({help});
    CHECK(result.code == 0);
    CHECK(result.err.empty());
    CHECK_THAT(result.out, Contains("Exit status: 0 all was made") && Contains("sample") && Contains("doctor"));
    CHECK_THAT(result.out, Contains("reference") && Contains("new"));
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
      {"sample", "--columns", "1.5e1.5", "--statistics"},
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

TEST_CASE("Every flag for a whole number takes one as people write it, and signs of other places are named",
          "[unsanitized]") {
  const test::TemporaryFolder folder;
  CHECK_THAT(granuscope_command({"new", "--mu", "0.3", "--layers", "1e2"}).out, Contains("layers = 100 "));
  CHECK_THAT(granuscope_command({"new", "--mu", "0.3", "--layers", "64.0"}).out, Contains("layers = 64 "));
  for (const char* written : {"6_4", "+64", "0x40", "0o100", "0b1000000", " 64 ", "6.4e1"}) {
    INFO(written);
    CHECK_THAT(granuscope_command({"new", "--mu", "0.3", "--layers", written}).out, Contains("layers = 64 "));
    CHECK_THAT(granuscope_command({"sample", "--columns", written, "--layers", written, "--band", "0,64",
                                   "--statistics", "--distributions", "none.csv"})
                   .err,
               Contains("and the pile has 0 to 63"));
  }
  for (const char* written : {"64.5", "6__4", "_64", "64_", "0x", "0x-4", "0x4.0", "1e-1", "++64"}) {
    INFO(written);
    CHECK(granuscope_command({"new", "--mu", "0.3", "--layers", written}).code == 2);
    CHECK(granuscope_command({"sample", "--columns", written, "--out", "none.h5"}).code == 2);
  }
  CHECK_THAT(granuscope_command({"nightly", "none.toml", "--history", "h", "--grow", "1e3", "--keep", "1e1"}).err,
             Contains("none.toml: there is no such file"));
  CHECK_THAT(granuscope_command({"history", folder.path().string(), "show", "1.0"}).err, Contains("no history"));
  CHECK_THAT(granuscope_command({"render", "p.h5", "p.png", "--window=\u22125,5,0,3"}).err,
             Contains("--window=\u22125,5,0,3: there is the sign U+2212"));
}

TEST_CASE("A mistyped verb is answered with the nearest one") {
  CHECK_THAT(granuscope_command({"sampel"}).err, Contains("there is no verb \"sampel\"; did you mean sample?"));
  CHECK_THAT(granuscope_command({"zzzzzzzzzz"}).err, Contains("the verbs are new, run, ") && Contains(", doctor, "));
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
}

TEST_CASE("doctor names what it looked at") {
  const auto result = granuscope_command({"doctor"});
  CHECK((result.code == 0 || result.code == 3));
  for (const char* subject : {"OpenGL", "fonts", "gnuplot", "weasyprint", "results", "machine"}) {
    CHECK_THAT(result.out, Contains(subject));
  }
  if (result.code == 3) CHECK_THAT(result.out, Contains("\n--") || StartsWith("--"));
  // What ends every run ends this, too.
  const test::TemporaryFolder folder;
  write_file(folder / "ssl.cnf", "openssl_conf = a\n[a]\nproviders = b\n[b]\nlegacy = c\n[c]\nactivate = 1\n");
  ProcessSpec spec;
  spec.arguments = {std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope", "doctor"};
  spec.environment = {{"OPENSSL_CONF", (folder / "ssl.cnf").string()}};
  const ProcessResult without = run_process(spec);
  CHECK(without.exit_code == 3);
  CHECK_THAT(without.standard_error, Contains("check OPENSSL_CONF"));
  for (const char* extra : {"ffmpeg", "latex"}) {
    const std::size_t at = result.out.find(std::string(extra) + ", which");
    REQUIRE(at != std::string::npos);
    CHECK(result.out.substr(result.out.find(", is ", at)).starts_with(", is here") == find_program(extra).has_value());
  }
}

TEST_CASE("doctor refuses a folder where nothing can be written") {
  const auto result = granuscope_command({"doctor", "--out", "/dev/null/results"});
  CHECK(result.code == 3);
  CHECK_THAT(result.out, Contains("choose another --out"));
}

// The commands in examples/nightly, examples/ci and the Snakefile of examples/cluster, taken out of these files and
// run.

namespace {

std::vector<std::string> lines_of(const std::string& file) {
  std::vector<std::string> lines;
  std::istringstream text(read_file(fs::path(GRANUSCOPE_SOURCE_DIR) / "examples" / file));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

std::size_t indent_of(const std::string& line) { return line.find_first_not_of(' '); }

/// What stands below "run: |" of each step.
std::vector<std::string> github_commands(const std::string& file) {
  std::vector<std::string> commands;
  std::size_t inside = 0;
  for (const std::string& line : lines_of(file)) {
    if (inside > 0 && indent_of(line) > inside) {
      commands.back() += line.substr(indent_of(line)) + "\n";
      continue;
    }
    inside = 0;
    if (const std::size_t at = line.find("run: |"); at != std::string::npos) {
      inside = indent_of(line);
      commands.emplace_back();
    }
  }
  return commands;
}

std::vector<std::string> gitlab_commands() {
  std::vector<std::string> commands;
  bool inside = false;
  for (const std::string& line : lines_of("ci/gitlab.yml")) {
    if (inside && line.starts_with("    - "))
      commands.push_back(line.substr(6));
    else
      inside = line == "  script:";
  }
  return commands;
}

/// The command of a rule of the Snakefile, with what Snakemake puts into its braces.
std::string snakemake_command(const std::string& rule, const std::map<std::string, std::string>& values) {
  bool inside = false;
  for (const std::string& line : lines_of("cluster/Snakefile")) {
    if (line.starts_with("rule ")) inside = line == "rule " + rule + ":";
    const std::size_t at = line.find("shell: \"");
    if (!inside || at == std::string::npos) continue;
    std::string command = line.substr(at + 8, line.rfind('"') - at - 8);
    for (const auto& [name, value] : values) {
      // {NAME:q} is quoted for the shell.
      for (const auto& [place, text] :
           {std::pair("{" + name + "}", value), std::pair("{" + name + ":q}", "'" + value + "'")}) {
        for (std::size_t i = command.find(place); i != std::string::npos; i = command.find(place)) {
          command.replace(i, place.size(), text);
        }
      }
    }
    return command;
  }
  return "false";
}

/// Runs it as a shell of the machine would, with the program found by its name.
ProcessResult in_shell(const fs::path& folder, const std::string& command,
                       std::map<std::string, std::string> environment = {}) {
  ProcessSpec spec;
  spec.arguments = {"sh", "-e", "-c", command};
  spec.working_folder = folder;
  environment.try_emplace("PATH", std::string(GRANUSCOPE_BINARY_DIR) + ":/usr/bin:/bin");
  environment.try_emplace("HOME", folder.string());
  environment["EXPERIMENT"] = "experiment.toml";
  spec.environment = std::move(environment);
  return run_process(spec);
}

const std::string experiment_text = smallest_experiment_text + "show = false\n[report]\npdf = false\n";

}  // namespace

TEST_CASE("The commands of the CI examples leave what their other steps take", "[long]") {
  std::vector<std::string> on_github = github_commands("ci/github.yml");
  std::ranges::copy(github_commands("ci/github-nightly.yml"), std::back_inserter(on_github));
  for (const auto& commands : {on_github, gitlab_commands()}) {
    const test::TemporaryFolder folder;
    write_file(folder / "experiment.toml", experiment_text);
    REQUIRE(commands.size() >= 3);
    for (const std::string& command : commands) {
      const ProcessResult result = in_shell(
          folder.path(), command,
          {{"GITHUB_OUTPUT", (folder / "output").string()}, {"GITHUB_STEP_SUMMARY", (folder / "step").string()}});
      INFO(command << result.standard_error);
      CHECK(result.exit_code == 0);
    }
    for (const char* left : {"results/ensembles", "results/claims.xml", "results/report.html", "results/summary.json",
                             "nights/index.html", "nights/badge.json", "nights/reports"}) {
      CHECK(fs::exists(folder / left));
    }
    if (commands != on_github) continue;
    CHECK_THAT(read_file(folder / "output"), Catch::Matchers::StartsWith("key="));
    CHECK_THAT(read_file(folder / "step"), Contains("| "));
    CHECK(fs::exists(folder / "page/index.html"));
  }
  // A cache that was saved is never replaced: half of the ensembles must not be found for all of them ever after.
  const std::vector<std::string> github = lines_of("ci/github.yml");
  CHECK(std::ranges::count_if(github, [](const std::string& line) {
          return line.find("key: granuscope-${{ steps.key.outputs.key }}-${{ hashFiles('results/ensembles/**') }}") !=
                 std::string::npos;
        }) == 1);
}

TEST_CASE("The cron line, the systemd service and the lines of the page beside them run", "[long]") {
  const test::TemporaryFolder home;
  const fs::path project = home / "granuscope";
  fs::create_directories(project / "examples");
  write_file(project / "examples/quick.toml", experiment_text);
  std::string cron, service, path;
  for (const std::string& line : lines_of("nightly/crontab")) {
    if (line.starts_with("PATH=")) path = line.substr(5);
    if (!line.starts_with('#')) cron = line.substr(line.find("  cd ") + 2);
  }
  // The program of the clone is found as cron and systemd find it, though it is installed nowhere.
  fs::create_directories(project / "build");
  fs::create_directory_symlink(GRANUSCOPE_BINARY_DIR, project / "build/release");
  for (const std::string& line : lines_of("nightly/granuscope-nightly.service")) {
    if (line.starts_with("ExecSearchPath=")) CHECK_THAT(line, Contains("%h/granuscope/build/release:"));
    if (line.starts_with("ExecStart=")) service = line.substr(std::string("ExecStart=").size());
  }
  std::vector<std::pair<fs::path, std::string>> commands = {{home.path(), cron}, {project, service}};
  for (const std::string& line : lines_of("nightly/README.md")) {
    if (line.starts_with("    granuscope")) commands.emplace_back(project, line.substr(4));
  }
  REQUIRE(commands.size() >= 5);
  for (const auto& [folder, command] : commands) {
    const ProcessResult result = in_shell(folder, command, {{"HOME", home.path().string()}, {"PATH", path}});
    INFO(command << '\n' << result.standard_error);
    CHECK_FALSE(command.empty());
    CHECK(result.exit_code == 0);
  }
  CHECK(fs::exists(project / "nights/index.html"));
  CHECK(fs::exists(project / "nights/latest/report.html"));
}

TEST_CASE("The commands of the Snakefile, in its order, leave the bytes of one run", "[long]") {
  REQUIRE(lines_of("cluster/Snakefile").size() <= 25);
  const test::TemporaryFolder folder;
  write_file(folder / "experiment.toml", experiment_text);
  const auto run = [&](const std::string& command) {
    INFO(command);
    CHECK(command.find('{') == std::string::npos);  // nothing is left to fill in
    const ProcessResult result = in_shell(folder.path(), command);
    INFO(result.standard_error);
    REQUIRE(result.exit_code == 0);
  };
  std::map<std::string, std::string> values = {
      {"EXPERIMENT", "experiment.toml"}, {"OUT", "out"}, {"N", "3"}, {"threads", "1"}};
  for (const char* shard : {"3", "1", "2"}) {
    values["wildcards.k"] = shard;
    run(snakemake_command("shard", values));
    CHECK_FALSE(fs::exists(folder / "out/summary.json"));
  }
  run(snakemake_command("report", values));
  run("granuscope run experiment.toml --quiet --out one");
  for (const char* file : {"summary.json", "ensembles/mu-0.3.h5", "claims.xml"}) {
    INFO(file);
    CHECK((read_file(folder / "out" / file) == read_file(folder / "one" / file)));
  }
}

TEST_CASE("submit.sh without its arguments says what they are") {
  const test::TemporaryFolder folder;
  const ProcessResult result =
      in_shell(folder.path(), "sh " GRANUSCOPE_SOURCE_DIR "/examples/cluster/submit.sh e.toml");
  CHECK(result.exit_code == 2);
  CHECK_THAT(result.standard_error, Contains("submit.sh EXPERIMENT FOLDER [SHARDS]"));
}
