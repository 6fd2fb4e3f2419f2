#include "support/installed_program.h"

#include <fmt/format.h>

#include "support/child_process.h"
#include "support/error.h"

namespace granuscope {
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
