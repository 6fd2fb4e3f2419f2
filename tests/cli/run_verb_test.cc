// The verb run.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "cli/flag_checks.h"
#include "cli/in_process.h"
#include "experiment/experiment_file.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

fs::path write_config(const test::TemporaryFolder& scratch, const std::string& text) {
  std::ofstream(scratch / "small.toml") << text;
  return scratch / "small.toml";
}

}  // namespace

TEST_CASE("run --print-config prints the resolved experiment and runs nothing") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result =
      granuscope_command({"run", config.string(), "--print-config", "--out", (scratch / "out").string()});
  REQUIRE(result.code == 0);
  CHECK(result.out == print_experiment(read_experiment(config)));
  CHECK(print_experiment(parse_experiment(result.out, "printed")) == result.out);
  CHECK_FALSE(fs::exists(scratch / "out"));
}

TEST_CASE("run --dry-run tells stages and cost and runs nothing") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "out").string()});
  REQUIRE(result.code == 0);
  CHECK_THAT(result.out, Contains("sample") && Contains("analyse") && Contains("report") && Contains("beads to draw") &&
                             Contains("by a trial of the first piles"));
  CHECK_FALSE(fs::exists(scratch / "out"));
}

TEST_CASE("run leaves the documented files, the same numbers for every number of threads, and resumes") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text + no_pdf);
  const auto first =
      granuscope_command({"run", config.string(), "--threads", "1", "--out", (scratch / "one").string()});
  INFO(first.err);
  REQUIRE(first.code == 0);
  for (const char* name : {"experiment.toml", "manifest.json", "ensembles", "piles", "figures", "summary.json",
                           "claims.xml", "summary.md", "report.html"}) {
    INFO(name);
    CHECK(fs::exists(scratch / "one" / name));
  }
  CHECK(parse_experiment(read_file(scratch / "one" / "experiment.toml"), "resolved").lattice.columns == 120);
  const json summary = json::parse(read_file(scratch / "one" / "summary.json"));
  CHECK(summary["schema"] == 5);
  CHECK(summary["experiment"] == "small");
  REQUIRE(summary["results"].size() == 4);
  CHECK(summary["results"][1]["samples"] == 256);

  REQUIRE(granuscope_command({"run", config.string(), "--threads", "2", "--out", (scratch / "two").string()}).code ==
          0);
  CHECK(read_file(scratch / "one" / "summary.json") == read_file(scratch / "two" / "summary.json"));

  // Again in the same folder: everything that takes time is there already.
  const auto nothing = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "one").string()});
  CHECK_THAT(nothing.out, Contains("nothing would be done"));
  const auto plan = granuscope_command({"run", config.string(), "--dry-run", "--out", (scratch / "one").string(),
                                        "--set", "report.headline=other words"});
  for (const char* mu : {"0", "0.2", "0.3", "0.4"})
    CHECK_THAT(plan.out, Contains(std::string("mu = ") + mu + " (there already)"));
  const std::string before = read_file(scratch / "one" / "summary.json");
  REQUIRE(granuscope_command({"run", config.string(), "--out", (scratch / "one").string()}).code == 0);
  CHECK(read_file(scratch / "one" / "summary.json") == before);
}

TEST_CASE("run --only sample stops after the ensembles") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  const auto result =
      granuscope_command({"run", config.string(), "--only", "sample", "--out", (scratch / "out").string()});
  INFO(result.err);
  REQUIRE(result.code == 0);
  CHECK(fs::exists(scratch / "out" / "ensembles"));
  CHECK_FALSE(fs::exists(scratch / "out" / "report.html"));
  const auto unknown = granuscope_command({"run", config.string(), "--only", "smaple"});
  CHECK(unknown.code == 2);
}

TEST_CASE("run --gate ends with 1 if a verdict is not the expected one") {
  const test::TemporaryFolder scratch;
  // Without friction rays go straight, exactly: the opposite is expected here.
  const auto config =
      write_config(scratch, smallest_experiment_text + no_pdf + "[gate.expect]\nfrictionless = \"not reproduced\"\n");
  const std::vector<std::string> command{"run", config.string(), "--out", (scratch / "out").string()};
  CHECK(granuscope_command(command).code == 0);
  auto gated = command;
  gated.push_back("--gate");
  const auto result = granuscope_command(gated);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Contains("frictionless") && !Contains("asks for nothing"));
  const auto open = write_config(scratch, smallest_experiment_text + no_pdf);
  CHECK_THAT(granuscope_command({"run", open.string(), "--gate", "--print-key"}).err, Contains("asks for nothing"));
  // Without an analysis there is no verdict to compare: that must not look like a pass.
  gated.insert(gated.end(), {"--only", "sample"});
  CHECK(granuscope_command(gated).code == 2);
}

TEST_CASE("run refuses what it cannot read before it writes anything") {
  const test::TemporaryFolder scratch;
  const std::vector<std::string> bad{"[lattice]\ncolums = 500\n", "[lattice\n", "[friction]\nmu = [2.0]\n"};
  for (const std::string& text : bad) {
    const auto config = write_config(scratch, text);
    const auto result = granuscope_command({"run", config.string(), "--out", (scratch / "out").string()});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("small.toml:"));
    CHECK_FALSE(fs::exists(scratch / "out"));
  }
  CHECK(granuscope_command({"run", (scratch / "missing.toml").string()}).code == 2);
  CHECK(granuscope_command({"run", scratch.path().string()}).code == 2);
  const auto config = write_config(scratch, "[report]\npdf = false\n");
  CHECK(granuscope_command({"run", config.string(), "--require-pdf"}).code == 2);
}

TEST_CASE("run tells a folder that cannot be written as an error of the environment") {
  const test::TemporaryFolder scratch;
  const auto config = write_config(scratch, small_experiment_text);
  CHECK(granuscope_command({"run", config.string(), "--out", "/dev/null/results"}).code == 3);
  std::ofstream(scratch / "file") << "in the way";
  CHECK(granuscope_command({"run", config.string(), "--out", (scratch / "file").string()}).code == 3);
}

// Flags of `run` for machines.

namespace {

Experiment resolved(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "run");
  arguments.emplace_back("--print-config");
  const CommandResult result = granuscope_command(arguments);
  INFO(result.err);
  REQUIRE(result.code == 0);
  return parse_experiment(result.out, "resolved");
}

/// Standard input for the time of one command.
class Input {
 public:
  explicit Input(const std::string& text) : text_(text), before_(std::cin.rdbuf(text_.rdbuf())) {}
  ~Input() { std::cin.rdbuf(before_); }
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;

 private:
  std::istringstream text_;
  std::streambuf* before_;
};

}  // namespace

TEST_CASE("run --set replaces what the file says, and is checked as it") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, small_experiment_text);
  const Experiment set = resolved({config, "--set", "response.samples=512", "--set", "friction.mu = [0.3]", "--set",
                                   "response.estimator=paired", "--set", "experiment.name=two words"});
  CHECK(set.response.samples == 512);
  CHECK(set.mu == std::vector<double>{0.3});
  CHECK(set.response.estimator == EstimatorName::paired);
  CHECK(set.name == "two words");
  CHECK(set.lattice.columns == 120);  // as in the file
  CHECK(resolved({config, "--set", "response.samples=512", "--set", "response.samples=768"}).response.samples == 768);

  const auto refused = [&](const std::string& assignment) {
    const CommandResult result = granuscope_command({"run", config, "--print-config", "--set", assignment});
    CHECK(result.code == 2);
    return result.err;
  };
  CHECK_THAT(refused("response.sample=512"), Contains("--set response.sample=512") && Contains("response.samples"));
  CHECK_THAT(refused("response.samples=many"), Contains("--set response.samples=many") && Contains("whole number"));
  CHECK_THAT(refused("response.samples=8"), Contains("--set response.samples=8"));
  CHECK_THAT(refused("response.samples"), Contains("sets no key"));
  CHECK_THAT(refused("lattice=7"), Contains("must be a table"));
  CHECK_THAT(refused("response.samples=512\n[fit]"), Contains("sets no key"));
  CHECK_THAT(refused("experiment.name='it's'"), Contains("not valid TOML"));
}

TEST_CASE("run - reads the experiment from standard input, and needs a name for the folder") {
  {
    const Input input(small_experiment_text);
    CHECK(resolved({"-"}).lattice.columns == 120);
  }
  {
    const Input input(small_experiment_text);
    const CommandResult result = granuscope_command({"run", "-"});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("--out"));
  }
  const Input input("[lattice]\ncolums = 3\n");
  const CommandResult result = granuscope_command({"run", "-", "--print-config"});
  CHECK(result.code == 2);
  CHECK_THAT(result.err, Contains("standard input:2:1"));
}

TEST_CASE("run --set takes words as people write them") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, "[lattice]\ncolumns = 240\n");
  for (const std::string name : {"The pile of Breton's paper", "a # b", "C:\\piles [new]", "say \"when\""}) {
    CHECK(resolved({config, "--set", "experiment.name=" + name}).name == name);
  }
  CHECK(resolved({config, "--set", "response.samples=1e3"}).response.samples == 1000);
  const auto refused = [&](const std::string& assignment) {
    return granuscope_command({"run", config, "--print-config", "--set", assignment}).err;
  };
  CHECK_THAT(refused("experiment.name='half"), Contains("write ' at both of its ends"));
  CHECK_THAT(refused("sampling.bead_weight=0,3"), Contains("decimal comma"));
  CHECK_THAT(refused("friction.mu=[−0.3]"), Contains("U+2212"));
}

TEST_CASE("run reads what the shell has opened for it") {
  const test::TemporaryFolder scratch;
  int ends[2] = {};
  REQUIRE(::pipe(ends) == 0);
  const std::string text = "[lattice]\ncolumns = 240\n";
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  const std::string pipe = "/dev/fd/" + std::to_string(ends[0]);
  CHECK_THAT(granuscope_command({"run", pipe, "--dry-run"}).err, Contains("--out"));  // whose name names no folder
  ::close(ends[0]);
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  CHECK(resolved({"/dev/fd/" + std::to_string(ends[0])}).lattice.columns == 240);
  ::close(ends[0]);
  REQUIRE(::pipe(ends) == 0);
  const std::string contacts = "x1,y1,x2,y2,N\n0,0,1,0,5\n";
  REQUIRE(::write(ends[1], contacts.data(), contacts.size()) == static_cast<ssize_t>(contacts.size()));
  ::close(ends[1]);
  CHECK_THAT(granuscope_command({"contacts", "/dev/fd/" + std::to_string(ends[0]), "--json"}).out,
             Contains("\"contacts\": 1"));
  ::close(ends[0]);
}

TEST_CASE("an experiment without any key is refused") {
  const test::TemporaryFolder scratch;
  for (const char* text : {"", "# cut\n", "[lattice]\n"}) {
    const CommandResult result = granuscope_command({"run", write_config(scratch, text), "--print-config"});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains("there is no key in it"));
  }
  CHECK(granuscope_command({"run", write_config(scratch, "[report]\npdf = false\n"), "--print-config"}).code == 0);
}

TEST_CASE("run --print-key names the experiment in one line") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, small_experiment_text);
  const auto key = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", config, "--print-key"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = granuscope_command(arguments);
    REQUIRE(result.code == 0);
    CHECK(std::count(result.out.begin(), result.out.end(), '\n') == 1);
    return result.out;
  };
  CHECK(key({}) == key({"--threads", "3"}));
  CHECK(key({}) == key({"--set", "lattice.columns=120"}));
  CHECK(key({}) != key({"--set", "lattice.columns=121"}));
}

TEST_CASE("a folder at work ends with 5, and --quiet says nothing") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, smallest_experiment_text), out = (scratch / "out").string();
  ProcessSpec spec;
  spec.arguments = {std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope",
                    "run",
                    config,
                    "--out",
                    out,
                    "--quiet",
                    "-j",
                    "2",
                    "--only",
                    "plot"};
  const ProcessResult quiet = run_process(spec);
  CHECK(quiet.exit_code == 0);
  CHECK(quiet.standard_error.empty());
  CHECK(fs::exists(scratch / "out/figures/response-profiles.svg"));

  CHECK_THAT(granuscope_command({"merge", out}).err,
             Contains("nothing was to be joined for " + out + "; granuscope run"));
  const int folder = ::open(out.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  REQUIRE(::flock(folder, LOCK_EX | LOCK_NB) == 0);
  const CommandResult busy = granuscope_command({"run", config, "--out", out});
  spec.environment = {{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}};
  const ProcessResult of_mpirun = run_process(spec);
  ::close(folder);
  CHECK(busy.code == 5);
  CHECK_THAT(busy.err, Contains("another run or shard is working") && !Contains("mpirun"));
  CHECK(of_mpirun.exit_code == 5);
  CHECK_THAT(of_mpirun.standard_error, Contains("let it start granuscope-mpi run, or give --shard auto"));
}

TEST_CASE("run --keep-going loses only what the machine lacks") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch, smallest_experiment_text + "show = false\n[report]\npdf = false\n");
  const test::SearchPath none((scratch / "no-programs").string());
  const std::string out = (scratch / "out").string();
  const CommandResult stopped = granuscope_command({"run", config, "--out", out});
  CHECK(stopped.code == 3);
  CHECK_FALSE(fs::exists(scratch / "out/ensembles"));
  const CommandResult result = granuscope_command({"run", config, "--out", out, "--keep-going"});
  CHECK(result.code == 3);
  CHECK_THAT(result.err, Contains("gnuplot is not found in PATH"));
  CHECK(fs::exists(scratch / "out/summary.json"));
  CHECK_THAT(read_file(scratch / "out/report.html"), Contains("gnuplot is not found in PATH"));
}

// No verb writes over a file that it reads, nor over one that this program has not written, unless --force is given.

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

TEST_CASE("no verb writes over a part of a run, nor a pile over an ensemble") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string pile = (folder / "pile.h5").string();
  fs::copy(folder / "run/ensembles/mu-0.3.h5", folder / "copy.h5");
  fs::create_directory_symlink(folder / "run/figures", folder / "linked");
  const std::vector<std::string> sample = {"sample", "--mu", "0.3", "--columns", "20", "--layers", "10", "--out"};
  for (const auto& [verb, name] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {sample, "run/ensembles/mu-0.3.h5"},
           {sample, "run/piles/uniform.h5"},
           {sample, "copy.h5"},
           {{"render", pile, "-o"}, "run/figures/force-chains.png"},
           {{"render", pile, "-o"}, "linked/force-chains.png"},
           {{"export", pile, "-o"}, "run/figures/response-profiles-layer-20.csv"}}) {
    INFO(name);
    const fs::path file = folder / name;
    REQUIRE(fs::exists(file));
    const std::string before = read_file(file);
    std::vector<std::string> arguments = verb;
    arguments.push_back(file.string());
    const CommandResult refused = granuscope_command(arguments);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains(name) && (Contains("lose") || Contains("lost")));
    CHECK((read_file(file) == before));
  }
}

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

TEST_CASE("no picture, frame or archive takes the place of what it is made of, and no file that of another one") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string(), at = folder.path().string() + "/";
  fs::copy(folder / "run/ensembles/mu-0.3.h5", folder / "e.png");
  fs::create_directories(folder / "film");
  fs::copy(folder / "pile.h5", folder / "film/frame-00000.png");
  fs::create_directory_symlink(folder / "film", folder / "linked");
  write_file(folder / "CITATION.cff", "cff-version: 1.2.0\ntitle: t\nauthors:\n  - family-names: A\n");
  fs::current_path(folder.path());
  for (const auto& [file, arguments] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"e.png", {"render", at + "e.png", "-o", "e.png", "--force"}},
           {"film/frame-00000.png", {"render", at + "film/frame-00000.png", "--film", "linked", "--step", "5"}},
           {"CITATION.cff", {"pack", run, "-o", at + "CITATION.cff", "--force"}},
           {"none",
            {"sample", "--mu", "0.3", "--columns", "20", "--layers", "10", "--samples", "64", "--statistics", "--out",
             "none", "--distributions", "./none"}}}) {
    INFO(file);
    const std::string before = fs::exists(file) ? read_file(file) : "";
    CHECK(granuscope_command(arguments).code == 2);
    CHECK((fs::exists(file) ? read_file(file) : "") == before);
  }
  fs::current_path("/");
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
  const std::string tikz = read_file(folder / "h.tex");
  CHECK(tikz.find("\\usepackage{gnuplot-lua-tikz}") < tikz.find('\n'));
  CHECK(figure("plot", {"--format", "pdf"}) == 0);
  for (const std::string name : {"f.jpg", "f", "f.d/plot"}) CHECK(figure(name) == 2);
  CHECK(figure("f.svg", {"--format", "pdf"}) == 2);
  CHECK(figure("f.jpg", {"--format", "pdf"}) == 2);
}

TEST_CASE("every file that is written has the format that its name says") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const std::string run = (folder / "run").string();
  const auto numbers = [&](const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"numbers", run, "--out", (folder / name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return granuscope_command(arguments).code;
  };
  CHECK(numbers("n.csv") == 0);
  CHECK(read_file(folder / "n.csv").starts_with("name,value,"));
  CHECK(numbers("n.JSON") == 0);
  CHECK(read_file(folder / "n.JSON").starts_with("{"));
  CHECK(numbers("n.tex") == 0);
  CHECK_THAT(read_file(folder / "n.tex"), Contains("\\newcommand{\\granuscope}"));
  CHECK(numbers("n.sty", {"--format", "tex"}) == 0);
  CHECK(numbers("n.csv", {"--format", "tex", "--force"}) == 2);
  CHECK(numbers("n.tsv") == 2);
  for (const std::vector<std::string>& other :
       std::vector<std::vector<std::string>>{{"pack", run, "--out", "r.tar.gz"},
                                             {"compare", run, run, "--json", "c.csv"},
                                             {"sample", "--columns", "20", "--layers", "10", "--out", "p.vtu"},
                                             {"new", "--mu", "0.3", "--out", "e.json"},
                                             {"new", "--mu", "0.3", "--out", "e.yaml"},
                                             {"numbers", run, "--format", "csv", "--out", "n.png"},
                                             {"bench", "sampler", "--json", "b.csv"},
                                             {"contacts", (folder / "none.csv").string(), "--histogram", "h.png"}}) {
    const CommandResult refused = granuscope_command(other);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Contains(other.back()) && Contains("let it end with ."));
    CHECK_FALSE(fs::exists(other.back()));
  }
}

TEST_CASE("the name of a file that is written moves no cursor") {
  const test::TemporaryFolder folder;
  const std::string file = (folder /
                            "a\x1b[31mb\xe2\x80\xae"
                            "c.h5")
                               .string();
  const CommandResult stored = granuscope_command({"sample", "--columns", "20", "--layers", "10", "--out", file});
  CHECK(stored.code == 0);
  CHECK(fs::exists(file));
  CHECK_THAT(stored.err, Contains("wrote ") && Contains("a [31mb c.h5\n") && !Contains("\x1b"));
}

TEST_CASE("what a wrapper of fontconfig prints is no font") {
  const test::TemporaryFolder folder;
  make_run_and_pile(folder);
  const test::FakePrograms fakes(folder / "bin");
  fakes.only("fc-match", "echo 'module fontconfig loaded'\nexec /usr/bin/fc-match \"$@\"");
  const CommandResult drawn =
      granuscope_command({"render", (folder / "pile.h5").string(), (folder / "p.png").string(), "--font", "DejaVu Sans",
                          "--font-size", "8 PT", "--width", "90 MM", "--language", "FR"});
  CHECK(drawn.code == 0);
  CHECK_THAT(drawn.err, !Contains("module"));
}

TEST_CASE("--set stands in for what the file has wrong") {
  const test::TemporaryFolder folder;
  const fs::path config = folder / "wrong.toml";
  write_file(config, "[friction]\nmu = \"much\"\n[response]\nestimator = \"Point\"\n");
  CHECK(granuscope_command({"run", config.string(), "--print-key"}).code == 2);
  CHECK(granuscope_command({"run", config.string(), "--print-key", "--set", "friction.mu=0.3"}).code == 2);
  CHECK(granuscope_command(
            {"run", config.string(), "--print-key", "--set", "friction.mu=0.3", "--set", "response.estimator=point"})
            .code == 0);
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

TEST_CASE("more memory than there is is refused in words") {
  CHECK_NOTHROW(require_memory(1e6));
  CHECK_THROWS_AS(require_memory(1e18), EnvironmentError);
}
