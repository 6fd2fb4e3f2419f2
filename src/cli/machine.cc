#include "cli/machine.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "support/describe_bytes.h"
#include "support/error.h"

namespace granuscope {

int worker_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void require_memory(double bytes) {
  const double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      fmt::format("about {} of memory are needed but this machine has {}; make the pile smaller or use fewer --threads",
                  describe_bytes(bytes), describe_bytes(memory)));
}

}  // namespace granuscope
