#include "support/process.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "kit/temporary_folder.h"

using namespace granuscope;

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
