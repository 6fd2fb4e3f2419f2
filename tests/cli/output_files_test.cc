// No verb writes over a file that it reads, nor over one that this program has not written, unless --force is given.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/in_process.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// A finished run and a pile in a folder.
void make_run_and_pile(const test::TemporaryFolder& folder) {
  write_file(folder / "small.toml", smallest_experiment_text + "[report]\npdf = false\n");
  REQUIRE(
      granuscope_command({"run", (folder / "small.toml").string(), "-q", "--out", (folder / "run").string()}).code ==
      0);
  REQUIRE(granuscope_command(
              {"sample", "--mu", "0.3", "--columns", "20", "--layers", "10", "--out", (folder / "pile.h5").string()})
              .code == 0);
}

}  // namespace

TEST_CASE("no verb writes over what it has not written") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string(), pile = (folder / "pile.h5").string();
  struct Writer {
    std::vector<std::string> arguments;
    std::string flag, name;
  };
  std::vector<Writer> writers = {{{"numbers", run, "--format", "tex"}, "--out", "n.tex"},
                                 {{"numbers", run, "--format", "csv"}, "--out", "n.csv"},
                                 {{"numbers", run, "--format", "json"}, "--out", "n.json"},
                                 {{"compare", run, run}, "--json", "c.json"},
                                 {{"pack", run}, "--out", "r.zip"},
                                 {{"render", pile}, "--image", "p.png"},
                                 {{"render", pile}, "--image", "p.svg"},
                                 {{"sample", "--mu", "0.3", "--columns", "20", "--layers", "10"}, "--out", "s.h5"}};
  for (const char* format : {"pdf", "svg", "eps", "png", "tikz"}) {
    writers.push_back(
        {{"figure", run, "transport-with-depth", "--format", format}, "--out", std::string("f.") + format});
  }
  for (Writer& one : writers) {
    INFO(one.name);
    const fs::path file = folder / one.name;
    one.arguments.insert(one.arguments.end(), {one.flag, file.string()});
    const std::string mine = "my own words about granuscope figure and run\n";
    write_file(file, mine);
    const CommandResult refused = granuscope_command(one.arguments);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains(one.name) && Contains("granuscope has not written it") && Contains("--force"));
    CHECK(read_file(file) == mine);
    // A file of the same kind by another program is no file of ours.
    const std::string other = one.name.ends_with("pdf")    ? "%PDF-1.5\n% by somebody else\n%%EOF\n"
                              : one.name.ends_with("png")  ? "\x89PNG\r\n\x1a\nby somebody else"
                              : one.name.ends_with("eps")  ? "%!PS-Adobe-3.0 EPSF-3.0\n%%Creator: cairo 1.16.0\n"
                              : one.name.ends_with("json") ? "{\n  \"name\": \"my web application\"\n}\n"
                                                           : "<?xml version=\"1.0\"?><svg>mine</svg>";
    write_file(file, other);
    CHECK(granuscope_command(one.arguments).code == 2);
    CHECK(read_file(file) == other);

    std::vector<std::string> forced = one.arguments;
    forced.emplace_back("--force");
    CHECK(granuscope_command(forced).code == 0);
    CHECK(read_file(file) != other);
    CHECK(granuscope_command(one.arguments).code == 0);  // its own
  }
}

TEST_CASE("no verb writes over what it reads, --force or not") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string();
  const auto file = GENERATE(as<std::string>(), "summary.json", "experiment.toml", "figures/transport-with-depth.svg");
  const std::string target = (folder / "run" / file).string(), before = read_file(target);
  for (std::vector<std::string> arguments : std::vector<std::vector<std::string>>{
           {"numbers", run, "--format", "json", "--out", target, "--force"},
           {"compare", run, run, "--json", target},
           {"compare", target, run, "--json", target},
           {"pack", run, "--out", target, "--force"},
           {"figure", run, "transport-with-depth", "--format", "svg", "--out", target, "--force"}}) {
    INFO(arguments[0]);
    CHECK(granuscope_command(arguments).code == 2);
    CHECK(read_file(target) == before);
  }
}

TEST_CASE("a figure has the format that its name says") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string();
  const auto figure = [&](const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"figure", run, "transport-with-depth", "--out", (folder / name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return granuscope_command(arguments).code;
  };
  CHECK(figure("f.svg") == 0);
  CHECK(read_file(folder / "f.svg").starts_with("<?xml"));
  CHECK(figure("g.PNG") == 0);
  CHECK(read_file(folder / "g.PNG").starts_with("\x89PNG"));
  CHECK(figure("h.tex", {"--format", "TikZ"}) == 0);
  CHECK(read_file(folder / "h.tex").find("\\usepackage{gnuplot-lua-tikz}") < 100);
  CHECK(figure("plot", {"--format", "pdf"}) == 0);
  for (const std::string name : {"f.jpg", "f", "f.d/plot"}) CHECK(figure(name) == 2);
  CHECK(figure("f.svg", {"--format", "pdf"}) == 2);
}

TEST_CASE("what is read of a run is of its last experiment") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string(), config = (folder / "small.toml").string();
  CHECK(granuscope_command({"numbers", run}).code == 0);
  REQUIRE(
      granuscope_command({"run", config, "-q", "--out", run, "--set", "sampling.seed=7", "--only", "sample"}).code ==
      0);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"numbers", run}, {"figure", run, "transport-with-depth", "--out", "x.pdf"}}) {
    const CommandResult refused = granuscope_command(arguments);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains("did not come to its"));
  }
}
