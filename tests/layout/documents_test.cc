// What readers get: documents within their budgets, in sentences that one can follow, whose links lead somewhere.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "kit/temporary_folder.h"

using namespace granuscope;

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
                                   {"docs/library.md", 700},
                                   {"CHANGELOG.md", 500},
                                   {"CONTRIBUTING.md", 1400}}) {
    INFO(name);
    CHECK(words_in(text_of(name)) <= static_cast<std::size_t>(most));
  }
  CHECK(words_in(prose_of(text_of("docs/performance.md"))) <= 900);
  CHECK(words_in(text_of("templates/docs/results.md")) <= 1200);
}

TEST_CASE("Sentences of documents have at most 22 words on average") {
  for (const char* name : {"README.md", "docs/guide.md", "docs/recipes.md", "docs/nights.md", "docs/templates.md",
                           "docs/library.md", "docs/tour.md", "docs/record.md", "docs/method.md", "docs/performance.md",
                           "templates/docs/results.md", "CHANGELOG.md", "CONTRIBUTING.md"}) {
    const std::string prose = prose_of(text_of(name));
    const double mean = static_cast<double>(words_in(prose)) / static_cast<double>(sentences_in(prose));
    INFO(name << ": " << mean);
    CHECK(mean <= 22);
    CHECK(mean > 5);  // sentences were found
  }
}

TEST_CASE("Figures of documents have the shades of blue that the program gives to values of mu") {
  // As templates/palette.txt has them, black and greys beside them; of what is drawn, not of empty groups.
  const std::regex colour("'rgb\\( *([0-9]+), *([0-9]+), *([0-9]+)\\)");
  const std::set<std::string> blues{"95,180,234", "47,148,214", "0,114,178", "0,80,127", "0,42,69"};
  int figures = 0;
  for (const auto& entry : fs::directory_iterator(project / "examples/figures")) {
    const std::string svg = entry.path().extension() == ".svg" ? text_of(fs::relative(entry.path(), project)) : "";
    if (svg.find(">μ = 0.3<") == std::string::npos) continue;
    ++figures;
    std::map<std::string, int> others;
    for (auto it = std::sregex_iterator(svg.begin(), svg.end(), colour); it != std::sregex_iterator(); ++it) {
      const std::string found = (*it)[1].str() + "," + (*it)[2].str() + "," + (*it)[3].str();
      if (!blues.contains(found) && (*it)[1] != (*it)[2]) ++others[found];
    }
    INFO(entry.path());
    CHECK(others == std::map<std::string, int>{});
  }
  CHECK(figures >= 4);
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

TEST_CASE("docs/glossary.md has each word of templates/glossary.txt, in its order") {
  INFO("`make -f Makefile.docs glossary` renews it");
  const std::string page = text_of("docs/glossary.md");
  std::istringstream lines(text_of("templates/glossary.txt"));
  std::string rows;
  std::size_t words = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t text = line.find(" = ");
    if (line.starts_with("#") || text == std::string::npos) continue;
    const std::size_t word = std::min(line.find(", "), text);
    const std::string others = word == text ? "" : line.substr(word + 2, text - word - 2);
    const std::string row = "| **" + line.substr(0, word) + "** | " + others + " | " + line.substr(text + 3) + " |\n";
    CHECK(page.find(row) != std::string::npos);
    rows += row;
    ++words;
  }
  CHECK(words > 50);
  std::string shown;
  std::istringstream page_lines(page);
  for (std::string line; std::getline(page_lines, line);) {
    if (line.starts_with("| **")) shown += line + '\n';
  }
  CHECK(shown == rows);
}

TEST_CASE("The page of the library shows the program that a test builds, and headers that are installed") {
  const std::string page = text_of("docs/library.md");
  CHECK(page.find("```cpp\n" + text_of("examples/library/consumer.cc") + "```\n") != std::string::npos);
  CHECK(page.find("```cmake\n" + text_of("examples/library/CMakeLists.txt") + "```\n") != std::string::npos);
  std::string rooms = text_of("cmake/install.cmake");
  rooms = rooms.substr(rooms.find("granuscope_library_rooms ") + 24);
  rooms = rooms.substr(0, rooms.find(')')) + ' ';
  const std::string core = "../src/core/";
  std::size_t headers = 0;
  for (const std::string& link : links_in(page)) {
    if (!link.starts_with(core)) continue;
    INFO(link);
    CHECK(fs::is_regular_file(project / "docs" / link));
    CHECK(rooms.find(' ' + link.substr(core.size(), link.find('/', core.size()) - core.size()) + ' ') !=
          std::string::npos);
    ++headers;
  }
  CHECK(headers == 12);  // as the page says
}

TEST_CASE("Charts of docs/performance.md are what the tables beside them give") {
  const test::TemporaryFolder folder;
  std::vector<std::string> charts;
  for (const std::string& link : links_in(text_of("docs/performance.md"))) {
    if (!link.ends_with(".svg")) continue;
    charts.push_back(fs::path(link).stem().string());
    fs::copy_file(project / "examples/figures" / (charts.back() + ".csv"), folder / (charts.back() + ".csv"));
  }
  CHECK(charts.size() == 3);
  const std::string command = "gnuplot -d -e \"folder='" + folder.path().string() +
                              "'\" '" GRANUSCOPE_SOURCE_DIR "/cmake/performance_charts.gp'";
  REQUIRE(std::system(command.c_str()) == 0);  // NOLINT(concurrency-mt-unsafe): nothing else runs
  const auto plotted_by = [](const std::string& svg) {
    const std::size_t at = svg.find("GNUPLOT ");
    REQUIRE(at != std::string::npos);
    return svg.substr(at, svg.find('\n', at) - at);
  };
  for (const std::string& chart : charts) {
    std::ifstream file(folder / (chart + ".svg"));
    const std::string plotted{std::istreambuf_iterator<char>(file), {}},
        kept = text_of("examples/figures/" + chart + ".svg");
    INFO(chart << ": `make -f Makefile.docs charts` renews it");
    if (plotted_by(plotted) == plotted_by(kept))
      CHECK(plotted == kept);
    else
      WARN(chart << " was plotted by another gnuplot, and not compared");
  }
}

TEST_CASE("Pages that commands make say what their templates say") {
  INFO("`make -f Makefile.docs performance` and `results` renew them");
  CHECK(text_of("docs/results.md").starts_with(text_of("templates/docs/results.md")));
  const std::string page = text_of("docs/performance.md");
  std::istringstream lines(text_of("templates/docs/performance.md"));
  std::size_t at = 0, places = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("@@")) {  // a table or a sentence of numbers
      ++places;
      continue;
    }
    INFO(line);
    const std::size_t found = page.find(line + '\n', at);
    CHECK(found != std::string::npos);
    if (found != std::string::npos) at = found + line.size();
  }
  CHECK(places > 10);
  CHECK(page.find("@@") == std::string::npos);
}
