#include "support/installed_program.h"

#include <catch2/catch.hpp>

using namespace granuscope;

TEST_CASE("an installed program tells its version, a missing one is none, a failing one says why") {
  const auto shell = find_installed_program("bash");
  REQUIRE(shell);
  CHECK(shell->version.find("bash") != std::string::npos);
  CHECK(shell->failure.empty());
  CHECK_FALSE(find_installed_program("no-such-program-anywhere"));
}

TEST_CASE("a program that does not know --version is installed but says why it failed") {
  const auto program = find_installed_program("dash");  // the POSIX shell of Debian refuses long options
  REQUIRE(program);
  CHECK(program->version.empty());
  CHECK_FALSE(program->failure.empty());
}
