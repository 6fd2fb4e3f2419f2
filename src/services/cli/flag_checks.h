#pragma once
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/verbs.h"
#include "support/error.h"
#include "support/files.h"
#include "support/key.h"
#include "support/plain_text.h"

// What every verb includes.
namespace granuscope {
/// The flag of a key: it says what the key means, or `about`, and a whole number beyond its field is refused, which
/// CLI11's own conversion silently takes for the largest one.
CLI::Option* add_key(CLI::App& verb, const Key& key, const std::string& about = "");

/// Makes the option one whose values stand between commas, with blanks or without.
CLI::Option* listed(CLI::Option* option);

/// A file to be written. "-" would make a file of that name where a stream may have been meant.
CLI::Validator output_file();

/// The suffix of a name, in lower case with its point, and the format that it says.
using SuffixOfFormat = std::pair<std::string_view, std::string_view>;

/// The format of a file to be written: what --format says (`asked`), or the suffix where it says nothing; both are to
/// say the same. `others`: with --format a name may have another suffix. Throws InputError.
std::string format_by_name(const std::string& file, const std::string& asked, std::span<const SuffixOfFormat> known,
                           bool others = false);

/// Throws InputError if the name says another format than the one that is written, whose suffix is `own`.
void require_suffix(const std::string& file, std::string_view own);

/// A file that a verb leaves, and whether it may take the place of one that this program has not written.
struct OutputFile {
  std::string path;
  bool force = false;

  bool asked() const { return !path.empty(); }
  /// Throws InputError for a file that would be lost: of somebody else, or one of those that the verb reads.
  void require_free(const std::vector<std::filesystem::path>& inputs, std::string_view begins = {}) const;
  /// Holds `bytes` against what is there, and writes them.
  void write(std::string_view bytes, const std::vector<std::filesystem::path>& inputs = {}) const;
};

/// Adds the option that names the file, and --force.
CLI::Option* add_output(CLI::App& verb, const std::string& names, OutputFile& file, const std::string& about);

/// The configuration of an ensemble; "" for a file that is none, which is then read, or refused, as a pile.
std::string configuration_if_ensemble(const std::string& file);

/// Throws EnvironmentError if the usable memory is smaller than `bytes`: the system would only kill the program
/// half way instead of refusing the memory.
void require_memory(double bytes, const char* advice = "make the pile smaller or use fewer --threads");

/// Memory of one pile under work, per bead: its forces and what a solver keeps beside them, in bytes.
inline constexpr double bytes_per_bead = 100;

}  // namespace granuscope
