#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace granuscope {

/// How long a file may take to read before it counts as damaged. Both grow with the file's size.
struct ReadPatience {
  double processor_seconds = 5;  ///< what a library in an endless loop uses up
  double wall_seconds = 120;     ///< for a disk or network that does not answer
};

/// Runs `read` in a child process and returns the bytes that it returns. The HDF5 library crashes on some damaged files
/// and never comes to an end on others; here only the child does, and this throws InputError saying so. Errors that
/// `read` throws are passed on with their kind and message. `kind` is what the file should be, with its article ("a
/// pile file"), for messages. Throws EnvironmentError if there can be no child, Interrupted if a stop is requested
/// meanwhile.
std::string read_in_child(const std::filesystem::path& source, const std::string& kind,
                          const std::function<std::string()>& read, ReadPatience patience = {});

}  // namespace granuscope
