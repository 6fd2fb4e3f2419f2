#include "support/provenance.h"

#include <sched.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "kit/temporary_folder.h"

using namespace granuscope;
namespace fs = std::filesystem;

namespace {

void put(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

}  // namespace

TEST_CASE("the memory of a container is what it was given, not what the machine has") {
  const test::TemporaryFolder scratch;
  const double machine = usable_memory(scratch.path());  // no groups at all
  CHECK(machine > 1e8);

  const fs::path second = scratch / "second", groups = second / "sys/fs/cgroup";
  put(second / "proc/self/cgroup", "0::/runner/job\n");
  put(groups / "memory.max", "max\n");
  CHECK(usable_memory(second) == machine);
  put(groups / "runner/job/memory.max", "max\n");
  put(groups / "runner/memory.max", "50000000\n");  // a limit above the group counts, too
  CHECK(usable_memory(second) == 5e7);
  put(groups / "runner/job/memory.max", "40000000\n");
  CHECK(usable_memory(second) == 4e7);

  const fs::path inside = scratch / "inside";  // the group's name is not seen inside the container
  put(inside / "proc/self/cgroup", "0::/\n");
  put(inside / "sys/fs/cgroup/memory.max", "30000000\n");
  CHECK(usable_memory(inside) == 3e7);

  const fs::path first = scratch / "first";
  put(first / "proc/self/cgroup", "12:cpu,cpuacct:/docker/1\n4:memory:/docker/1\n0::/docker/1\n");
  put(first / "sys/fs/cgroup/memory/memory.limit_in_bytes", "20000000\n");
  CHECK(usable_memory(first) == 2e7);
  put(first / "sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");  // none
  CHECK(usable_memory(first) == machine);
}

TEST_CASE("processors are those that the process may use, by every limit there is") {
  const test::TemporaryFolder scratch;
  std::map<std::string, std::string> variables;
  const AskVariable ask = [&](const char* name) -> const char* {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  };
  const Processors machine = find_processors(scratch.path(), ask);  // no groups, no variables
  CHECK(machine.machine >= 1);
  CHECK(machine.quota == 0);
  CHECK(machine.usable() == std::min(machine.machine, machine.bound));

  const fs::path groups = scratch / "sys/fs/cgroup";
  put(groups / "cpu.max", "max 100000\n");
  CHECK(find_processors(scratch.path(), ask).quota == 0);
  put(groups / "cpu.max", "50000 100000\n");
  CHECK(find_processors(scratch.path(), ask).quota == 0.5);  // also where /proc is not mounted
  CHECK(find_processors(scratch.path(), ask).usable() == 1);
  put(scratch / "proc/self/cgroup", "0::/job/step\n");
  put(groups / "job/cpu.max", "20000 100000\n");
  CHECK(find_processors(scratch.path(), ask).quota == 0.2);

  const fs::path first = scratch / "first", account = first / "sys/fs/cgroup/cpu,cpuacct";
  put(first / "proc/self/cgroup", "3:cpuset:/a\n2:cpu,cpuacct:/a/b\n1:name=systemd:/a\n");
  put(account / "a/b/cpu.cfs_quota_us", "-1\n");
  put(account / "a/b/cpu.cfs_period_us", "100000\n");
  CHECK(find_processors(first, ask).quota == 0);
  put(account / "a/cpu.cfs_quota_us", "150000\n");
  put(account / "a/cpu.cfs_period_us", "100000\n");
  CHECK(find_processors(first, ask).quota == 1.5);

  variables = {{"SLURM_CPUS_PER_TASK", "1"}, {"OMP_NUM_THREADS", "3"}};
  CHECK(find_processors("/", ask).usable() == 1);
  CHECK_THAT(find_processors("/", ask).reason,
             Catch::Contains("SLURM_CPUS_PER_TASK is 1") && Catch::Contains("OMP_NUM_THREADS is not obeyed"));

  Processors many;
  many.machine = 128;
  many.bound = 64;
  CHECK(many.usable() == 64);
  many.quota = 2.5;  // a part of a processor is used, too
  CHECK(many.usable() == 3);
  many.task = 2;
  CHECK(many.usable() == 2);

  // What taskset and cpusets set; the process gets its own back.
  cpu_set_t before, one;
  REQUIRE(::sched_getaffinity(0, sizeof before, &before) == 0);
  CPU_ZERO(&one);
  for (int i = 0; CPU_COUNT(&one) == 0; ++i) {
    if (CPU_ISSET(i, &before)) CPU_SET(i, &one);
  }
  REQUIRE(::sched_setaffinity(0, sizeof one, &one) == 0);
  const Processors bound = find_processors(scratch.path(), ask);
  ::sched_setaffinity(0, sizeof before, &before);
  CHECK(bound.bound == 1);
  CHECK(bound.usable() == 1);
}
