// What readers get: documents within their budgets, in sentences that one can follow, whose links lead somewhere.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path project = GRANUSCOPE_SOURCE_DIR;

std::string text_of(const std::string& name) {
  std::ifstream file(project / name);
  REQUIRE(file);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The text without code and tables: lines in fences, lines that begin with four blanks or with a bar.
std::string prose_of(const std::string& text) {
  std::string prose;
  std::istringstream lines(text);
  bool fenced = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    if (!fenced && !line.starts_with("```") && !line.starts_with("    ") && !line.starts_with("|"))
      prose += line + '\n';
  }
  return prose;
}

std::size_t words_in(const std::string& text) {
  std::istringstream words(text);
  std::size_t count = 0;
  for (std::string word; words >> word;) ++count;
  return count;
}

/// Sentences end with a point, colon or question mark behind a word and before a blank, or with a paragraph.
std::size_t sentences_in(const std::string& prose) {
  std::size_t count = 0;
  bool open = false;
  for (std::size_t k = 0; k < prose.size(); ++k) {
    const char c = prose[k];
    const char next = k + 1 < prose.size() ? prose[k + 1] : '\n';
    const bool ends = (c == '.' || c == '?' || c == ':') && (next == ' ' || next == '\n' || next == '*');
    const bool paragraph = c == '\n' && (next == '\n' || next == '-' || next == '#');
    if ((ends || paragraph) && open) ++count, open = false;
    if (c != ' ' && c != '\n' && !ends) open = true;
  }
  return count + (open ? 1 : 0);
}

std::vector<std::string> links_in(const std::string& text) {
  std::vector<std::string> links;
  for (std::size_t at = 0; (at = text.find("](", at)) != std::string::npos; ++at) {
    links.push_back(text.substr(at + 2, text.find(')', at) - at - 2));
  }
  return links;
}

/// As GitHub makes it of a heading.
std::string anchor_of(std::string_view heading) {
  std::string anchor;
  for (const char c : heading) {
    if (c >= 'A' && c <= 'Z') anchor += static_cast<char>(c - 'A' + 'a');
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_') anchor += c;
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

std::vector<std::string> documents() {
  std::vector<std::string> names{"README.md", "CONTRIBUTING.md", "CHANGELOG.md"};
  for (const auto& entry : fs::directory_iterator(project / "docs")) {
    if (entry.path().extension() == ".md") names.push_back("docs/" + entry.path().filename().string());
  }
  return names;
}

}  // namespace

TEST_CASE("Documents keep to their budgets of words") {
  // Of the last two the tables are made by the program, and not counted.
  for (const auto& [name, most] : {std::pair{"README.md", 600},
                                   {"docs/guide.md", 1800},
                                   {"docs/nights.md", 500},
                                   {"docs/templates.md", 450},
                                   {"CHANGELOG.md", 500},
                                   {"CONTRIBUTING.md", 1600}}) {
    INFO(name);
    CHECK(words_in(text_of(name)) <= static_cast<std::size_t>(most));
  }
  CHECK(words_in(prose_of(text_of("docs/performance.md"))) <= 900);
  CHECK(words_in(text_of("templates/docs/results.md")) <= 1200);
}

TEST_CASE("Sentences of documents have at most 22 words on average") {
  for (const char* name : {"README.md", "docs/guide.md", "docs/recipes.md", "docs/nights.md", "docs/templates.md",
                           "docs/performance.md", "templates/docs/results.md", "CHANGELOG.md", "CONTRIBUTING.md"}) {
    const std::string prose = prose_of(text_of(name));
    const double mean = static_cast<double>(words_in(prose)) / static_cast<double>(sentences_in(prose));
    INFO(name << ": " << mean);
    CHECK(mean <= 22);
    CHECK(mean > 5);  // sentences were found
  }
}

TEST_CASE("Links of documents lead to files and headings that are there") {
  std::size_t followed = 0;
  for (const std::string& name : documents()) {
    for (const std::string& link : links_in(text_of(name))) {
      INFO(name << ": " << link);
      if (link.starts_with("http") || link.find(' ') != std::string::npos) continue;
      const std::string file = link.substr(0, link.find('#'));
      const fs::path target = file.empty() ? project / name : (project / name).parent_path() / file;
      CHECK(fs::exists(target));
      ++followed;
      if (link.find('#') == std::string::npos) continue;
      bool there = false;
      std::istringstream lines(text_of(fs::relative(target, project).string()));
      for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("#") && anchor_of(line.substr(line.find(' ') + 1)) == link.substr(link.find('#') + 1)) {
          there = true;
        }
      }
      CHECK(there);
    }
  }
  CHECK(followed > 20);
}
