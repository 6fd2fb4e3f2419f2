// docs/recipes.md: every block of commands runs, in its order, on the installed program, with fewer piles.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "kit/temporary_folder.h"

using namespace granuscope;
namespace fs = std::filesystem;

namespace {

struct Block {
  std::string needs;  ///< of its first line: "latex", or nothing
  std::string commands;
};

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::vector<Block> blocks_of(const std::string& page) {
  std::vector<Block> blocks;
  std::istringstream lines(page);
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```sh")) {
      const std::string mark = "```sh needs ";
      blocks.push_back({line.starts_with(mark) ? line.substr(mark.size()) : "", ""});
      inside = true;
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      blocks.back().commands += line + '\n';
    }
  }
  return blocks;
}

/// The first two numbers of each row below the names and units.
std::vector<std::pair<double, double>> first_columns(const fs::path& csv) {
  std::vector<std::pair<double, double>> rows;
  std::ifstream lines(csv);
  std::string line;
  for (int row = 0; std::getline(lines, line); ++row) {
    char comma = 0;
    double x = 0, y = 0;
    if (row >= 2 && std::istringstream(line) >> x >> comma >> y) rows.emplace_back(x, y);
  }
  return rows;
}

int status_of(const std::string& command) {
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): nothing else runs
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Whether what a block needs is here; Slurm and ffmpeg are looked at, but stand-ins take their places.
bool is_there(const std::string& need) {
  if (need == "matplotlib" || need == "h5py" || need == "networkx" || need == "vtkmodules") {
    return status_of("/usr/bin/python3 -c 'import numpy, " + need + "' 2>/dev/null") == 0;
  }
  return need != "latex" || status_of("command -v latex >/dev/null") == 0;
}

void write_program(const fs::path& file, const std::string& text) {
  std::ofstream(file) << "#!/bin/sh\n" << text;
  fs::permissions(file, fs::perms::owner_all);
}

}  // namespace

TEST_CASE("What the blocks of a recipe need stands in its first line") {
  const std::string page = text_of(GRANUSCOPE_SOURCE_DIR "/docs/recipes.md"), mark = "```sh needs ";
  const std::map<std::string, std::string> names = {
      {"sbatch", "Slurm"}, {"library", "libgranuscope-dev"}, {"vtkmodules", "vtk9"}};
  for (std::size_t at = page.find(mark); at != std::string::npos; at = page.find(mark, at + 1)) {
    const std::string need = page.substr(at + mark.size(), page.find('\n', at) - at - mark.size());
    if (need == "examples") continue;  // which are granuscope's own
    const std::size_t heading = page.rfind("\n## ", at), line = page.find("\n\n", heading) + 2;
    const std::string first = page.substr(line, page.find('\n', line) - line);
    CAPTURE(need, first);
    CHECK(first.starts_with("Needs "));
    CHECK(first.find(names.contains(need) ? names.at(need) : need) != std::string::npos);
  }
}

TEST_CASE("Every block of the recipes runs, and leaves what they say", "[long]") {
  const std::string page = text_of(GRANUSCOPE_SOURCE_DIR "/docs/recipes.md");
  const std::vector<Block> blocks = blocks_of(page);
  REQUIRE(blocks.size() > 12);
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string(), prefix = at + "/prefix";
  REQUIRE(status_of("cmake --install '" GRANUSCOPE_BINARY_DIR "' --prefix '" + prefix + "' >/dev/null") == 0);
  fs::create_directories(folder / "stand-ins");
  fs::create_directories(folder / "here");
  // Fewer piles, no studies, no typesetting; all else as it stands.
  write_program(
      folder / "stand-ins/granuscope",
      "if [ \"$1 $2\" = 'example quick' ]; then\n" + prefix +
          "/bin/granuscope example quick | sed -e 's/^samples = .*/samples = 256/' -e '/^.studies/,/^$/d' -e "
          "'/^.gate/,$d' -e "
          "'s/^mu = .0.0.*/mu = [0.0, 0.1, 0.2, 0.3]/'\n  printf '\\n[report]\\npdf = false\\n'\nelse\n  exec " +
          prefix + "/bin/granuscope \"$@\"\nfi\n");
  write_program(folder / "stand-ins/ffmpeg", "test -f frames/frame-00000.png && touch film.mp4\n");
  // A job is a line of arguments; the array has its first task only.
  write_program(folder / "stand-ins/sbatch",
                "test \"$#\" -ge 3 && for file in \"$@\"; do case $file in *.sbatch) sh -n \"$file\" || exit 1;; esac; "
                "done\necho 7\n");
  for (const Block& block : blocks) {
    if (!is_there(block.needs)) {
      WARN("no " << block.needs << " here: its block was not run");
      continue;
    }
    std::string commands = block.commands;
    for (std::size_t from = 0; (from = commands.find("/usr/share/", from)) != std::string::npos;) {
      commands.replace(from, 4, prefix);
    }
    std::ofstream(folder / "block.sh") << commands;
    const int status = status_of("cd '" + at + "/here' && env -u CI PATH='" + at + "/stand-ins:/usr/bin:/bin' HOME='" +
                                 at + "' CMAKE_PREFIX_PATH='" + prefix + "' sh -e ../block.sh >../said 2>&1");
    INFO(block.commands << text_of(folder / "said"));
    REQUIRE(status == 0);
    if (block.commands.find("numbers out/quick --only") != std::string::npos) {
      CHECK(text_of(folder / "said").starts_with("name,value,standard_error,text\nmu-0.3/c,0.5"));
    }
  }
  for (const char* file : {"out/quick/report.html",
                           "chains.png",
                           "diffusion.pdf",
                           "diffusion.png",
                           "numbers.tex",
                           "nights/index.html",
                           ".gitlab-ci.yml",
                           "out/shards/report.html",
                           "frames/frame-00050.png",
                           "film.mp4",
                           "middle.svg",
                           "pile.vtu",
                           "beads.dump",
                           "response.vti",
                           "contacts.svg",
                           "floor.png",
                           "forces.csv",
                           "steps/frame-00001.png",
                           "run.zip",
                           "article/metadata.yaml"}) {
    INFO(file);
    CHECK(fs::is_regular_file(folder / "here" / file));
  }
  if (is_there("latex")) CHECK(fs::is_regular_file(folder / "here/paper.dvi"));
  if (is_there("latex")) CHECK(fs::is_regular_file(folder / "here/article/article.pdf"));
  if (is_there("vtkmodules")) CHECK(fs::is_regular_file(folder / "here/tubes.vtp"));
  if (is_there("h5py")) {  // the profile that others' tools make of an ensemble is the one of the figure
    const auto theirs = first_columns(folder / "here/profile.csv");
    const auto ours = first_columns(folder / "here/out/quick/figures/response-profiles-layer-110.csv");
    REQUIRE(ours.size() == 250);
    REQUIRE(theirs.size() == ours.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
      CHECK(theirs[i].first == ours[i].first);
      CHECK(theirs[i].second == Approx(ours[i].second).epsilon(1e-5).margin(1e-9));
    }
  }
  if (is_there("matplotlib")) CHECK(fs::file_size(folder / "here/response.png") > 10'000);
}
