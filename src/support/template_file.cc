#include "support/template_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace granuscope {

std::string_view template_file(std::string_view name) {
  const std::span<const EmbeddedFile> files = embedded_files();
  const auto found =
      std::lower_bound(files.begin(), files.end(), name,
                       [](const EmbeddedFile& file, std::string_view wanted) { return file.name < wanted; });
  if (found == files.end() || found->name != name) {
    throw std::logic_error(fmt::format("no file templates/{} was built into the program", name));
  }
  return found->content;
}

}  // namespace granuscope
