#include "cli/machine.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

#include "support/describe_bytes.h"
#include "support/error.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;

/// The number in a file, if there is one: a group without limit says "max".
void lower_to_limit_in(const fs::path& file, double& memory) {
  std::ifstream in(file);
  double limit = 0;
  if (in >> limit && limit > 0) memory = std::min(memory, limit);
}

/// Lowers `memory` to the limits of a control group and of all above it. Where the group's own name is not mounted, as
/// in most containers, what is mounted is its own.
void lower_to_group(const fs::path& mount, const fs::path& group, const char* limit_file, double& memory) {
  for (fs::path at = group.relative_path();; at = at.parent_path()) {
    lower_to_limit_in(mount / at / limit_file, memory);
    if (at.empty()) return;
  }
}

}  // namespace

double usable_memory(const fs::path& root) {
  double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const fs::path mount = root / "sys/fs/cgroup";
  // Lines "0::/group" (version 2) and "4:memory:/group" (version 1).
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty()) lower_to_group(mount, group, "memory.max", memory);
    if (controllers == "memory") lower_to_group(mount / "memory", group, "memory.limit_in_bytes", memory);
  }
  return memory;
}

int worker_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void require_memory(double bytes) {
  const double memory = usable_memory();
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      fmt::format("about {} of memory are needed but this machine, or its container, has {}; make the pile smaller or "
                  "use fewer --threads",
                  describe_bytes(bytes), describe_bytes(memory)));
}

}  // namespace granuscope
