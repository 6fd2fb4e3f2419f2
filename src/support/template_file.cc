#include "support/template_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <stdexcept>

#include "support/atomic_file.h"
#include "support/digest.h"
#include "support/error.h"

namespace granuscope {
namespace {

namespace fs = std::filesystem;

struct StandIns {
  fs::path folder;
  std::map<std::string, std::string, std::less<>> files;
};

StandIns& stand_ins() {
  static StandIns instance;
  return instance;
}

const EmbeddedFile* find_embedded(std::string_view name) {
  const std::span<const EmbeddedFile> files = embedded_files();
  const auto found =
      std::lower_bound(files.begin(), files.end(), name,
                       [](const EmbeddedFile& file, std::string_view wanted) { return file.name < wanted; });
  return found == files.end() || found->name != name ? nullptr : &*found;
}

}  // namespace

std::string_view template_file(std::string_view name) {
  const auto& others = stand_ins().files;
  if (const auto other = others.find(name); other != others.end()) return other->second;
  const EmbeddedFile* file = find_embedded(name);
  if (file == nullptr) throw std::logic_error(fmt::format("no file templates/{} was built into the program", name));
  return file->content;
}

std::string name_in_language(const std::string& name, const std::string& language) {
  const std::string other = language + "/" + name;
  return stand_ins().files.contains(name) || find_embedded(other) == nullptr ? name : other;
}

void use_templates(const fs::path& folder) {
  StandIns given;
  given.folder = folder;
  std::error_code error;
  if (!folder.empty() && !fs::is_directory(folder, error)) {
    throw InputError(
        fmt::format("{}: there is no such folder to take templates from; name one that holds files as templates/ of "
                    "the project does",
                    folder.string()));
  }
  auto at = folder.empty() ? fs::recursive_directory_iterator() : fs::recursive_directory_iterator(folder, error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const std::string name = at->path().lexically_relative(folder).generic_string();
    if (!at->is_regular_file(error) || at->path().filename().string().starts_with('.')) continue;
    if (find_embedded(name) == nullptr) {
      throw InputError(
          fmt::format("{}: the program has no template {}, so that this file would change nothing; give it the path of "
                      "one of templates/, or take it away",
                      at->path().string(), name));
    }
    given.files.emplace(name, read_file(at->path()));
  }
  if (error) {
    throw InputError(fmt::format("{}: cannot be read ({}), and so no template there; correct its permissions",
                                 folder.string(), error.message()));
  }
  stand_ins() = std::move(given);
}

const fs::path& templates_folder() { return stand_ins().folder; }

std::string templates_digest() {
  std::string all;
  for (const auto& [name, content] : stand_ins().files) {
    all += fmt::format("{} {}\n", name, content.size());
    all += content;
  }
  return all.empty() ? "" : sha256(all);
}

}  // namespace granuscope
