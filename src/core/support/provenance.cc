#include "support/provenance.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <openssl/crypto.h>
#include <sys/utsname.h>

#include <chrono>
#include <ctime>
#include <fstream>
#include <string_view>
#include <thread>

#include "generated/build_facts.h"
#include "generated/git_state.h"

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

}  // namespace granuscope
