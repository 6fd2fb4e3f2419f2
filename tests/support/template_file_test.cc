#include "support/templates.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>

#include "kit/temporary_folder.h"
#include "support/error.h"

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
  const std::filesystem::path examples = std::filesystem::path(GRANUSCOPE_SOURCE_DIR) / "examples";
  for (const auto& entry : std::filesystem::directory_iterator(examples)) {
    if (entry.path().extension() != ".toml") continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    files["examples/" + entry.path().filename().string()] = std::string(std::istreambuf_iterator<char>(stream), {});
  }
  return files;
}

TEST_CASE("every file of templates/ and every experiment of examples/ is built into the program, byte for byte") {
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

TEST_CASE("a file of another folder stands in for the built-in one, until it is taken back") {
  const test::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "plot");
  std::ofstream(folder / "palette.txt") << "other colours";
  std::ofstream(folder / "plot/bead_forces.captions") << "other words";
  const std::string built_in(template_file("palette.txt"));
  CHECK(templates_digest().empty());
  use_templates(folder.path());
  CHECK(template_file("palette.txt") == "other colours");
  CHECK(template_file("plot/bead_forces.captions") == "other words");
  CHECK(template_file("screen.css") == files_on_disk().at("screen.css"));
  const std::string digest = templates_digest();
  CHECK(digest.size() == 64);
  std::ofstream(folder / "palette.txt") << "third colours";
  CHECK(template_file("palette.txt") == "other colours");  // read once
  use_templates(folder.path());
  CHECK(templates_digest() != digest);
  use_templates({});
  CHECK((template_file("palette.txt") == built_in));
  CHECK(templates_folder().empty());
}

TEST_CASE("a folder of templates that would change nothing is refused") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(use_templates(folder / "nowhere"), InputError);
  std::ofstream(folder / "pallete.txt") << "mistyped";
  CHECK_THROWS_WITH(use_templates(folder.path()), Catch::Contains("the program has no template pallete.txt"));
  CHECK(templates_folder().empty());
}

}  // namespace
}  // namespace granuscope
