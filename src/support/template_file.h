#pragma once
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace granuscope {

/// A file of templates/, or an experiment of examples/, as it was when the program was built.
struct EmbeddedFile {
  /// Path below templates/, with forward slashes ("palette.txt", "plot/response.gp"), or "examples/quick.toml".
  std::string_view name;
  std::string_view content;  ///< every byte of it; valid as long as the program runs
};

/// Every file below templates/ and the experiments of examples/, sorted by name. They are compiled into the program
/// (cmake/embed.cmake), which therefore works without being installed.
std::span<const EmbeddedFile> embedded_files();

/// The content of templates/<name>, or of the file that use_templates put in its place. Throws std::logic_error if
/// there is no such file: names of templates come from the program, not from the user.
std::string_view template_file(std::string_view name);

/// The name under which template_file has a text in this language: `name` where use_templates replaced it, else that of
/// templates/<language>/, else `name`.
std::string name_in_language(const std::string& name, const std::string& language);

/// From now on the files below `folder` stand in for the built-in ones of the same name: an author's wording, language
/// or colours. An empty path takes them back. To be called before any other thread asks for a template. Throws
/// InputError if the folder cannot be read or holds a file that stands in for none.
void use_templates(const std::filesystem::path& folder);

/// The folder of use_templates; empty if there is none.
const std::filesystem::path& templates_folder();

/// A digest of all files of use_templates with their names, to be part of what decides whether pages and figures that
/// are there already are still those asked for; "" if there are none.
std::string templates_digest();

}  // namespace granuscope
