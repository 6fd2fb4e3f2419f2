#pragma once
#include <sstream>
#include <string>
#include <vector>

#include "cli/command_line.h"

namespace granuscope {

struct CommandResult {
  int code;
  std::string out;
  std::string err;
};

/// Runs "granuscope ARGUMENTS..." inside the test program.
inline CommandResult granuscope_command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "granuscope");
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::ostringstream out;
  std::ostringstream err;
  const int code = run_command_line(static_cast<int>(argv.size()), argv.data(), out, err);
  return {code, out.str(), err.str()};
}

}  // namespace granuscope
