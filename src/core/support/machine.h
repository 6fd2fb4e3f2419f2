#pragma once
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

namespace granuscope {
/// Asks for a variable of the environment; null where it is not set (tests bring their own).
using AskVariable = std::function<const char*(const char*)>;

/// Processors that this process may use, which are fewer than the machine's under taskset, in containers and batch
/// jobs.
struct Processors {
  int machine = 1;     ///< that the machine has
  int bound = 1;       ///< that the process is bound to (sched_getaffinity: taskset, cpusets)
  double quota = 0;    ///< processors' worth of time that its control group is given; 0: no limit
  int task = 0;        ///< SLURM_CPUS_PER_TASK; 0: not set
  std::string reason;  ///< for doctor: "2 of 8 may be used: ..."

  /// The least of these; a part of one counts as one.
  int usable() const;
};

/// `root` is where the system's folders are looked for (tests).
Processors find_processors(const std::filesystem::path& root = "/", const AskVariable& ask = ::getenv);

/// Threads that --threads asks for; 0 means all processors that this process may use.
int worker_count(int threads);

/// Memory that this process may use, in bytes: the machine's, or less if its container (control group) is given less.
double usable_memory(const std::filesystem::path& root = "/");

}  // namespace granuscope
