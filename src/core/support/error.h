#pragma once
#include <fmt/core.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace granuscope {
/// What the program's exit status tells its caller.
enum class ExitCode : int {
  done = 0,             ///< everything asked for was made
  verdict_differs = 1,  ///< a claim's verdict is not the expected one (only with --gate)
  bad_input = 2,        ///< bad usage, configuration or input file
  environment = 3,      ///< missing program, no GL context, disk full, no permission
  interrupted = 4,      ///< stopped half way; finished parts are kept and a second run resumes
  busy = 5,             ///< another run is at work in the folder
};

/// Base of every error the program raises on purpose. A message reads: what is wrong, why that is a problem, what to
/// do. It is handed over as a text, or as a format with its arguments.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode exit_code() const { return code_; }

 private:
  ExitCode code_;
};

/// The user's input (command line, experiment, file) cannot be used as it stands.
class InputError : public Error {
 public:
  explicit InputError(const std::string& message) : InputError(std::vector{message}) {}
  template <class First, class... Rest>
  InputError(fmt::format_string<First, Rest...> text, First&& first, Rest&&... rest)
      : InputError(fmt::format(text, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
  /// Several things that are wrong, each a message of its own: what() has one a line.
  explicit InputError(std::vector<std::string> messages);
  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

/// The machine lacks something: a program, a GL context, space, permission.
class EnvironmentError : public Error {
 public:
  explicit EnvironmentError(const std::string& message) : Error(ExitCode::environment, message) {}
  template <class First, class... Rest>
  EnvironmentError(fmt::format_string<First, Rest...> text, First&& first, Rest&&... rest)
      : EnvironmentError(fmt::format(text, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
};

/// Another run is at work where this one would be: nothing is wrong, and later it can be.
class BusyError : public Error {
 public:
  explicit BusyError(const std::string& message) : Error(ExitCode::busy, message) {}
  template <class First, class... Rest>
  BusyError(fmt::format_string<First, Rest...> text, First&& first, Rest&&... rest)
      : BusyError(fmt::format(text, std::forward<First>(first), std::forward<Rest>(rest)...)) {}
};

/// The user or the system asked to stop; what was finished is on disk.
class Interrupted : public Error {
 public:
  explicit Interrupted(const std::string& message) : Error(ExitCode::interrupted, message) {}
};

/// What makes the value of a key unusable.
struct KeyProblem {
  std::string key;      ///< "lattice.columns"; in what a spec says of itself "columns", as a table may have any name
  std::string message;  ///< what is wrong, why that is a problem, what to do
};
using Problem = std::optional<KeyProblem>;

template <class... Args>
Problem problem(const std::string& key, fmt::format_string<Args...> text, Args&&... args) {
  return KeyProblem{key, fmt::format(text, std::forward<Args>(args)...)};
}

/// What a spec says of itself, as the table of an experiment file that holds it.
Problem in_table(const std::string& table, Problem found);

/// Throws InputError "key: message" if there is a problem.
void refuse(const Problem& found);

/// The system's words for an errno value and, where there is one, what the user can do about it:
/// "No space left on device. Free some space there or choose another folder."
std::string system_reason(int error_number);

}  // namespace granuscope
