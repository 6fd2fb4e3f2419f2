#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace granuscope {
/// One who is named as author: a person by both names, or a group by its own.
struct Author {
  std::string name;
  bool is_person = false;
  std::string given_name, family_name;
  std::string orcid;        ///< as a URL; empty if none is told
  std::string affiliation;  ///< empty if none is told
};

/// What a CITATION.cff (Citation File Format 1.2) says of a work, as far as an archive passes it on.
struct Citation {
  std::string title;
  std::vector<std::string> licenses;  ///< by their SPDX names; any of them may be chosen
  std::string license_url, doi;       ///< each empty if it is not told
  std::vector<Author> authors;
};

/// Throws InputError for a file that cannot be read or names no authors.
Citation read_citation(const std::filesystem::path& file);

/// A file in an archive: its name there, and what is in it.
struct ZipEntry {
  std::string name;            ///< with forward slashes
  std::filesystem::path file;  ///< where its bytes are read from, or, if this is empty,
  std::string bytes;           ///< what they are
};

/// Writes an archive with these entries in their order, all with one time of change ("2026-01-31T02:00:00Z", written as
/// it stands, in whatever time zone): the same entries give the same bytes. It appears whole or not at all. Throws
/// EnvironmentError.
void write_zip(const std::filesystem::path& target, const std::vector<ZipEntry>& entries, const std::string& time);

/// How a finished run is packed.
struct PackOptions {
  std::optional<Citation> citation;  ///< whose run it is, and under which licence; none: nobody is named
  bool with_ensembles = false;       ///< all that was drawn, too, which is most of the bytes
  std::filesystem::path sources;     ///< a clone with the program's commit, which is packed, too; empty: none
};

/// Writes a finished run as one archive (zip) with ro-crate-metadata.json, a Process Run Crate 0.5 (RO-Crate 1.1): what
/// each file is, with its SHA-256, and which program, commit and command made them from which experiment, when and for
/// whom; and with codecheck.yml, which names the figures and tables that a codechecker is to make again. The same run
/// gives the same bytes. Returns how many files are in it. Throws InputError for a folder whose last run did not come
/// to its report, or whose files are not those that it left, or a clone that lacks the commit; EnvironmentError if the
/// archive cannot be written.
std::size_t pack_run(const std::filesystem::path& run_folder, const std::filesystem::path& archive,
                     const PackOptions& options);

}  // namespace granuscope
