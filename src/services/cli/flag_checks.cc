#include "cli/flag_checks.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <thread>

#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
CLI::Option* add_key(CLI::App& verb, const Key& key, const std::string& about) {
  const std::string flag = flag_of(key);
  const std::string told =
      key.unit.empty() || !about.empty() ? key.meaning : fmt::format("{} [{}]", key.meaning, key.unit);
  const auto read = [key, flag](const std::string& text) {
    try {
      key.read(text);
    } catch (const InputError& error) {
      throw CLI::ValidationError(flag, error.what());
    }
  };
  const KeyValue like = key.get();
  if (std::holds_alternative<bool>(like))
    return verb.add_flag_callback(
        flag, [read] { read("true"); }, told);
  return verb.add_option_function<std::string>(flag, read, about.empty() ? told : about)
      ->default_str(key.text())
      ->type_name(std::holds_alternative<std::int64_t>(like) ? "INT"
                  : std::holds_alternative<double>(like)     ? "FLOAT"
                                                             : "TEXT");
}

CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        try {
          std::uint64_t number = 0;
          key_fields::from_text(number, text);
        } catch (const InputError& error) {
          return error.what();
        }
        return "";
      },
      "", "");
}

CLI::Validator output_file() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        if (text != "-") return "";
        return "a file is written whole or not at all, which a stream cannot be; name a file, or write ./- for one of "
               "that name";
      },
      "", "");
}

void OutputFile::require_free(const std::vector<std::filesystem::path>& inputs, std::string_view begins) const {
  require_not_input(path, inputs);
  if (!force) require_replaceable(path, begins);
}

void OutputFile::write(std::string_view bytes, const std::vector<std::filesystem::path>& inputs) const {
  require_free(inputs, bytes);
  write_file(path, bytes);
}

CLI::Option* add_output(CLI::App& verb, const std::string& names, OutputFile& file, const std::string& about) {
  verb.add_flag("--force", file.force, "replace a file that granuscope has not written");
  return verb.add_option(names, file.path, about)->check(output_file());
}

namespace {

namespace fs = std::filesystem;

/// The number in a file, if there is one: a group without limit says "max".
void lower_to_limit_in(const fs::path& file, double& memory) {
  std::ifstream in(file);
  double limit = 0;
  if (in >> limit && limit > 0) memory = std::min(memory, limit);
}

/// Lowers `memory` to the limits of a control group and of all above it. Where the group's own name is not mounted, as
/// in most containers, what is mounted is its own.
void lower_to_group(const fs::path& mount, const fs::path& group, const char* limit_file, double& memory) {
  for (fs::path at = group.relative_path();; at = at.parent_path()) {
    lower_to_limit_in(mount / at / limit_file, memory);
    if (at.empty()) return;
  }
}

}  // namespace

double usable_memory(const fs::path& root) {
  double memory = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  const fs::path mount = root / "sys/fs/cgroup";
  // Lines "0::/group" (version 2) and "4:memory:/group" (version 1).
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path group = line.substr(second + 1);
    if (controllers.empty()) lower_to_group(mount, group, "memory.max", memory);
    if (controllers == "memory") lower_to_group(mount / "memory", group, "memory.limit_in_bytes", memory);
  }
  return memory;
}

int worker_count(int threads) {
  return threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

void require_memory(double bytes) {
  const double memory = usable_memory();
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      fmt::format("about {} of memory are needed but this machine, or its container, has {}; make the pile smaller or "
                  "use fewer --threads",
                  describe_bytes(bytes), describe_bytes(memory)));
}

}  // namespace granuscope
