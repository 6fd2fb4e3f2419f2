#include "support/templates.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "kit/temporary_folder.h"
#include "support/error.h"

using namespace granuscope;

namespace {

/// Texts, and lists of further scopes, by name; escaping writes <text>.
struct Words : TemplateScope {
  using Texts = std::map<std::string, std::string>;
  Texts texts;
  std::map<std::string, std::vector<Words>> lists = {};
  mutable std::vector<std::string> passed_over = {};

  explicit Words(Texts the_texts, std::map<std::string, std::vector<Words>> the_lists = {})
      : texts(std::move(the_texts)), lists(std::move(the_lists)) {}

  std::string raw_text(const std::string& name) const override {
    if (!texts.contains(name)) throw std::logic_error("no text for " + name);
    return texts.at(name);
  }
  std::string text(const std::string& name) const override { return "<" + raw_text(name) + ">"; }
  void enter(const std::string& name, Missing missing, const Write& write) const override {
    if (lists.contains(name)) {
      for (const Words& words : lists.at(name)) write(words);
    } else if (texts.contains(name)) {
      if (!texts.at(name).empty()) write(*this);
    } else if (missing == Missing::is_an_error) {
      throw std::logic_error("no section " + name);
    }
  }
  void pass_over(const std::string& name) const override { passed_over.push_back(name); }
};

}  // namespace

TEST_CASE("Names are filled in, escaped or as they stand") {
  const Words words(Words::Texts{{"x", "a"}});
  CHECK(fill_template("1 {{x}} {{{x}}} {{ x }} {'{{x}}'} 2", words) == "1 <a> a <a> {'<a>'} 2");
  CHECK(fill_template("{{! nobody sees this {{x}}", words).empty());
  CHECK(fill_template("", words).empty());
}

TEST_CASE("Sections stay, go, repeat and nest") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}},
                    {{"rows", {Words(Words::Texts{{"n", "1"}}), Words(Words::Texts{{"n", "2"}})}}, {"none", {}}});
  CHECK(fill_template("{{#x}}yes {{x}}{{/x}}{{^x}}no{{/x}}", words) == "yes <1>");
  CHECK(fill_template("{{#y}}yes{{/y}}{{^y}}no{{/y}}", words) == "no");
  CHECK(fill_template("{{#x}}{{#y}}both{{/y}}{{^y}}x{{/y}}{{/x}}", words) == "x");
  CHECK(fill_template("{{^y}}{{#x}}x{{/x}}{{/y}}{{^x}}{{#x}}hidden{{/x}}{{/x}}", words) == "x");
  CHECK(fill_template("{{#rows}}{{n}},{{/rows}}{{^rows}}none{{/rows}}", words) == "<1>,<2>,");
  CHECK(fill_template("{{#none}}x{{/none}}{{^none}}none{{/none}}", words) == "none");
}

TEST_CASE("A tag that writes nothing itself, alone on a line, leaves no empty line") {
  CHECK(fill_template("a\n{{#x}}\nb\n{{/x}}\nc\n", Words(Words::Texts{{"x", "1"}})) == "a\nb\nc\n");
  CHECK(fill_template("a\n{{#x}}\nb\n{{/x}}\nc\n", Words(Words::Texts{{"x", ""}})) == "a\nc\n");
  CHECK(fill_template("a\n{{! b }}\nc {{! d }}\n", Words(Words::Texts{})) == "a\nc \n");
  CHECK(fill_template("{{x}}\n{{x}}\n", Words(Words::Texts{{"x", "1"}})) == "<1>\n<1>\n");
}

TEST_CASE("What is filled in is not read as a template again") {
  CHECK(fill_template("{{{x}}}", Words(Words::Texts{{"x", "{{y}} {{#z}} {{/x}}"}})) == "{{y}} {{#z}} {{/x}}");
}

TEST_CASE("A part is another file, filled in at the same place") {
  const Words words(Words::Texts{{"width", "7"}, {"height", "5"}, {"stem", "s"}});
  CHECK_THROWS_AS(fill_template("{{> no/such/file}}", words), std::logic_error);
  CHECK(fill_template("{{> palette.txt}}", words) == fill_template_file("palette.txt", words));
}

TEST_CASE("Every name must be known, unless a section says that it may be missing") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}});
  CHECK_THROWS_AS(fill_template("{{z}}", words), std::logic_error);
  CHECK_THROWS_AS(fill_template("{{#z}}a{{/z}}", words), std::logic_error);
  CHECK_THROWS_AS(fill_template("{{^z}}a{{/z}}", words), std::logic_error);
  CHECK(fill_template("{{#z?}}a{{/z}}{{^z?}}b{{/z}}{{#x?}}c{{/x}}", words) == "bc");
  fill_template("{{#y}}{{p}}{{#q}}{{{r}}}{{/q}}{{/y}}{{^x}}{{s}}{{/x}}", words);
  CHECK(words.passed_over == std::vector<std::string>{"p", "q", "r", "s"});
}

TEST_CASE("Tags that do not match are named") {
  const Words words(Words::Texts{{"x", "1"}, {"y", ""}});
  for (const char* wrong : {"{{#x}}", "{{/x}}", "{{#x}}{{/y}}", "{{#y}}{{#x}}{{/y}}{{/x}}", "{{x", "{{{x}}",
                            "{{#x}}{{x", "{{#y}}{{#x}}{{/y}}"}) {
    INFO(wrong);
    CHECK_THROWS_AS(fill_template(wrong, words), std::logic_error);
  }
  CHECK_THROWS_WITH(fill_template("{{#x}}", words), Catch::Contains("section x is not closed"));
}

TEST_CASE("sections that nest without end are an error") {
  std::string text;
  for (int k = 0; k < 100'000; ++k) text += "{{#a}}";
  CHECK_THROWS_AS(fill_template(text, Words(Words::Texts{{"a", "x"}})), std::logic_error);
}

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
