#include "support/machine.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <string_view>
#include <vector>

namespace granuscope {
namespace {

namespace fs = std::filesystem;

/// The numbers at the beginning of a file: none if it is not there or says "max".
std::vector<double> numbers_in(const fs::path& file) {
  std::ifstream in(file);
  std::vector<double> numbers;
  for (double number = 0; in >> number;) numbers.push_back(number);
  return numbers;
}

/// Calls look(folder, version) for the control group of this process and all above it, as `controller` has them: their
/// limits count, too. Where the group's own name is not mounted, as in most containers, what is mounted is its own.
template <class Look>
void each_group(const fs::path& root, std::string_view controller, const Look& look) {
  const fs::path mount = root / "sys/fs/cgroup";
  const auto up = [&](const fs::path& top, const fs::path& group, int version) {
    for (fs::path at = group.relative_path();; at = at.parent_path()) {
      look(top / at, version);
      if (at.empty()) return;
    }
  };
  // Lines "0::/group" (version 2) and "4:cpu,cpuacct:/group" (version 1).
  std::ifstream groups(root / "proc/self/cgroup");
  if (!groups) up(mount, "", 2);
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty()) up(mount, group, 2);
    if (("," + controllers + ",").find(fmt::format(",{},", controller)) == std::string::npos) continue;
    std::error_code none;
    up(fs::exists(mount / controllers, none) ? mount / controllers : mount / controller, group, 1);
  }
}

/// More processors than cpu_set_t has room for are asked for with more room.
int bound_processors(int machine) {
  for (int room = CPU_SETSIZE; room <= CPU_SETSIZE * 64; room *= 2) {
    std::vector<cpu_set_t> sets(static_cast<std::size_t>(room / CPU_SETSIZE));
    const std::size_t bytes = sets.size() * sizeof(cpu_set_t);
    if (::sched_getaffinity(0, bytes, sets.data()) == 0) return CPU_COUNT_S(bytes, sets.data());
  }
  return machine;
}

}  // namespace

int Processors::usable() const {
  int count = std::min(machine, bound);
  if (quota > 0) count = std::min(count, static_cast<int>(std::ceil(quota)));
  if (task > 0) count = std::min(count, task);
  return std::max(1, count);
}

Processors find_processors(const fs::path& root, const AskVariable& ask) {
  Processors found;
  found.machine = static_cast<int>(std::max(1L, ::sysconf(_SC_NPROCESSORS_ONLN)));
  found.bound = bound_processors(found.machine);
  double quota = std::numeric_limits<double>::infinity();
  each_group(root, "cpu", [&](const fs::path& group, int version) {
    std::vector<double> numbers = numbers_in(group / (version == 2 ? "cpu.max" : "cpu.cfs_quota_us"));
    if (version == 1 && numbers.size() == 1) {  // -1: no limit
      const std::vector<double> period = numbers_in(group / "cpu.cfs_period_us");
      numbers.insert(numbers.end(), period.begin(), period.end());
    }
    if (numbers.size() == 2 && numbers[0] > 0 && numbers[1] > 0) quota = std::min(quota, numbers[0] / numbers[1]);
  });
  if (std::isfinite(quota)) found.quota = quota;
  if (const char* task = ask("SLURM_CPUS_PER_TASK")) {
    const std::string_view text = task;
    std::from_chars(text.data(), text.data() + text.size(), found.task);
  }

  found.reason = fmt::format("{} of {} may be used", found.usable(), found.machine);
  const auto add = [&](bool there, const std::string& why) {
    if (there) found.reason += (found.reason.ends_with("used") ? ": " : ", ") + why;
  };
  add(found.bound < found.machine, fmt::format("the process is bound to {} (taskset, cpuset)", found.bound));
  add(found.quota > 0, fmt::format("its control group has the time of {:g}", found.quota));
  add(found.task > 0, fmt::format("SLURM_CPUS_PER_TASK is {}", found.task));
  const char* open_mp = ask("OMP_NUM_THREADS");
  if (open_mp != nullptr) found.reason += "; OMP_NUM_THREADS is not obeyed, --threads is";
  return found;
}

int worker_count(int threads) {
  static const int usable = find_processors().usable();
  return threads > 0 ? threads : usable;
}

double usable_memory(const fs::path& root) {
  double memory = static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  each_group(root, "memory", [&](const fs::path& group, int version) {
    const std::vector<double> limit = numbers_in(group / (version == 2 ? "memory.max" : "memory.limit_in_bytes"));
    if (!limit.empty() && limit[0] > 0) memory = std::min(memory, limit[0]);
  });
  return memory;
}

}  // namespace granuscope
