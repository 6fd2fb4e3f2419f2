#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace granuscope {
/// One program to run, without any shell.
struct ProcessSpec {
  std::vector<std::string> arguments;              ///< arguments[0] is the program, looked up in PATH
  std::filesystem::path working_folder;            ///< empty: the caller's
  std::map<std::string, std::string> environment;  ///< the whole environment of the child (PATH is added if absent)
  double timeout_seconds = 120;                    ///< after this the child's process group is killed
};

struct ProcessResult {
  int exit_code = 0;  ///< 128 + signal if it was killed by one
  bool timed_out = false;
  std::string standard_output;
  std::string standard_error;
  double seconds = 0;
};

/// "ended with status 1", "was ended by signal 11 (Segmentation fault)": to follow the program's name.
std::string describe_end(const ProcessResult& result);

/// Runs the program with an empty standard input and waits for its end; what it leaves running in its process group is
/// ended too. A program named with a slash is found from the caller's folder. Throws EnvironmentError if it cannot be
/// started or floods its output, Interrupted (after ending it) if a stop is requested meanwhile.
ProcessResult run_process(const ProcessSpec& spec);

/// The program's full path, if PATH has it.
std::optional<std::filesystem::path> find_program(const std::string& name);

/// Where a program is that PATH does not have: in one of the usual folders.
std::optional<std::filesystem::path> find_outside_path(const std::string& name);

/// "gnuplot is not found in PATH (/opt), so `consequence`; `install`", or that the folder is to be added to PATH.
std::string missing_program(const std::string& name, const std::string& consequence, const std::string& install);

/// A program found in PATH and what it says of itself.
struct InstalledProgram {
  std::filesystem::path path;
  std::string version;  ///< first line of `program --version`; empty if it does not start
  std::string failure;  ///< why it does not start; empty if it does
};

/// Looks the program up and asks it for its version; none if PATH does not have it. One that gives no answer in time
/// does not start.
std::optional<InstalledProgram> find_installed_program(const std::string& name, double timeout_seconds = 60);

}  // namespace granuscope
