#include "support/process.h"

#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using granuscope::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

ProcessSpec shell(const std::string& script) {
  ProcessSpec spec;
  spec.arguments = {"sh", "-c", script};
  return spec;
}

/// Whether the process ended within two seconds.
bool ends(pid_t pid) {
  for (int i = 0; i < 200; ++i) {
    if (::kill(pid, 0) != 0 && errno == ESRCH) return true;
    // An orphan whose new parent has not yet reaped it has ended, too.
    std::ifstream status("/proc/" + std::to_string(pid) + "/stat");
    std::string line;
    if (!std::getline(status, line) || line.find(") Z") != std::string::npos) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

std::string failure_to_run(const ProcessSpec& spec) {
  try {
    run_process(spec);
  } catch (const EnvironmentError& error) {
    return error.what();
  }
  FAIL("no EnvironmentError was thrown");
  return "";
}

}  // namespace

TEST_CASE("a child's output, messages and exit code come back") {
  const ProcessResult result = run_process(shell("echo out; echo err >&2; exit 7"));
  CHECK(result.standard_output == "out\n");
  CHECK(result.standard_error == "err\n");
  CHECK(result.exit_code == 7);
  CHECK_FALSE(result.timed_out);
  CHECK(result.seconds > 0);
  CHECK(run_process(shell("kill -SEGV $$")).exit_code == 128 + SIGSEGV);
}

TEST_CASE("arguments reach the child as they are, without any shell") {
  ProcessSpec spec;
  spec.arguments = {"printf", "%s|", "a b", "$HOME", "`id`", "*", "", "'\"", "μ"};
  CHECK(run_process(spec).standard_output == "a b|$HOME|`id`|*||'\"|μ|");
}

TEST_CASE("megabytes on both streams do not block") {
  const ProcessResult result = run_process(shell("head -c 5000000 /dev/zero & head -c 7000000 /dev/zero >&2; wait"));
  CHECK(result.exit_code == 0);
  CHECK(result.standard_output.size() == 5'000'000);
  CHECK(result.standard_error.size() == 7'000'000);
}

TEST_CASE("standard input is empty") {
  const ProcessResult result = run_process(shell("cat; echo end; readlink /proc/self/fd/0"));
  CHECK_THAT(result.standard_output, Catch::StartsWith("end\npipe:"));  // and takes no /dev/null, which may be missing
}

TEST_CASE("the environment is what was given and PATH") {
  ProcessSpec spec;
  spec.arguments = {"env"};
  CHECK_THAT(run_process(spec).standard_output, Catch::StartsWith("PATH="));
  spec.environment = {{"PATH", "/usr/bin:/bin"}, {"LC_ALL", "C"}, {"EMPTY", ""}};
  CHECK(run_process(spec).standard_output == "EMPTY=\nLC_ALL=C\nPATH=/usr/bin:/bin\n");
}

TEST_CASE("the working folder is the child's, not the caller's") {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  ProcessSpec spec = shell("pwd -P; echo made > here.txt");
  spec.working_folder = folder.path();
  CHECK(run_process(spec).standard_output == fs::canonical(folder.path()).string() + "\n");
  CHECK(fs::exists(folder / "here.txt"));
  CHECK(fs::current_path() == before);
}

TEST_CASE("a program that cannot be started is named, with what to do") {
  const TemporaryFolder folder;
  ProcessSpec spec;
  SECTION("nowhere in PATH") {
    spec.arguments = {"no-such-program-anywhere"};
    CHECK_THAT(failure_to_run(spec), Contains("'no-such-program-anywhere'") && Contains("PATH") && Contains("doctor"));
  }
  SECTION("the child's PATH counts") {
    spec.arguments = {"sh"};
    spec.environment = {{"PATH", folder.path().string()}};
    CHECK_THAT(failure_to_run(spec), Contains("'sh'"));
  }
  SECTION("a text without an interpreter line is not handed to a shell") {
    write_file(folder / "text", "echo run by a shell\n");
    fs::permissions(folder / "text", fs::perms::owner_all);
    spec.arguments = {folder / "text"};
    CHECK_THAT(failure_to_run(spec), Contains("text") && Contains("Exec format error"));
  }
  SECTION("not executable") {
    write_file(folder / "text", "#!/bin/sh\n");
    spec.arguments = {folder / "text"};
    CHECK_THAT(failure_to_run(spec), Contains("text"));
  }
  SECTION("a folder is no program") {
    spec.arguments = {folder.path().string()};
    CHECK_THAT(failure_to_run(spec), Contains("no such program"));
  }
  SECTION("no working folder") {
    spec = shell("true");
    spec.working_folder = folder / "missing";
    CHECK_THAT(failure_to_run(spec), Contains("missing") && Contains("does not exist"));
  }
  SECTION("no arguments") { CHECK_THAT(failure_to_run(spec), Contains("without a name")); }
  SECTION("a zero byte") {
    spec.arguments = {"echo", std::string("a\0b", 3)};
    CHECK_THAT(failure_to_run(spec), Contains("zero byte"));
  }
}

TEST_CASE("a time-out ends the child and its own children") {
  ProcessSpec spec = shell("sleep 60 & echo $!; trap '' TERM; sleep 60");
  spec.timeout_seconds = 0.3;
  const ProcessResult result = run_process(spec);
  CHECK(result.timed_out);
  CHECK(result.exit_code == 128 + SIGKILL);
  CHECK(result.seconds > 0.25);
  CHECK(result.seconds < 10);
  CHECK(ends(std::stoi(result.standard_output)));
}

TEST_CASE("a grandchild left in the background neither delays the result nor stays") {
  const ProcessResult result = run_process(shell("sleep 60 & echo $!"));
  CHECK(result.exit_code == 0);
  CHECK(result.seconds < 10);
  CHECK(ends(std::stoi(result.standard_output)));
}

TEST_CASE("a child that closes its output early is still waited for") {
  const ProcessResult result = run_process(shell("exec >&- 2>&-; sleep 0.2; exit 3"));
  CHECK(result.exit_code == 3);
  CHECK(result.seconds > 0.15);
}

TEST_CASE("a request to stop ends the child and is passed on") {
  const TemporaryFolder folder;
  std::thread stopper([&folder] {
    while (!fs::exists(folder / "started")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    request_interruption(true);
  });
  ProcessSpec spec = shell("sleep 60 & echo $! > pid; mv pid started; wait");
  spec.working_folder = folder.path();
  const auto start = std::chrono::steady_clock::now();
  CHECK_THROWS_AS(run_process(spec), Interrupted);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(10));
  stopper.join();
  CHECK(ends(std::stoi(read_file(folder / "started"))));
  CHECK_THROWS_AS(run_process(shell("true")), Interrupted);  // and nothing new begins
  request_interruption(false);
  CHECK(run_process(shell("true")).exit_code == 0);
}

TEST_CASE("the child has only its three streams and default signals") {
  const int leak = ::open("/dev/null", O_RDONLY);  // not close-on-exec
  const ProcessResult result = run_process(shell("ls /proc/self/fd | wc -l"));
  ::close(leak);
  CHECK(std::stoi(result.standard_output) == 4);  // 0, 1, 2 and the folder ls reads

  auto* const before = ::signal(SIGPIPE, SIG_IGN);
  // With SIGPIPE ignored `yes` would write on into nothing and complain.
  CHECK(run_process(shell("yes | head -n 1")).standard_error.empty());
  ::signal(SIGPIPE, before);
}

TEST_CASE("many children at once, from several threads") {
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::atomic<int> good{0};
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([t, &good] {
      for (int i = 0; i < 10; ++i) {
        const std::string word = std::to_string(100 * t + i);
        if (run_process(shell("echo " + word)).standard_output == word + "\n") ++good;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(good == 40);
}

TEST_CASE("find_program looks through PATH") {
  REQUIRE(find_program("sh"));
  CHECK(find_program("sh")->is_absolute());
  CHECK(find_program("sh")->filename() == "sh");
  CHECK_FALSE(find_program("no-such-program-anywhere"));
  CHECK_FALSE(find_program(""));
}

TEST_CASE("an installed program tells its version, a missing one is none, a failing one says why") {
  const auto shell = find_installed_program("bash");
  REQUIRE(shell);
  CHECK(shell->version.find("bash") != std::string::npos);
  CHECK(shell->failure.empty());
  CHECK_FALSE(find_installed_program("no-such-program-anywhere"));
}

TEST_CASE("a program that fails or hangs without a word does not count as one that works") {
  const test::TemporaryFolder folder;
  const auto failure_of = [&](const std::string& script) {
    std::ofstream(folder / "quiet") << "#!/bin/sh\n" << script << '\n';
    std::filesystem::permissions(folder / "quiet", std::filesystem::perms::owner_all);
    const auto program = find_installed_program((folder / "quiet").string(), 2);
    REQUIRE(program);
    CHECK(program->version.empty());
    return program->failure;
  };
  CHECK(failure_of("exit 1") == "it ended with status 1");
  CHECK(failure_of("echo no >&2; exit 7") == "it ended with status 7: no");
  CHECK(failure_of("kill -KILL $$") == "it was ended by signal 9 (Killed)");
  CHECK(failure_of("sleep 60") == "it was still running after 2 s");
}

TEST_CASE("a program that does not know --version is installed but says why it failed") {
  const auto program = find_installed_program("dash");  // the POSIX shell of Debian refuses long options
  REQUIRE(program);
  CHECK(program->version.empty());
  CHECK_FALSE(program->failure.empty());
}
