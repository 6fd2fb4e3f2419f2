#pragma once
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace granuscope {
/// Where a result comes from. Everything that differs between machines or moments is here and in manifest.json only.
struct Provenance {
  std::string program_version;  ///< "granuscope 0.1.0"
  std::string git_commit;       ///< 40 digits at build time, or "unknown" outside a checkout
  bool git_dirty = false;       ///< the checkout had uncommitted changes when the program was built
  std::string compiler;         ///< name and version
  std::string compiler_flags;
  std::string build_type;
  std::vector<std::pair<std::string, std::string>> libraries;  ///< name, version as loaded
  std::string host_cpu;
  std::string processor_features;  ///< instruction sets that libraries choose by
  std::string operating_system;
  unsigned hardware_threads = 0;
};

/// What is known of the running program and its machine.
Provenance collect_provenance();

/// The stable part (version, commit, dirty flag, compiler) in one line, for a picture's metadata.
std::string provenance_line(const Provenance& provenance);

/// The current time as ISO 8601 in UTC, for manifest.json.
std::string current_time();

/// The version of a library as it is loaded now, by its name in the manifest ("GSL", "HDF5", "libpng",
/// "FreeType", "OpenSSL", "glibc"). It may be another one than the program was built with. Nothing where the
/// library is not loaded or does not tell.
std::optional<std::string> loaded_version(const std::string& library);

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
