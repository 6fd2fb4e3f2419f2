// The order of the rooms and the doors of heavy headers, read from the #include lines themselves.
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path source_folder = GRANUSCOPE_SOURCE_DIR;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<fs::path> sources_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const auto extension = entry.path().extension();
    if (entry.is_regular_file() && (extension == ".cc" || extension == ".h")) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// What the #include lines of a text name. (<regex> does not compile under the sanitizers with warnings as errors.)
std::vector<std::string> includes_of(const std::string& text) {
  std::vector<std::string> names;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::string dense;
    for (const char c : line) {
      if (c != ' ' && c != '\t') dense += c;
    }
    if (dense.rfind("#include", 0) != 0 || dense.size() < 10) continue;
    names.push_back(dense.substr(9, dense.find_first_of(">\"", 9) - 9));
  }
  return names;
}

/// The rooms each room may include, itself apart.
const std::map<std::string, std::set<std::string>>& rooms_below() {
  static const std::map<std::string, std::set<std::string>> below = [] {
    std::map<std::string, std::set<std::string>> rooms;
    rooms["support"] = {};
    rooms["model"] = {"support"};
    rooms["storage"] = {"support", "model"};
    rooms["sampling"] = {"support", "model"};
    rooms["ensemble"] = {"support", "model", "storage", "sampling"};
    rooms["analysis"] = {"support", "model", "storage", "sampling", "ensemble"};
    rooms["render"] = {"support", "model", "storage"};
    rooms["plot"] = {"support", "model", "storage", "sampling", "ensemble", "analysis", "render"};
    std::string previous = "plot";
    for (const std::string room :
         {"export", "packing", "report", "studies", "experiment", "pipeline", "history", "bench", "cli", "mpi"}) {
      rooms[room] = rooms[previous];
      rooms[room].insert(previous);
      previous = room;
    }
    return rooms;
  }();
  return below;
}

const std::set<std::string> rings{"core", "pages", "services"};

/// src/core/model/pile.h lies in the room model of the ring core.
std::string room_of(const fs::path& file, const fs::path& root) {
  const fs::path path = fs::relative(file, root);
  return (rings.contains(path.begin()->string()) ? std::next(path.begin()) : path.begin())->string();
}

/// Violations of the rooms' order in `includes` of a file of `room`.
std::vector<std::string> higher_includes(const std::string& room, const std::vector<std::string>& includes) {
  std::vector<std::string> found;
  for (const std::string& name : includes) {
    const std::string included = name.substr(0, name.find('/'));
    if (included == room || name.find('/') == std::string::npos || rooms_below().count(included) == 0) continue;
    if (rooms_below().at(room).count(included) == 0) found.push_back(name);
  }
  return found;
}

struct Door {
  std::string header;  // beginning of the include
  std::set<std::string> rooms;
};

const std::vector<Door> doors{
    {"CLI/", {"cli"}},
    {"toml++/", {"experiment"}},
    {"nlohmann/", {"plot", "report", "studies", "history", "bench"}},
    {"Eigen/", {"analysis"}},
    {"glpk", {"sampling"}},
    {"eigen3/", {"analysis"}},
    {"gsl/gsl_fft", {"ensemble"}},
    {"gsl/gsl_multifit", {"analysis"}},
    {"gsl/gsl_errno", {"analysis"}},
    {"hdf5", {"storage"}},
    {"mpi.h", {"mpi"}},
    {"sqlite3.h", {"history"}},
    {"zip.h", {"report"}},
    {"yaml-cpp/", {"report"}},
    {"GL/", {"render"}},
    {"EGL/", {"render"}},
    {"png.h", {"render"}},
    {"ft2build.h", {"render"}},
    {"freetype", {"render"}},
    {"hwy/", {"sampling", "ensemble"}},
    {"Random123/", {"sampling"}},
};

}  // namespace

TEST_CASE("Every room of src is known to the order") {
  for (const fs::path& file : sources_in(source_folder / "src")) {
    INFO(file);
    CHECK((file.filename() == "main.cc" || rooms_below().count(room_of(file, source_folder / "src")) == 1));
  }
}

TEST_CASE("No room includes a higher one") {
  const fs::path root = source_folder / "src";
  std::size_t files = 0;
  for (const fs::path& file : sources_in(root)) {
    if (file.parent_path() == root) continue;  // main.cc stands above all rooms
    ++files;
    INFO(file);
    CHECK(higher_includes(room_of(file, root), includes_of(text_of(file))) == std::vector<std::string>{});
  }
  CHECK(files > 20);  // an empty walk proves nothing
}

TEST_CASE("The order test sees a violation") {
  CHECK(higher_includes("model", includes_of("#include <vector>\n#include \"sampling/sampler.h\"\n")) ==
        std::vector<std::string>{"sampling/sampler.h"});
  CHECK(higher_includes("render", includes_of("  #  include \"sampling/sampler.h\"\n#include \"model/pile.h\"\n")) ==
        std::vector<std::string>{"sampling/sampler.h"});
  CHECK(higher_includes("cli", includes_of("#include \"report/report.h\"\n")).empty());
}

TEST_CASE("main.cc only calls the command line") {
  const fs::path main = source_folder / "src" / "main.cc";
  for (const std::string& name : includes_of(text_of(main))) {
    INFO(name);
    CHECK((name.find('/') == std::string::npos || name.rfind("cli/", 0) == 0));
  }
}

TEST_CASE("Heavy headers have one door each") {
  const fs::path root = source_folder / "src";
  for (const fs::path& file : sources_in(root)) {
    for (const std::string& name : includes_of(text_of(file))) {
      for (const Door& door : doors) {
        if (name.rfind(door.header, 0) != 0) continue;
        INFO(file << " includes " << name);
        CHECK(door.rooms.count(room_of(file, root)) == 1);
      }
    }
  }
}

TEST_CASE("An installed header includes only what is installed beside it") {
  const fs::path core = source_folder / "src" / "core";
  const std::string rule = text_of(source_folder / "cmake" / "install.cmake");
  std::size_t names = 0;
  for (const fs::path& file : sources_in(core)) {
    if (file.extension() != ".h" || file.filename().string().ends_with("-inl.h")) continue;
    for (const std::string& name : includes_of(text_of(file))) {
      if (rooms_below().count(name.substr(0, name.find('/'))) == 0) continue;  // of a library
      ++names;
      INFO(file << " includes " << name);
      CHECK(fs::is_regular_file(core / name));
      CHECK(rule.find("PATTERN \"*" + fs::path(name).extension().string() + "\"") != std::string::npos);
      CHECK(!name.ends_with("-inl.h"));
    }
  }
  CHECK(names > 40);
}

TEST_CASE("Headers guard themselves and lie in one subject of readable size") {
  for (const fs::path& folder : {source_folder / "src", source_folder / "tests"}) {
    for (const fs::path& file : sources_in(folder)) {
      const std::string text = text_of(file);
      INFO(file);
      // Vector files of Highway are included once for each instruction set.
      const bool vectors = file.filename().string().ends_with("-inl.h");
      if (file.extension() == ".h") {
        CHECK(text.find(vectors ? "HWY_TARGET_TOGGLE" : "#pragma once") != std::string::npos);
      }
      CHECK(std::count(text.begin(), text.end(), '\n') <= 700);
    }
  }
}

namespace {

/// Files of src whose text holds the word, not as part of a longer one.
std::vector<std::string> files_that_name(const std::string& word) {
  const auto in_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  std::vector<std::string> files;
  for (const fs::path& file : sources_in(source_folder / "src")) {
    const std::string text = text_of(file);
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      const std::size_t end = at + word.size();
      if ((at > 0 && in_word(text[at - 1])) || (end < text.size() && in_word(text[end]))) continue;
      files.push_back(fs::relative(file, source_folder).string());
      break;
    }
  }
  return files;
}

/// What follows `before` up to `after`, wherever that stands in the text.
std::vector<std::string> between(const std::string& text, const std::string& before, const std::string& after) {
  std::vector<std::string> found;
  for (std::size_t at = text.find(before); at != std::string::npos; at = text.find(before, at + 1)) {
    const std::size_t from = at + before.size();
    found.push_back(text.substr(from, text.find(after, from) - from));
  }
  return found;
}

}  // namespace

TEST_CASE("A study lies in one place: few files of src name it") {
  std::vector<std::string> ids;
  for (const fs::path& file : sources_in(source_folder / "src/studies")) {
    for (std::string& id : between(text_of(file), "std::string id() const override { return \"", "\"")) {
      ids.push_back(std::move(id));
    }
  }
  CHECK(ids.size() >= 9);
  for (const std::string& id : ids) {
    std::vector<std::string> naming;
    for (const fs::path& file : sources_in(source_folder / "src")) {
      std::string text = text_of(file);
      std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
      if (text.find(id) == std::string::npos) continue;
      std::string name = fs::relative(file, source_folder).string();
      // A folder of its own is one place.
      if (const std::string folder = "src/studies/" + id; name.starts_with(folder + "/")) name = folder;
      if (std::find(naming.begin(), naming.end(), name) == naming.end()) naming.push_back(name);
    }
    INFO(fmt::format("{}: {}", id, fmt::join(naming, ", ")));
    CHECK(naming.size() <= 3);
    CHECK(naming.size() >= 2);
  }
}

TEST_CASE("A parameter is carried whole: few files name one field of it") {
  const std::vector<std::string> files = files_that_name("sign_run");
  INFO(fmt::format("{}", fmt::join(files, "\n")));
  CHECK(files.size() <= 5);
  CHECK(files.size() >= 3);  // declared, checked and used: else nothing was searched
}

TEST_CASE("Each room has a page of its own that begins with its name") {
  std::set<fs::path> rooms;
  for (const fs::path& file : sources_in(source_folder / "src")) {
    const fs::path room = file.parent_path();
    if (room.parent_path().filename() != "studies" && room != source_folder / "src") rooms.insert(room);
  }
  CHECK(rooms.size() > 15);
  for (const fs::path& room : rooms) {
    INFO(room);
    REQUIRE(fs::exists(room / "README.md"));
    CHECK(text_of(room / "README.md").starts_with("# " + room.filename().string() + ": "));
  }
}

TEST_CASE("Nothing depends on where the project lies or on the machine that builds it") {
  // Spelt in two parts, so that this file does not find itself.
  const std::vector<std::string> forbidden{std::string("/ho") + "me/", std::string("/wo") + "rk/",
                                           std::string("-march=na") + "tive", std::string("/Us") + "ers/"};
  std::vector<fs::path> files;
  for (const char* folder : {"src", "tests", "templates", "examples", "cmake", "docs"}) {
    if (!fs::exists(source_folder / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(source_folder / folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  for (const char* file : {"CMakeLists.txt", "CMakePresets.json", "reproduce", "check", "README.md", "Makefile.docs",
                           "packages.txt", "CITATION.cff", "CONTRIBUTING.md", "CHANGELOG.md"}) {
    REQUIRE(fs::exists(source_folder / file));
    files.push_back(source_folder / file);
  }
  for (const fs::path& file : files) {
    const std::string text = text_of(file);
    for (const std::string& word : forbidden) {
      INFO(file << " holds " << word);
      CHECK(text.find(word) == std::string::npos);
    }
  }
}

// Rooms are compiled in large pieces, too, whose cut moves with every line. So a name at the outer level of a .cc file
// means one type in its room, and is no type of a header.

namespace {

struct TypeName {
  std::string name;
  std::string alias;  ///< what a `using` says it is: the same twice is no clash
  fs::path file;
};

/// Types that begin at the left margin.
void add_types(const fs::path& file, std::vector<TypeName>& types) {
  std::istringstream lines(text_of(file));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, name;
    words >> kind >> name;
    if (kind == "enum" && name == "class") words >> name;
    if (line.empty() || line[0] == ' ' || line.back() == ';') {
      if (!line.starts_with("using ") || name == "namespace") continue;
      types.push_back({name, line, file});
    } else if (kind == "struct" || kind == "class" || kind == "enum") {
      types.push_back({name, "", file});
    }
  }
}

}  // namespace

TEST_CASE("A type of a source file has a name of its own in its room, and among headers") {
  // Compiled by themselves, once for each set of instructions.
  const auto by_itself = [](const fs::path& file) {
    const std::string text = text_of(file);
    return text.find("foreach_target") != std::string::npos || text.find("hwy/") != std::string::npos;
  };
  std::map<std::string, std::vector<TypeName>> of_room;
  std::vector<TypeName> of_headers;
  for (const fs::path& file : sources_in(source_folder / "src")) {
    if (by_itself(file)) continue;
    if (file.extension() == ".h") {
      add_types(file, of_headers);
    } else {
      add_types(file, of_room[room_of(file, source_folder / "src")]);
    }
  }
  std::size_t looked_at = 0;
  for (const auto& [room, types] : of_room) {
    for (const TypeName& one : types) {
      ++looked_at;
      for (const TypeName& other : types) {
        if (one.file >= other.file || one.name != other.name || (!one.alias.empty() && one.alias == other.alias))
          continue;
        FAIL_CHECK(one.name << " is a type in " << one.file << " and another one in " << other.file);
      }
      for (const TypeName& other : of_headers) {
        const bool clash = one.name == other.name && (one.alias.empty() || one.alias != other.alias);
        if (clash) FAIL_CHECK(one.name << " is a type in " << one.file << " and another one in " << other.file);
      }
    }
  }
  CHECK(looked_at > 200);
}
