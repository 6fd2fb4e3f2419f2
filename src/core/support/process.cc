#include "support/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill and sigset_t are POSIX, not in <csignal>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

namespace granuscope {
namespace {
using Clock = std::chrono::steady_clock;

/// More than this on one stream is a program out of control, and would end in a full memory.
constexpr std::size_t max_output_bytes = std::size_t{256} << 20;
/// How often a wait looks for a request to stop, which may have been delivered to another thread.
constexpr int poll_milliseconds = 50;
constexpr const char* default_path = "/usr/local/bin:/usr/bin:/bin";

std::string callers_path() {
  const char* path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): nothing here calls setenv
  return path == nullptr ? default_path : path;
}

bool is_program(const fs::path& file) {
  struct stat status = {};
  return ::stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && ::access(file.c_str(), X_OK) == 0;
}

std::optional<fs::path> find_program_in(const std::string& name, std::string_view path) {
  if (name.empty()) return std::nullopt;
  if (name.find('/') != std::string::npos) {
    if (!is_program(name)) return std::nullopt;
    return fs::absolute(name);
  }
  for (;;) {
    const std::size_t colon = path.find(':');
    const std::string_view folder = path.substr(0, colon);
    // An empty entry is the current folder by custom; a program found by accident there is not wanted.
    if (!folder.empty() && is_program(fs::path(folder) / name)) return fs::absolute(fs::path(folder) / name);
    if (colon == std::string_view::npos) return std::nullopt;
    path.remove_prefix(colon + 1);
  }
}

[[noreturn]] void fail_to_start(const std::string& program, const std::string& reason) {
  throw EnvironmentError("cannot start '{}': {}", program, reason);
}

struct Pipe {
  FileDescriptor read_end, write_end;
};

/// A pipe that no other child inherits. Its numbers stay clear of 0-2 even if the caller closed those, because the
/// child puts its own ends there one after the other.
Pipe make_pipe(const std::string& program) {
  std::array<int, 2> ends = {};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail_to_start(program, system_reason(errno));
  Pipe result{FileDescriptor(ends[0]), FileDescriptor(ends[1])};
  for (FileDescriptor* end : {&result.read_end, &result.write_end}) {
    if (end->get() > STDERR_FILENO) continue;
    FileDescriptor lifted(::fcntl(end->get(), F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
    if (!lifted.valid()) fail_to_start(program, system_reason(errno));
    *end = std::move(lifted);
  }
  ::fcntl(result.read_end.get(), F_SETFL, O_NONBLOCK);
  return result;
}

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  posix_spawn_file_actions_t* get() { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_ = {};
};

/// Own process group, no blocked signals, and the usual reaction to each of them whatever the caller has set.
class SpawnAttributes {
 public:
  SpawnAttributes() {
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;
  posix_spawnattr_t* get() { return &attributes_; }

 private:
  posix_spawnattr_t attributes_ = {};
};

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// A running child, the leader of its own process group. Never outlives this object.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid), descriptor_(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0))) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (!reaped_) kill_and_reap();
  }

  /// Readable once the child has ended; -1 on a kernel without it.
  int descriptor() const { return descriptor_.get(); }

  /// Whether the child has ended. It stays unreaped, so that its number cannot name another process yet.
  bool ended() const {
    siginfo_t info = {};
    const int status = ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT);
    return status == 0 ? info.si_pid != 0 : errno != EINTR;
  }

  /// Ends whatever is left of the group, grandchildren too, and returns the child's exit status.
  int kill_and_reap() {
    ::kill(-pid_, SIGKILL);
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    reaped_ = true;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

 private:
  pid_t pid_;
  FileDescriptor descriptor_;
  bool reaped_ = false;
};

pid_t spawn(const ProcessSpec& spec, Pipe& output, Pipe& errors) {
  const std::string& program = spec.arguments.front();
  const auto given_path = spec.environment.find("PATH");
  const std::string path = given_path == spec.environment.end() ? callers_path() : given_path->second;
  const std::optional<fs::path> file = find_program_in(program, path);
  if (!file) {
    fail_to_start(program, "there is no such program in PATH. Install it; `granuscope doctor` names the command.");
  }
  if (!spec.working_folder.empty() && !folder_exists(spec.working_folder)) {
    fail_to_start(program, fmt::format("its working folder '{}' does not exist. Make it or choose another.",
                                       spec.working_folder.string()));
  }

  std::vector<std::string> arguments = spec.arguments;
  std::vector<std::string> environment;
  for (const auto& [name, value] : spec.environment) environment.push_back(fmt::format("{}={}", name, value));
  if (given_path == spec.environment.end()) environment.push_back("PATH=" + path);
  // The system ends a text at its first zero byte: what follows would be lost without a word.
  for (const auto* words : {&arguments, &environment}) {
    for (const std::string& word : *words) {
      if (word.find('\0') != std::string::npos) fail_to_start(program, "an argument holds a zero byte. Remove it.");
    }
  }

  FileActions actions;
  const Pipe nothing = make_pipe(program);  // nobody writes into it; /dev/null may not be there
  int status = posix_spawn_file_actions_adddup2(actions.get(), nothing.read_end.get(), STDIN_FILENO);
  if (status == 0) status = posix_spawn_file_actions_adddup2(actions.get(), output.write_end.get(), STDOUT_FILENO);
  if (status == 0) status = posix_spawn_file_actions_adddup2(actions.get(), errors.write_end.get(), STDERR_FILENO);
  // Libraries open files that are not close-on-exec; the child has no business with them.
  if (status == 0) status = posix_spawn_file_actions_addclosefrom_np(actions.get(), STDERR_FILENO + 1);
  if (status == 0 && !spec.working_folder.empty()) {
    status = posix_spawn_file_actions_addchdir_np(actions.get(), spec.working_folder.c_str());
  }
  SpawnAttributes attributes;
  pid_t pid = -1;
  if (status == 0) {
    status = ::posix_spawn(&pid, file->c_str(), actions.get(), attributes.get(), pointers_to(arguments).data(),
                           pointers_to(environment).data());
  }
  if (status != 0) fail_to_start(program, system_reason(status));
  output.write_end.reset();
  errors.write_end.reset();
  return pid;
}

/// Takes what is in the pipe now. Closes it at its end.
void drain(FileDescriptor& pipe, std::string& text, const std::string& program) {
  std::array<char, 65536> chunk;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by read
  while (pipe.valid()) {
    const ssize_t got = ::read(pipe.get(), chunk.data(), chunk.size());
    if (got > 0) {
      text.append(chunk.data(), static_cast<std::size_t>(got));
      if (text.size() > max_output_bytes) {
        throw EnvironmentError("'{}' wrote more than {} MiB of messages and was stopped: check its input", program,
                               max_output_bytes >> 20);
      }
    } else if (got < 0 && errno == EINTR) {
      continue;
    } else if (got < 0 && errno == EAGAIN) {
      return;
    } else {
      pipe.reset();
    }
  }
}

}  // namespace

std::string describe_end(const ProcessResult& result) {
  if (result.exit_code <= 128) return fmt::format("ended with status {}", result.exit_code);
  const int signal = result.exit_code - 128;
  const char* name = ::sigdescr_np(signal);
  return fmt::format("was ended by signal {} ({})", signal, name == nullptr ? "unknown" : name);
}

ProcessResult run_process(const ProcessSpec& spec) {
  if (spec.arguments.empty()) throw EnvironmentError("cannot start a program without a name: give its arguments");
  const std::string& program = spec.arguments.front();
  throw_if_interrupted();

  const Clock::time_point start = Clock::now();
  const auto seconds_since_start = [start] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  Pipe output = make_pipe(program);
  Pipe errors = make_pipe(program);
  Child child(spawn(spec, output, errors));

  ProcessResult result;
  const auto drain_both = [&] {
    drain(output.read_end, result.standard_output, program);
    drain(errors.read_end, result.standard_error, program);
  };
  // The child's end is what counts, not that of its pipes: a grandchild left behind may hold those open for ever.
  while (!child.ended()) {
    if (interruption_requested()) {
      child.kill_and_reap();
      throw Interrupted(fmt::format(
          "stopped on request while '{}' was running: the same command goes on from the last finished part", program));
    }
    const double left = spec.timeout_seconds - seconds_since_start();
    if (left <= 0) {
      result.timed_out = true;
      break;
    }
    std::array<pollfd, 3> waits = {pollfd{output.read_end.get(), POLLIN, 0}, pollfd{errors.read_end.get(), POLLIN, 0},
                                   pollfd{child.descriptor(), POLLIN, 0}};
    const double slice = child.descriptor() < 0 ? 5.0 : poll_milliseconds;
    const int milliseconds = static_cast<int>(std::ceil(std::min(slice, left * 1000)));
    ::poll(waits.data(), waits.size(), milliseconds);  // an error is EINTR: the loop looks at everything anyway
    drain_both();
  }
  result.exit_code = child.kill_and_reap();
  drain_both();
  result.seconds = seconds_since_start();
  return result;
}

std::optional<fs::path> find_program(const std::string& name) { return find_program_in(name, callers_path()); }

std::optional<fs::path> find_outside_path(const std::string& name) {
  return find_program(name) ? std::nullopt : find_program_in(name, default_path);
}

std::string missing_program(const std::string& name, const std::string& consequence, const std::string& install) {
  const auto outside = find_outside_path(name);
  return fmt::format("{} is not found in PATH ({}), so {}; {}", name, callers_path(), consequence,
                     outside ? fmt::format("it is {}: add that folder to PATH", outside->string()) : install);
}

namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

std::optional<InstalledProgram> find_installed_program(const std::string& name, double timeout_seconds) {
  const auto path = find_program(name);
  if (!path) return std::nullopt;
  InstalledProgram program{*path, "", ""};
  try {
    ProcessSpec spec;
    spec.arguments = {path->string(), "--version"};
    spec.environment = {{"LC_ALL", "C.UTF-8"}};
    spec.timeout_seconds = timeout_seconds;
    const ProcessResult result = run_process(spec);
    if (result.timed_out) {
      program.failure = fmt::format("it was still running after {:.0f} s", spec.timeout_seconds);
    } else if (result.exit_code == 0) {
      program.version = first_line(result.standard_output);
    } else {
      const std::string said = first_line(result.standard_error);
      program.failure = fmt::format("it {}{}{}", describe_end(result), said.empty() ? "" : ": ", said);
    }
  } catch (const EnvironmentError& error) {
    program.failure = error.what();
  }
  return program;
}

}  // namespace granuscope
