#include "cli/machine.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "support/error.h"

namespace granuscope {

int worker_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void require_memory(double bytes) {
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      fmt::format("about {:.1f} GB of memory are needed but this machine has {:.1f} GB; make the pile smaller or use "
                  "fewer --threads",
                  bytes / 1e9, memory / 1e9));
}

}  // namespace granuscope
