#pragma once
#include <span>
#include <string_view>

namespace granuscope {

/// A file of templates/ as it was when the program was built.
struct EmbeddedFile {
  std::string_view name;     ///< path below templates/, with forward slashes: "palette.txt", "plot/response.gp"
  std::string_view content;  ///< every byte of it; valid as long as the program runs
};

/// Every file below templates/, sorted by name. They are compiled into the program (cmake/embed.cmake), which therefore
/// works without being installed.
std::span<const EmbeddedFile> embedded_files();

/// The content of templates/<name>. Throws std::logic_error if there is no such file: names of templates come from the
/// program, not from the user.
std::string_view template_file(std::string_view name);

}  // namespace granuscope
