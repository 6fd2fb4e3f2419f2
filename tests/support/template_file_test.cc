#include "support/template_file.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>

namespace granuscope {
namespace {

std::map<std::string, std::string> files_on_disk() {
  const std::filesystem::path folder = std::filesystem::path(GRANUSCOPE_SOURCE_DIR) / "templates";
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string file_name = entry.path().filename().string();
    if (!entry.is_regular_file() || file_name.front() == '.') continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files[std::filesystem::relative(entry.path(), folder).generic_string()] =
        std::string(std::istreambuf_iterator<char>(stream), {});
  }
  return files;
}

TEST_CASE("every file of templates/ is built into the program, byte for byte") {
  const auto expected = files_on_disk();
  REQUIRE(expected.contains("palette.txt"));
  CHECK(embedded_files().size() == expected.size());
  for (const auto& [name, content] : expected) {
    INFO(name);
    CHECK((template_file(name) == content));
  }
}

TEST_CASE("embedded files are sorted by name, as the lookup needs") {
  const auto files = embedded_files();
  CHECK(std::is_sorted(files.begin(), files.end(),
                       [](const EmbeddedFile& a, const EmbeddedFile& b) { return a.name < b.name; }));
}

TEST_CASE("a template that does not exist is a mistake of the program") {
  CHECK_THROWS_AS(template_file("no-such-template"), std::logic_error);
  CHECK_THROWS_WITH(template_file("no-such-template"), Catch::Contains("templates/no-such-template"));
  CHECK_THROWS_AS(template_file(""), std::logic_error);
}

}  // namespace
}  // namespace granuscope
