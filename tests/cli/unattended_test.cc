// What an unattended user meets: a run that is killed, a reader that has gone, flags that a script left empty.
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill and SIGKILL
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

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

const std::string binary = std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope";

std::string experiment(int seed) {
  return smallest_experiment_text + "show = false\n" + no_pdf + "[sampling]\nseed = " + std::to_string(seed) + "\n";
}

/// Runs the program with a gnuplot of our own before the system's.
ProcessResult run_with_gnuplot(const test::TemporaryFolder& scratch, const std::string& script,
                               const fs::path& config) {
  const test::FakePrograms programs(scratch / "programs");
  programs.only("gnuplot", script);
  ProcessSpec spec;
  spec.arguments = {binary, "run", config.string(), "--out", (scratch / "out").string()};
  return run_process(spec);
}

nlohmann::json manifest_in(const fs::path& folder) {
  return nlohmann::json::parse(read_file(folder / "manifest.json"));
}

}  // namespace

TEST_CASE("A killed run leaves a folder that does not claim to be finished, and forgets no time") {
  const test::TemporaryFolder scratch;
  std::ofstream(scratch / "first.toml") << experiment(1);
  std::ofstream(scratch / "second.toml") << experiment(2);
  const fs::path out = scratch / "out";
  REQUIRE(granuscope_command({"run", (scratch / "first.toml").string(), "--out", out.string()}).code == 0);
  REQUIRE(manifest_in(out)["status"] == "done");
  const std::string summary = read_file(out / "summary.json");

  const ProcessResult killed = run_with_gnuplot(scratch, "kill -KILL $PPID", scratch / "second.toml");
  CHECK(killed.exit_code == 128 + SIGKILL);
  CHECK(read_file(out / "earlier-summary.json") == summary);  // a finished result is not lost by the next one's end
  CHECK_FALSE(fs::exists(out / "report.html"));               // nor taken for that of the next one
  const auto manifest = manifest_in(out);
  CHECK(manifest["status"] == "unfinished");
  CHECK(manifest["exit_code"].is_null());
  CHECK_THAT(manifest["error"].get<std::string>(), Contains("may be of an earlier one"));
  CHECK(manifest["files"].empty());
  REQUIRE(manifest["timings"].size() >= 2);
  for (const auto& timing : manifest["timings"]) CHECK(timing["seconds"].is_number());

  REQUIRE(granuscope_command({"run", (scratch / "second.toml").string(), "--out", out.string()}).code == 0);
  const auto finished = manifest_in(out);
  CHECK(finished["status"] == "done");
  CHECK(fs::exists(out / "report.html"));
  CHECK_FALSE(fs::exists(out / "earlier-report.html"));
  for (const auto& timing : finished["timings"]) {
    CAPTURE(timing.dump());
    if (timing["stage"].get<std::string>().starts_with("sample ")) {
      CHECK(timing["reused"] == true);
      CHECK(timing["seconds"].is_number());
    }
  }
}

TEST_CASE("A run goes on when nobody reads its progress any more") {
  const test::TemporaryFolder scratch;
  std::ofstream(scratch / "e.toml") << experiment(1);
  std::array<int, 2> ends = {};
  REQUIRE(::pipe(ends.data()) == 0);
  ::close(ends[0]);
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGPIPE, SIG_DFL);
    ::dup2(ends[1], STDERR_FILENO);
    ::execl(binary.c_str(), "granuscope", "run", (scratch / "e.toml").c_str(), "--out", (scratch / "out").c_str(),
            static_cast<char*>(nullptr));
    ::_exit(99);
  }
  ::close(ends[1]);
  int status = 0;
  ::waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(fs::exists(scratch / "out/report.html"));
}

TEST_CASE("A folder whose name is not UTF-8 gets its PDF, too") {
  const test::TemporaryFolder scratch;
  std::ofstream(scratch / "e.toml") << smallest_experiment_text + "show = false\n";
  const std::string out = (scratch / "Tr\xe4gheit").string();
  const auto result = granuscope_command({"run", (scratch / "e.toml").string(), "--out", out, "--require-pdf"});
  CHECK(result.code == 0);
  CHECK(fs::exists(fs::path(out) / "report.pdf"));
}

TEST_CASE("A flag that a script left empty is no default") {
  const test::TemporaryFolder scratch;
  const std::string pile = (scratch / "pile.h5").string(), image = (scratch / "image.png").string();
  std::ofstream(scratch / "e.toml") << experiment(1);
  REQUIRE(granuscope_command({"sample", "--columns", "20", "--layers", "20", "--out", pile}).code == 0);
  const std::vector<std::vector<std::string>> all{{"run", (scratch / "e.toml").string(), "--out", ""},
                                                  {"run", ""},
                                                  {"sample", "--statistics", "--out", ""},
                                                  {"render", pile, "--image", image, "--minus", ""},
                                                  {"render", pile, "--image", image, "--window", ""},
                                                  {"doctor", "--out", ""},
                                                  {"bench", "sampler", "--json", ""}};
  for (const auto& arguments : all) {
    CAPTURE(arguments);
    const auto result = granuscope_command(arguments);
    CHECK(result.code == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, Contains("is empty, which names nothing"));
  }
  CHECK_FALSE(fs::exists(image));
}

TEST_CASE("A picture does not replace the pile it is drawn of") {
  const test::TemporaryFolder scratch;
  const std::string pile = (scratch / "pile.png").string(), other = (scratch / "uniform.h5").string();
  const std::string link = (scratch / "link.png").string();
  const std::string sampled = (scratch / "pile.h5").string();
  REQUIRE(
      granuscope_command({"sample", "--columns", "30", "--layers", "20", "--load", "point", "--out", sampled}).code ==
      0);
  fs::rename(sampled, pile);
  REQUIRE(granuscope_command({"sample", "--columns", "30", "--layers", "20", "--out", other}).code == 0);
  fs::create_symlink("uniform.h5", link);
  const std::string before = read_file(pile), uniform = read_file(other);
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"render", pile, "--image", pile, "--width", "600"},
        {"render", other, "--image", link, "--width", "600"},
        {"render", pile, "--minus", other, "--scene", "response", "--image", link, "--width", "600"}}) {
    CAPTURE(arguments);
    const auto result = granuscope_command(arguments);
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("is read by this command"));
  }
  CHECK(read_file(pile) == before);
  CHECK(read_file(other) == uniform);
}

TEST_CASE("A bench that could not be kept, or would heed no flag, does not begin") {
  const test::TemporaryFolder scratch;
  const auto refused = [](std::vector<std::string> arguments, int code, const std::string& words) {
    arguments.insert(arguments.begin(), "bench");
    CAPTURE(arguments);
    const auto result = granuscope_command(arguments);
    CHECK(result.code == code);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, Contains(words));
  };
  refused({"accuracy", "--json", (scratch / "none/a.json").string()}, 3, "none/a.json': ");
  refused({"sampler", "--json", scratch.path().string()}, 3, "A folder stands");
  refused({"sampler", "--quick"}, 2, "--quick belongs to the suite render");
  refused({"accuracy", "--folder", "x"}, 2, "--folder belongs to the suite render");
  refused({"render", "--repetitions", "8"}, 2, "--repetitions belongs to the suite accuracy");
  refused({"render", "--threads", "2"}, 2, "--threads belongs to the suite accuracy");
}

TEST_CASE("A bench that is stopped says so and leaves its folder as it was") {
  const test::TemporaryFolder scratch;
  std::ofstream(scratch / "picture.png") << "somebody's own";
  std::ofstream(scratch / "pile-70x60.h5") << "somebody's own";
  ProcessSpec spec;
  spec.arguments = {"/bin/sh", "-c",
                    "\"$0\" bench render --folder \"$1\" 2>\"$1/said\" & child=$!; "
                    "while ! grep -q making \"$1/said\"; do sleep 0.02; done; kill -TERM $child; wait $child",
                    binary, scratch.path().string()};
  const ProcessResult result = run_process(spec);
  CHECK(result.exit_code == 4);
  CHECK_THAT(read_file(scratch / "said"), Contains("a suite measured half tells nothing"));
  CHECK(result.seconds < 20);
  fs::remove(scratch / "said");
  CHECK(read_file(scratch / "picture.png") == "somebody's own");
  CHECK(read_file(scratch / "pile-70x60.h5") == "somebody's own");
  CHECK(std::distance(fs::directory_iterator(scratch.path()), {}) == 2);
}
