#include "support/provenance.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <openssl/crypto.h>
#include <sched.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <string_view>
#include <thread>

#include "generated/build_facts.h"
#include "generated/git_state.h"
#include "support/files.h"

namespace granuscope {
namespace {
std::string without_spaces_and_quotes(const std::string& text) {
  const char* unwanted = " \t\r\"'";
  const std::size_t first = text.find_first_not_of(unwanted);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(unwanted) - first + 1);
}

/// The value of the first line "name <separator> value", or nothing.
std::string value_in(const char* file, std::string_view name, char separator) {
  std::ifstream input(file);
  std::string line;
  while (std::getline(input, line)) {
    const std::size_t mark = line.find(separator);
    if (mark != std::string::npos && without_spaces_and_quotes(line.substr(0, mark)) == name) {
      return without_spaces_and_quotes(line.substr(mark + 1));
    }
  }
  return "";
}

std::string host_cpu(const utsname& system) {
  // x86 has "model name"; ARM and others often only the machine's name, or nothing.
  for (const char* name : {"model name", "Model", "Hardware", "cpu"}) {
    std::string value = value_in("/proc/cpuinfo", name, ':');
    if (!value.empty()) return value;
  }
  std::string machine = system.machine;
  return machine.empty() ? "unknown" : machine;
}

std::string operating_system(const utsname& system) {
  std::string name = value_in("/etc/os-release", "PRETTY_NAME", '=');
  if (name.empty()) name = "unknown distribution";
  return fmt::format("{}, {} {} {}", name, system.sysname, system.release, system.machine);
}

/// "name version;name version" as the build wrote it.
std::vector<std::pair<std::string, std::string>> listed(std::string_view text) {
  std::vector<std::pair<std::string, std::string>> result;
  while (!text.empty()) {
    const std::size_t end = text.find(';');
    const std::string_view entry = text.substr(0, end);
    const std::size_t space = entry.rfind(' ');
    if (space != std::string_view::npos && space + 1 < entry.size()) {
      result.emplace_back(entry.substr(0, space), entry.substr(space + 1));
    }
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return result;
}

std::vector<std::pair<std::string, std::string>> libraries() {
  std::vector<std::pair<std::string, std::string>> result = listed(build_facts::libraries);
  for (const char* name : {"OpenSSL", "glibc"}) result.emplace_back(name, "unknown");
  for (auto& [name, version] : result) version = loaded_version(name).value_or(version);
  return result;
}

/// Instruction sets that libraries choose their code by: numbers may differ in their last bits with them.
std::string processor_features() {
  std::string features;
  const auto add = [&](const char* name, bool there) {
    if (there) features += (features.empty() ? "" : " ") + std::string(name);
  };
#if defined(__x86_64__)
  add("sse4.2", __builtin_cpu_supports("sse4.2") != 0);
  add("avx", __builtin_cpu_supports("avx") != 0);
  add("fma", __builtin_cpu_supports("fma") != 0);
  add("avx2", __builtin_cpu_supports("avx2") != 0);
  add("avx512f", __builtin_cpu_supports("avx512f") != 0);
  add("avx512dq", __builtin_cpu_supports("avx512dq") != 0);
#else
  add("not asked for", true);
#endif
  return features;
}

}  // namespace

Provenance collect_provenance() {
  utsname system = {};
  ::uname(&system);
  Provenance result;
  result.program_version = build_facts::program_version;
  result.git_commit = git_state::commit;
  result.git_dirty = git_state::dirty;
  result.compiler = build_facts::compiler;
  result.compiler_flags = build_facts::compiler_flags;
  result.build_type = build_facts::build_type;
  result.libraries = libraries();
  result.host_cpu = host_cpu(system);
  result.processor_features = processor_features();
  result.operating_system = operating_system(system);
  result.hardware_threads = std::thread::hardware_concurrency();
  return result;
}

std::string provenance_line(const Provenance& provenance) {
  return fmt::format("{}, commit {}{}, {}", provenance.program_version, provenance.git_commit,
                     provenance.git_dirty ? " with uncommitted changes" : "", provenance.compiler);
}

std::string current_time() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts = {};
  ::gmtime_r(&now, &parts);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min, parts.tm_sec);
}

namespace {

// The libraries of higher rooms are asked through the loader, so that no header of theirs is needed here.

template <class Symbol>
Symbol* loaded(const char* name) {
  return reinterpret_cast<Symbol*>(::dlsym(RTLD_DEFAULT, name));
}

std::optional<std::string> hdf5() {
  auto* const ask = loaded<int(unsigned*, unsigned*, unsigned*)>("H5get_libversion");
  unsigned major = 0, minor = 0, release = 0;
  if (ask == nullptr || ask(&major, &minor, &release) < 0) return {};
  return fmt::format("{}.{}.{}", major, minor, release);
}

std::optional<std::string> libpng() {
  auto* const ask = loaded<unsigned()>("png_access_version_number");
  if (ask == nullptr) return {};
  const unsigned version = ask();
  return fmt::format("{}.{}.{}", version / 10000, version / 100 % 100, version % 100);
}

std::optional<std::string> freetype() {
  auto* const open = loaded<int(void**)>("FT_Init_FreeType");
  auto* const ask = loaded<void(void*, int*, int*, int*)>("FT_Library_Version");
  auto* const close = loaded<int(void*)>("FT_Done_FreeType");
  void* library = nullptr;
  if (open == nullptr || ask == nullptr || close == nullptr || open(&library) != 0) return {};
  int major = 0, minor = 0, patch = 0;
  ask(library, &major, &minor, &patch);
  close(library);
  return fmt::format("{}.{}.{}", major, minor, patch);
}

}  // namespace

std::optional<std::string> loaded_version(const std::string& library) {
  if (library == "GSL") {
    const auto* const version = loaded<const char*>("gsl_version");
    if (version != nullptr) return *version;
  } else if (library == "HDF5") {
    return hdf5();
  } else if (library == "libpng") {
    return libpng();
  } else if (library == "FreeType") {
    return freetype();
  } else if (library == "OpenSSL") {
    return OpenSSL_version(OPENSSL_VERSION_STRING);
  } else if (library == "glibc") {
    return gnu_get_libc_version();
  }
  return {};
}

namespace {

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
    up(path_exists(mount / controllers) ? mount / controllers : mount / controller, group, 1);
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
