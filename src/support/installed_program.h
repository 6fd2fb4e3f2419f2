#pragma once
#include <filesystem>
#include <optional>
#include <string>

namespace granuscope {

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
