#include "cli/flag_checks.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "cli/in_process.h"
#include "kit/temporary_folder.h"
#include "support/error.h"

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

TEST_CASE("more memory than there is is refused in words") {
  CHECK_NOTHROW(require_memory(1e6));
  CHECK_THROWS_AS(require_memory(1e18), EnvironmentError);
}
