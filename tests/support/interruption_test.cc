#include "support/progress.h"

#include <signal.h>  // NOLINT(modernize-deprecated-headers): raise and kill
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "support/error.h"

using namespace granuscope;

namespace {

/// Runs `action` in a process of its own and returns its exit status, or 128 + signal.
template <class Action>
int status_of(const Action& action) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGHUP, SIG_DFL);  // ignored where the tests themselves run under nohup
    ::_exit(action());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("the flag is set and cleared by hand, and thrown as Interrupted") {
  CHECK_FALSE(interruption_requested());
  CHECK_NOTHROW(throw_if_interrupted());
  request_interruption(true);
  CHECK(interruption_requested());
  try {
    throw_if_interrupted();
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.exit_code() == ExitCode::interrupted);
  }
  request_interruption(false);
  CHECK_NOTHROW(throw_if_interrupted());
}

TEST_CASE("the first signal asks, the second one ends with status 4") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU}) {
    CHECK(status_of([signal] {
            install_interruption_handlers();
            ::raise(signal);
            return interruption_requested() ? 42 : 1;
          }) == 42);
    CHECK(status_of([signal] {
            install_interruption_handlers();
            ::raise(signal);
            ::raise(SIGINT);
            return 1;
          }) == 4);
  }
}

TEST_CASE("under nohup the end of the terminal asks for nothing, and a closed pipe ends nothing") {
  CHECK(status_of([] {
          ::signal(SIGHUP, SIG_IGN);
          install_interruption_handlers();
          ::raise(SIGHUP);
          ::raise(SIGHUP);
          return interruption_requested() ? 1 : 42;
        }) == 42);
  CHECK(status_of([] {
          install_interruption_handlers();
          int ends[2] = {};
          if (::pipe(ends) != 0) return 1;
          ::close(ends[0]);
          return ::write(ends[1], "x", 1) == -1 ? 42 : 1;
        }) == 42);
}
