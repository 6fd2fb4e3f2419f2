#include "support/scratch_name.h"

#include <fmt/format.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>
#include <vector>

namespace granuscope {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kept_letters = 100;
constexpr unsigned long largest_process = std::numeric_limits<pid_t>::max();

/// Numbers of processes mean something within one namespace only: a container may share folder and machine name with
/// others, and would take their running processes for ended ones. 0 where the system does not tell.
unsigned long process_namespace() {
  struct stat status = {};
  return ::stat("/proc/self/ns/pid", &status) == 0 ? static_cast<unsigned long>(status.st_ino) : 0;
}

/// ".granuscope-<machine>-<namespace>-": what all such names begin with where numbers of processes mean the same.
const std::string& prefix() {
  static const std::string text = [] {
    std::array<char, 256> name = {};
    if (::gethostname(name.data(), name.size() - 1) != 0) name.front() = '\0';
    std::string machine = std::string(name.data()).substr(0, 64);
    for (char& c : machine) {
      if (c == '/') c = '_';
    }
    return fmt::format(".granuscope-{}-{:x}-", machine, process_namespace());
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

/// Takes "17-" off the front of `text`; 0 if it does not begin so.
unsigned long take_number(std::string_view& text) {
  unsigned long number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end == text.data() + text.size() || *end != '-') return 0;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
  return number;
}

/// Whether this is the name of something that nobody works on any more.
bool is_leftover(std::string_view name) {
  if (!name.starts_with(prefix())) return false;
  name.remove_prefix(prefix().size());
  const unsigned long process = take_number(name);
  return process > 0 && process <= largest_process && !is_running(static_cast<pid_t>(process));
}

std::string last_letters(const std::string& name) {
  return name.size() > kept_letters ? name.substr(name.size() - kept_letters) : name;
}

/// Removes from the folder what has a name that `wanted` accepts; how many there were.
template <class Wanted>
int remove_named(const fs::path& folder, const Wanted& wanted) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (auto at = fs::directory_iterator(folder, ignored); !ignored && at != fs::directory_iterator();
       at.increment(ignored)) {
    if (wanted(at->path().filename().string())) found.push_back(at->path());
  }
  int removed = 0;
  for (const fs::path& path : found) {
    fs::remove_all(path, ignored);
    if (!ignored) ++removed;
  }
  return removed;
}

}  // namespace

std::string scratch_name(const std::string& name) {
  static std::atomic<unsigned long> counter{1};
  return fmt::format("{}{}-{}-{}", prefix(), ::getpid(), counter.fetch_add(1), last_letters(name));
}

int remove_leftovers(const fs::path& folder) {
  return remove_named(folder, [](std::string_view name) { return is_leftover(name); });
}

int remove_leftovers_of(const fs::path& file) {
  const std::string tail = last_letters(file.filename().string());
  return remove_named(file.has_parent_path() ? file.parent_path() : fs::path("."), [&tail](std::string_view name) {
    if (!name.ends_with(tail) || !is_leftover(name)) return false;
    name.remove_prefix(prefix().size());
    return take_number(name) > 0 && take_number(name) > 0 && name == tail;  // behind process and count
  });
}

}  // namespace granuscope
