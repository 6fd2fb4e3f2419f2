#include "cli/flag_checks.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <system_error>

#include "support/error.h"
#include "support/files.h"
#include "support/machine.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// How a text reads as a whole number.
std::errc read_whole(const std::string& text, std::int64_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end != text.data() + text.size() ? std::errc::invalid_argument : error;
}

}  // namespace

CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        std::uint64_t number = 0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (error == std::errc() && end == text.data() + text.size()) return "";
        if (!text.empty() && text[0] == '-') return single_line(text) + " is negative; give 0 or more";
        if (error == std::errc::result_out_of_range) {
          return fmt::format("{} is too large; give at most {}", single_line(text),
                             std::numeric_limits<std::uint64_t>::max());
        }
        return single_line(text) + " is not a whole number; write it in digits";
      },
      "", "");
}

CLI::Validator lattice_side() {
  return CLI::Validator(
      [](const std::string& text) -> std::string {
        std::int64_t number = 0;
        const std::errc error = read_whole(text, number);
        if (error == std::errc::invalid_argument)
          return single_line(text) + " is not a whole number; write it in digits";
        if (error == std::errc() && number <= std::numeric_limits<int>::max()) return "";  // too few: the lattice says
        const double beads = std::strtod(text.c_str(), nullptr);
        return fmt::format("{} beads in a row would need about {} of memory for a single row; give fewer",
                           single_line(text), describe_bytes(beads * bytes_per_bead));
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

void require_memory(double bytes) {
  const double memory = usable_memory();
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      fmt::format("about {} of memory are needed but this machine, or its container, has {}; make the pile smaller or "
                  "use fewer --threads",
                  describe_bytes(bytes), describe_bytes(memory)));
}

}  // namespace granuscope
