#pragma once
#include <filesystem>
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
  std::string title, license, doi;  ///< license by its SPDX name; each empty if it is not told
  std::vector<Author> authors;
};

/// Throws InputError for a file that cannot be read or names no authors.
Citation read_citation(const std::filesystem::path& file);

}  // namespace granuscope
