#include "cli/flag_checks.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/provenance.h"

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

CLI::Option* listed(CLI::Option* option) {
  const auto alone = [](const std::string& one) { return std::string(trimmed(one)); };
  return option->delimiter(',')->transform(alone)->expected(1)->take_all();
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

std::string format_by_name(const std::string& file, const std::string& asked, std::span<const SuffixOfFormat> known,
                           bool others) {
  const std::string suffix = suffix_of(file);
  const auto told = std::ranges::find(known, suffix, &SuffixOfFormat::first);
  if (told == known.end() && (asked.empty() || (!others && !suffix.empty()))) {
    std::vector<std::string_view> suffixes;
    for (const SuffixOfFormat& one : known) suffixes.push_back(one.first);
    throw InputError("the name {} does not say {}; let it end with {}{}", file,
                     asked.empty() ? "a format" : "the format " + asked, fmt::join(suffixes, ", "),
                     asked.empty() ? ", or give --format" : "");
  }
  if (told != known.end() && !asked.empty() && told->second != asked) {
    throw InputError("the name {} says {} and --format says {}; let both say the same", file, told->second, asked);
  }
  if (told != known.end()) return std::string(told->second);
  const auto own = std::ranges::find(known, asked, &SuffixOfFormat::second);
  if (own != known.end() && suffix != ".txt") require_suffix(file, own->first);
  return asked;
}

void require_suffix(const std::string& file, std::string_view own) {
  constexpr std::string_view well_known =
      " .csv .eps .gz .h5 .hdf5 .html .jpg .json .md .npz .pdf .png .svg .tar .tex .tgz .toml .txt .vtk .vtu .xml .xz "
      ".zip .7z .yml .yaml .gif .ps ";
  const std::string suffix = suffix_of(file);
  if (suffix == own || (own == ".h5" && suffix == ".hdf5") ||
      well_known.find(" " + suffix + " ") == std::string_view::npos)
    return;
  throw InputError("the name {} says another format than the one that is written; let it end with {}", file, own);
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

void require_memory(double bytes, const char* advice) {
  const double memory = usable_memory();
  if (!(bytes > memory)) return;
  throw EnvironmentError("about {} of memory are needed but this machine, or its container, has {}; {}",
                         describe_bytes(bytes), describe_bytes(memory), advice);
}

}  // namespace granuscope
