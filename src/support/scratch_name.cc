#include "support/scratch_name.h"

#include <fmt/format.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

namespace granuscope {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kept_letters = 100;

/// ".granuscope-<machine>-": what all such names on this machine begin with.
const std::string& prefix() {
  static const std::string text = [] {
    std::array<char, 256> name = {};
    if (::gethostname(name.data(), name.size() - 1) != 0) name.front() = '\0';
    std::string machine = std::string(name.data()).substr(0, 64);
    for (char& c : machine) {
      if (c == '/') c = '_';
    }
    return fmt::format(".granuscope-{}-", machine);
  }();
  return text;
}

/// A process that has ended keeps its number until its parent takes note, which may be never.
bool has_ended(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');  // "17 (name) Z 1 ...": the name may hold anything
  return name_end != std::string::npos && name_end + 2 < line.size() &&
         (line[name_end + 2] == 'Z' || line[name_end + 2] == 'X');
}

bool is_running(pid_t process) { return (::kill(process, 0) == 0 || errno == EPERM) && !has_ended(process); }

/// Whether this is the name of something that nobody works on any more.
bool is_leftover(std::string_view name) {
  if (!name.starts_with(prefix())) return false;
  name.remove_prefix(prefix().size());
  pid_t process = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), process);
  return error == std::errc() && end != name.data() + name.size() && *end == '-' && process > 0 && !is_running(process);
}

}  // namespace

std::string scratch_name(const std::string& name) {
  static std::atomic<unsigned long> counter{0};
  const std::string tail = name.size() > kept_letters ? name.substr(name.size() - kept_letters) : name;
  return fmt::format("{}{}-{}-{}", prefix(), ::getpid(), counter.fetch_add(1), tail);
}

int remove_leftovers(const fs::path& folder) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (auto at = fs::directory_iterator(folder, ignored); !ignored && at != fs::directory_iterator();
       at.increment(ignored)) {
    if (is_leftover(at->path().filename().string())) found.push_back(at->path());
  }
  int removed = 0;
  for (const fs::path& path : found) {
    fs::remove_all(path, ignored);
    if (!ignored) ++removed;
  }
  return removed;
}

}  // namespace granuscope
