#pragma once
#include <ostream>

namespace granuscope {

class Crew;

/// Runs one command line and returns the exit status (see ExitCode). Results go to `out`, messages to `err`; progress
/// goes to the process's standard error. `crew`: other processes that draw ensembles with
/// this one. Never throws and never exits.
int run_command_line(int argc, const char* const* argv, std::ostream& out, std::ostream& err, Crew* crew = nullptr);

}  // namespace granuscope
