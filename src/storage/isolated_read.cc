#include "storage/isolated_read.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX, not in <csignal>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <new>
#include <string_view>

#include "storage/hdf5_handle.h"
#include "support/error.h"
#include "support/file_descriptor.h"
#include "support/interruption.h"
#include "support/system_reason.h"

namespace granuscope {
namespace {

using Clock = std::chrono::steady_clock;

/// The slowest reading worth waiting for: a compressed file on a slow disk.
constexpr double slowest_bytes_per_second = 5e6;
/// How often the wait looks for a request to stop.
constexpr int poll_milliseconds = 50;
/// The answer's first letter says what follows it.
enum class Answer : char { bytes = 'b', input_error = 'i', environment_error = 'e', out_of_memory = 'm', fault = 'f' };

void send(int pipe, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::write(pipe, bytes.data(), bytes.size());
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent < 0 && errno != EINTR) ::_exit(1);
  }
}

void answer(int pipe, Answer kind, std::string_view text) {
  const char letter = static_cast<char>(kind);
  send(pipe, {&letter, 1});
  send(pipe, text);
}

/// What the child does instead of the caller's work: it keeps nothing of the caller open, prints nothing, and ends with
/// it at the latest.
[[noreturn]] void serve(int pipe, pid_t parent, const std::function<std::string()>& read, double processor_seconds) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it ended before the line above
  // A request to stop is for the parent, which then ends this process.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_IGN);
  // The library's last words, and a sanitizer's, are about the file.
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (standard != pipe) ::dup2(nowhere, standard);
  }
  if (pipe > STDERR_FILENO + 1) ::close_range(STDERR_FILENO + 1, static_cast<unsigned>(pipe - 1), 0);
  ::close_range(static_cast<unsigned>(pipe + 1), ~0U, 0);
  const auto seconds = static_cast<rlim_t>(std::ceil(processor_seconds));
  const rlimit time = {seconds, seconds + 1};
  ::setrlimit(RLIMIT_CPU, &time);
  const rlimit no_core = {0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    answer(pipe, Answer::bytes, read());
  } catch (const InputError& error) {
    answer(pipe, Answer::input_error, error.what());
  } catch (const EnvironmentError& error) {
    answer(pipe, Answer::environment_error, error.what());
  } catch (const std::bad_alloc&) {
    answer(pipe, Answer::out_of_memory, "");
  } catch (const std::exception& error) {
    answer(pipe, Answer::fault, error.what());
  }
  ::_exit(0);  // without any cleaning up: all of it belongs to the parent
}

/// A child that never outlives this object.
class Reader {
 public:
  explicit Reader(pid_t pid) : pid_(pid) {}
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    if (pid_ < 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  /// Its exit status as waitpid gives it.
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_;
};

[[noreturn]] void give_up(const std::filesystem::path& source, const std::string& kind, const std::string& what) {
  throw InputError(
      fmt::format("cannot read '{}' as {}: the HDF5 library {}, so the file is damaged, or made to do so. Make the "
                  "file again or name another one.",
                  source.string(), kind, what));
}

}  // namespace

std::string read_in_child(const std::filesystem::path& source, const std::string& kind,
                          const std::function<std::string()>& read, ReadPatience patience) {
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(source, unknown);
  if (!unknown) {
    patience.processor_seconds += static_cast<double>(size) / slowest_bytes_per_second;
    patience.wall_seconds += static_cast<double>(size) / slowest_bytes_per_second;
  }

  const auto no_child = [&](int error_number) {
    throw EnvironmentError(fmt::format("cannot read '{}': a process for it cannot be started: {}", source.string(),
                                       system_reason(error_number)));
  };
  std::array<int, 2> ends = {};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) no_child(errno);
  FileDescriptor from_child(ends[0]);
  FileDescriptor to_parent(ends[1]);
  const pid_t parent = ::getpid();
  pid_t pid = -1;
  int error_number = 0;
  {
    // The child inherits the library as it is at this moment: no other thread may be inside it.
    const Hdf5Session session;
    pid = ::fork();
    error_number = errno;
  }
  if (pid < 0) no_child(error_number);
  if (pid == 0) serve(to_parent.get(), parent, read, patience.processor_seconds);
  Reader child(pid);
  to_parent.reset();

  const Clock::time_point start = Clock::now();
  std::string received;
  std::array<char, 1 << 16> chunk;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by read
  for (;;) {
    if (interruption_requested()) throw_if_interrupted();
    if (std::chrono::duration<double>(Clock::now() - start).count() > patience.wall_seconds) {
      give_up(source, kind, fmt::format("did not come to an end within {:.0f} s", patience.wall_seconds));
    }
    pollfd wait = {from_child.get(), POLLIN, 0};
    if (::poll(&wait, 1, poll_milliseconds) <= 0) continue;
    const ssize_t got = ::read(from_child.get(), chunk.data(), chunk.size());
    if (got > 0) received.append(chunk.data(), static_cast<std::size_t>(got));
    if (got == 0) break;
  }
  const int status = child.wait();
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    give_up(source, kind, "did not come to an end, or took all memory");
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || received.empty()) give_up(source, kind, "crashed on it");

  const auto letter = static_cast<Answer>(received.front());
  received.erase(0, 1);
  switch (letter) {
    case Answer::bytes:
      return received;
    case Answer::input_error:
      throw InputError(received);
    case Answer::environment_error:
      throw EnvironmentError(received);
    case Answer::out_of_memory:
      throw std::bad_alloc();
    case Answer::fault:
      break;
  }
  throw std::runtime_error(received);
}

}  // namespace granuscope
