#include "support/installed_program.h"

#include "support/child_process.h"
#include "support/error.h"

namespace granuscope {
namespace {

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

std::optional<InstalledProgram> find_installed_program(const std::string& name) {
  const auto path = find_program(name);
  if (!path) return std::nullopt;
  InstalledProgram program{*path, "", ""};
  try {
    ProcessSpec spec;
    spec.arguments = {path->string(), "--version"};
    spec.environment = {{"LC_ALL", "C.UTF-8"}};
    spec.timeout_seconds = 60;
    const ProcessResult result = run_process(spec);
    if (result.exit_code == 0) {
      program.version = first_line(result.standard_output);
    } else {
      program.failure = first_line(result.standard_error);
    }
  } catch (const EnvironmentError& error) {
    program.failure = error.what();
  }
  return program;
}

}  // namespace granuscope
