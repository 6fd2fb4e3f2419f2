#include "support/interruption.h"

#include <signal.h>  // NOLINT(modernize-deprecated-headers): sigaction is POSIX, not in <csignal>
#include <unistd.h>

#include <atomic>
#include <initializer_list>

#include "support/error.h"

namespace granuscope {
namespace {

std::atomic<bool> requested_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the flag is set inside a signal handler");

extern "C" void on_signal(int /*signal*/) {
  if (requested_flag.exchange(true)) ::_exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void install_interruption_handlers() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  // Reads and writes inside libraries carry on; they need not know about EINTR.
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM}) ::sigaction(signal, &action, nullptr);
  // The end of a terminal or of a connection. nohup asks to go on after it.
  struct sigaction before = {};
  if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) {
    ::sigaction(SIGHUP, &action, nullptr);
  }
  // A file-size limit, or a reader that has gone, then makes the write fail with a message, instead of ending the
  // process without one; and a long run does not end because nobody listens to its progress any more.
  struct sigaction ignore = {};
  ignore.sa_handler = SIG_IGN;
  for (const int signal : {SIGXFSZ, SIGPIPE}) ::sigaction(signal, &ignore, nullptr);
}

bool interruption_requested() { return requested_flag.load(std::memory_order_relaxed); }

void throw_if_interrupted() {
  if (interruption_requested()) {
    throw Interrupted(
        "stopped on request: every finished ensemble (one friction coefficient) is kept, and the same command goes on "
        "with "
        "the next");
  }
}

void request_interruption(bool requested) { requested_flag.store(requested); }

}  // namespace granuscope
