#include "cli/flag_checks.h"

#include <fmt/core.h>

#include <cstdint>
#include <string>

#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/machine.h"
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

std::string configuration_if_ensemble(const std::string& file) {
  try {
    return read_ensemble_configuration(file);
  } catch (const InputError&) {
    return "";
  }
}

void require_memory(double bytes) {
  const double memory = usable_memory();
  if (!(bytes > memory)) return;
  throw EnvironmentError(
      "about {} of memory are needed but this machine, or its container, has {}; make the pile smaller or use fewer "
      "--threads",
      describe_bytes(bytes), describe_bytes(memory));
}

}  // namespace granuscope
