#include "support/error.h"

#include <catch2/catch.hpp>
#include <cerrno>

using namespace granuscope;

TEST_CASE("each error carries its exit code and its message") {
  CHECK(InputError("a").exit_code() == ExitCode::bad_input);
  CHECK(EnvironmentError("b").exit_code() == ExitCode::environment);
  CHECK(Interrupted("c").exit_code() == ExitCode::interrupted);
  CHECK(std::string(InputError("what, why, what to do").what()) == "what, why, what to do");
  CHECK(static_cast<int>(ExitCode::verdict_differs) == 1);
  CHECK(static_cast<int>(ExitCode::bad_input) == 2);
  CHECK(static_cast<int>(ExitCode::environment) == 3);
  CHECK(static_cast<int>(ExitCode::interrupted) == 4);
}

TEST_CASE("a system's reason comes with what to do about it") {
  CHECK(system_reason(ENOSPC) == "No space left on device. Free some space there or choose another folder.");
  CHECK(system_reason(EACCES) == "Permission denied. Change the permissions or choose another folder.");
  CHECK(system_reason(EROFS) == "Read-only file system. Choose a folder that can be written.");
  CHECK(system_reason(ENOENT) ==
        "No such file or directory. Check the spelling of the path and that its folder exists.");
  CHECK(system_reason(EPIPE) == "Broken pipe.");
}
