#include "support/provenance.h"

#include <sched.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "kit/temporary_folder.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using granuscope::test::TemporaryFolder;

namespace {

using Catch::Matchers::Contains;

/// The text with each run of digits as '1': "12.2.0" becomes "1.1.1". (No <regex>: g++ 12 warns inside it when
/// sanitizers are on.)
std::string pattern_of(const std::string& text) {
  std::string pattern;
  for (const char letter : text) {
    const bool digit = letter >= '0' && letter <= '9';
    if (!digit) pattern += letter;
    if (digit && (pattern.empty() || pattern.back() != '1')) pattern += '1';
  }
  return pattern;
}

bool is_commit(const std::string& text) {
  return text.size() >= 40 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Whether a word of the text is an absolute path.
bool holds_path(const std::string& text) {
  for (const char* start : {" /", "=/", "I/", "L/"}) {
    if (text.find(start) != std::string::npos) return true;
  }
  return !text.empty() && text.front() == '/';
}

/// What cmake/git_state.cmake writes for a source folder.
std::string git_state_of(const std::filesystem::path& source) {
  const TemporaryFolder folder;
  ProcessSpec spec;
  const std::string script = std::string(GRANUSCOPE_SOURCE_DIR) + "/cmake/git_state.cmake";
  const std::string output = folder / "git_state.h";
  spec.arguments = {"cmake", "-DSOURCE_DIR=" + source.string(), "-DOUTPUT=" + output, "-P", script};
  const ProcessResult result = run_process(spec);
  INFO(result.standard_error);
  REQUIRE(result.exit_code == 0);
  return read_file(folder / "git_state.h");
}

void git(const std::filesystem::path& folder, std::vector<std::string> arguments) {
  ProcessSpec spec;
  spec.arguments = {"git", "-c", "user.name=n", "-c", "user.email=e@example.org", "-C", folder.string()};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  const ProcessResult result = run_process(spec);
  INFO(result.standard_error);
  REQUIRE(result.exit_code == 0);
}

}  // namespace

TEST_CASE("provenance knows the program, its build and its machine") {
  const Provenance provenance = collect_provenance();
  CHECK(pattern_of(provenance.program_version) == "granuscope 1.1.1");
  CHECK((provenance.git_commit == "unknown" || is_commit(provenance.git_commit)));
  CHECK_THAT(pattern_of(provenance.compiler), Contains(" 1.1"));
  CHECK_THAT(provenance.compiler_flags, Contains("-ffp-contract=off") && Contains("-std=c++20"));
  CHECK_FALSE(provenance.build_type.empty());
  CHECK_FALSE(provenance.host_cpu.empty());
  CHECK_THAT(provenance.operating_system, Contains("Linux"));
  CHECK(provenance.hardware_threads >= 1);

  std::set<std::string> names;
  for (const auto& [name, version] : provenance.libraries) {
    CHECK_THAT(pattern_of(version), Catch::StartsWith("1.1"));
    names.insert(name);
  }
  CHECK(names.size() == provenance.libraries.size());
  for (const char* name : {"Eigen", "GLPK", "GSL", "HDF5", "libpng", "FreeType", "fmt", "Highway", "OpenSSL"}) {
    CHECK(names.count(name) == 1);
  }
}

TEST_CASE("nothing baked in is a path of the building machine") {
  const Provenance provenance = collect_provenance();
  CHECK_FALSE(holds_path(provenance.compiler_flags));
  CHECK_FALSE(holds_path(provenance.compiler));
  CHECK_FALSE(holds_path(provenance_line(provenance)));
}

TEST_CASE("the line for a picture is stable and says whether the sources were changed") {
  Provenance provenance;
  provenance.program_version = "granuscope 1.2.3";
  provenance.git_commit = "0123";
  provenance.compiler = "GNU 12.2.0";
  provenance.host_cpu = "some host";
  CHECK(provenance_line(provenance) == "granuscope 1.2.3, commit 0123, GNU 12.2.0");
  provenance.git_dirty = true;
  CHECK(provenance_line(provenance) == "granuscope 1.2.3, commit 0123 with uncommitted changes, GNU 12.2.0");
}

TEST_CASE("the time is ISO 8601 in UTC") {
  const std::string time = current_time();
  CHECK(time.size() == std::string("2002-03-14T15:09:26Z").size());
  CHECK(pattern_of(time) == "1-1-1T1:1:1Z");
  CHECK(time.substr(0, 2) == "20");
}

TEST_CASE("the commit and the dirty flag follow the checkout") {
  if (!find_program("cmake") || !find_program("git")) return;
  const TemporaryFolder folder;
  CHECK_THAT(git_state_of(folder.path()), Contains("commit = \"unknown\"") && Contains("dirty = false"));

  git(folder.path(), {"init", "-q"});
  CHECK_THAT(git_state_of(folder.path()), Contains("commit = \"unknown\"") && Contains("dirty = false"));
  make_folder(folder / "src");
  write_file(folder / "src/a.cc", "1");
  git(folder.path(), {"add", "."});
  git(folder.path(), {"commit", "-q", "-m", "first"});
  const std::string clean = git_state_of(folder.path());
  const std::string before_commit = "commit = \"";
  REQUIRE_THAT(clean, Contains(before_commit));
  CHECK(is_commit(clean.substr(clean.find(before_commit) + before_commit.size(), 40)));
  CHECK_THAT(clean, Contains("dirty = false"));

  // An author's own experiment changes nothing that is built; a new source file does.
  write_file(folder / "mine.toml", "1");
  CHECK(git_state_of(folder.path()) == clean);
  write_file(folder / "src/b.cc", "1");
  CHECK_THAT(git_state_of(folder.path()), Contains("dirty = true"));
  std::filesystem::remove(folder / "src/b.cc");
  write_file(folder / "src/a.cc", "2");
  CHECK_THAT(git_state_of(folder.path()), Contains("dirty = true"));

  // A source archive unpacked inside somebody's checkout is not that checkout.
  CHECK_THAT(git_state_of(folder / "src"), Contains("commit = \"unknown\"") && Contains("dirty = false"));
}

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
