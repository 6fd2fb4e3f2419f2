#include "report/citation.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "support/atomic_file.h"
#include "support/error.h"
#include "support/single_line.h"

namespace granuscope {
namespace {

std::string text_of(const YAML::Node& holder, const char* key) {
  const YAML::Node value = holder[key];
  return value && value.IsScalar() ? value.Scalar() : "";
}

Author author_from(const YAML::Node& told) {
  Author author;
  author.family_name = text_of(told, "family-names");
  if (const std::string particle = text_of(told, "name-particle"); !particle.empty()) {
    author.family_name = particle + " " + author.family_name;
  }
  author.given_name = text_of(told, "given-names");
  author.is_person = !author.family_name.empty() || !author.given_name.empty();
  author.name = text_of(told, "name");
  if (author.is_person) {
    const bool both = !author.given_name.empty() && !author.family_name.empty();
    author.name = author.given_name + (both ? " " : "") + author.family_name;
  }
  author.orcid = text_of(told, "orcid");
  author.affiliation = text_of(told, "affiliation");
  return author;
}

}  // namespace

Citation read_citation(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        fmt::format("{}: {}, so that nobody can be named by it; give a CITATION.cff with authors (Citation "
                    "File Format 1.2)",
                    file.string(), what));
  };
  Citation citation;
  try {
    const YAML::Node root = YAML::Load(read_file(file));
    if (!root.IsMap()) refuse("this is no citation file");
    citation = {text_of(root, "title"), text_of(root, "license"), text_of(root, "doi"), {}};
    if (const YAML::Node authors = root["authors"]; authors && authors.IsSequence()) {
      for (const YAML::Node& one : authors) {
        if (!one.IsMap()) continue;
        if (Author author = author_from(one); !author.name.empty()) citation.authors.push_back(std::move(author));
      }
    }
  } catch (const YAML::Exception& error) {
    refuse("this is no YAML (" + single_line(error.what()) + ")");
  }
  if (citation.authors.empty()) refuse("it names no authors");
  return citation;
}

}  // namespace granuscope
