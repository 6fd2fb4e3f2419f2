// Input that cannot be used, each as a user would meet it: one message that names the place, the status that scripts
// rely on, and everything that was there before still there.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/file.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "cli/in_process.h"
#include "kit/file_size_limit.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "storage/pile_file.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
namespace fs = std::filesystem;

namespace {

const std::string& small = smallest_experiment_text;  // messages name its lines

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old.size(), by);
}

/// One figure by the script that figures share, one by a script of its own, and a PDF.
std::string two_plots() {
  return replaced(replaced(one_plot_text, "pdf = false", "pdf = true"), "[figures.transport_with_depth]\nshow = false",
                  "");
}

fs::path config(const test::TemporaryFolder& scratch, const std::string& text, const std::string& name = "e.toml") {
  std::ofstream(scratch / name) << text;
  return scratch / name;
}

CommandResult run(const fs::path& experiment, const fs::path& out, std::vector<std::string> flags = {}) {
  std::vector<std::string> arguments{"run", experiment.string(), "--out", out.string()};
  arguments.insert(arguments.end(), flags.begin(), flags.end());
  return granuscope_command(arguments);
}

/// Every file below a folder with a key of its bytes. The report tells of times and of what was reused, so that of it
/// only counts whether it is whole; manifest.json and timings.json, for the same reason, do not count.
std::map<std::string, std::string> contents_of(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == "manifest.json") continue;
    if (entry.path().filename() == "timings.json") continue;
    const std::string bytes = read_file(entry.path());
    const std::string name = entry.path().lexically_relative(folder).string();
    contents[name] = cache_key(bytes);
    if (name == "report.html") contents[name] = bytes.find("</html>") != std::string::npos ? "whole" : "cut";
    if (name == "report.pdf") contents[name] = bytes.find("%%EOF", bytes.size() - 10) < bytes.size() ? "whole" : "cut";
  }
  return contents;
}

/// Hidden names below a folder: what a run must not leave.
std::vector<std::string> hidden_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with(".")) names.push_back(entry.path().filename().string());
  }
  return names;
}

fs::path stored_pile(const test::TemporaryFolder& scratch) {
  const fs::path file = scratch / "pile.h5";
  REQUIRE(granuscope_command({"sample", "--columns", "20", "--layers", "10", "--out", file.string()}).code == 0);
  return file;
}

void check_one_message(const CommandResult& result, int code, const std::string& words) {
  CHECK(result.code == code);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, StartsWith("granuscope: ") && Contains(words));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
}

/// All else is made and told, and the last line says what could not be.
void check_failed_at_the_end(const CommandResult& result, const std::string& words) {
  CHECK(result.code == 3);
  CHECK_THAT(result.err, StartsWith("wrote ") && Contains("report.html\n") && Contains("summary.json\n"));
  const std::size_t last = result.err.rfind("\ngranuscope: ");
  REQUIRE(last != std::string::npos);
  CHECK_THAT(result.err.substr(last), Contains(words) && Contains("while all else was made"));
  CHECK(std::count(result.err.begin() + static_cast<std::ptrdiff_t>(last), result.err.end(), '\n') == 2);
}

}  // namespace

TEST_CASE("Experiments that cannot be used are refused with their line and what to do") {
  const test::TemporaryFolder scratch;
  struct Hostile {
    const char *old, *by, *words;
  };
  const std::vector<Hostile> all{
      {"columns = 60", "colums = 60", ":4:1: unknown key lattice.colums"},
      {"columns = 60", "colums = 60", "lattice.columns?"},
      {"[lattice]", "[latice]", ":3:2: unknown key latice"},
      {"columns = 60", "columns = 60.5", ":4:1: lattice.columns must be"},
      {"columns = 60", "columns = \"60\"", ":4:1: lattice.columns must be"},
      {"columns = 60", "columns = 0", ":4:1: lattice.columns: 0 columns are too few"},
      {"columns = 60", "columns = -5", ":4:1: lattice.columns: -5 columns are too few"},
      {"columns = 60", "columns = 100000000000", "lattice.columns: 100000000000 is out of range; give 4 to 1000000"},
      {"columns = 60\nlayers = 50", "columns = 900000\nlayers = 500000", "would need about"},
      {"layers = 50", "layers = 1000001", ":5:1: lattice.layers: 60 x 1000001 beads are more than 1000000 layers"},
      {"layers = 50", "layers = 0", ":5:1: lattice.layers: 0 layers are too few"},
      {"mu = [0.0, 0.3]", "mu = [-0.1, 0.3]", ":7:1: friction.mu: -0.1 is out of range"},
      {"mu = [0.0, 0.3]", "mu = [0.3, 1.7320508075688772]", "less than 1.732050808"},
      {"mu = [0.0, 0.3]", "mu = [nan, 0.3]", "friction.mu: nan"},
      {"mu = [0.0, 0.3]", "mu = [0.3, inf]", "friction.mu: inf"},
      {"mu = [0.0, 0.3]", "mu = \"0.3\"", "friction.mu must be"},
      {"mu = [0.0, 0.3]", "mu = []", "the list is empty"},
      {"last_layer = 26", "last_layer = 30", ":12:1: fit.last_layer: layer 30 lies beyond the last usable one, 29"},
      {"layers = [10, 20]", "layers = [10, 30]", ":18:1: figures.response_profiles.layers: layer 30"},
      {"columns = 60", "columns = 20", "the two peaks of the response at mu = 0.3 meet behind the ring from layer 9"},
      {"samples = 256", "samples = 0", ":9:1: response.samples: 0 is out of range; give 64"},
      {"samples = 256", "samples = -8", "response.samples: -8 is out of range; give 64 to"},
      {"scaling_window = [0.1, 0.3]", "scaling_window = [nan, 0.3]", "fit.scaling_window: nan is out of range"},
      {"dpi = 100", "dpi = nan", ":23:1: scenes.force_chains.dpi: nan"},
      {"width_px = 500", "width_px = 10000000", ":22:1: scenes.force_chains.width_px: "},
      {"[lattice]", "[lattice", ":3:9: "},
      {"name = \"small\"", "name = \"a\\nb\"", ":2:1: experiment.name: the name is longer than 200 bytes or holds"},
      {"name = \"small\"", "name = \"\xff\"", "not valid TOML"},
  };
  for (const Hostile& hostile : all) {
    CAPTURE(hostile.by);
    const fs::path file = config(scratch, replaced(small, hostile.old, hostile.by));
    const auto result = run(file, scratch / "out");
    check_one_message(result, 2, hostile.words);
    CHECK_THAT(result.err, Contains(file.string() + ":"));
    CHECK_FALSE(fs::exists(scratch / "out"));
  }
}

TEST_CASE("Flags that cannot be meant are refused before anything is written") {
  const test::TemporaryFolder scratch;
  const std::string pile = (scratch / "pile.h5").string();
  const std::string image = (scratch / "image.png").string();
  REQUIRE(granuscope_command({"sample", "--columns", "20", "--layers", "20", "--out", pile}).code == 0);
  const std::string before = read_file(pile), csv = (scratch / "contacts.csv").string();
  REQUIRE(granuscope_command({"export", pile, csv}).code == 0);
  struct Hostile {
    std::vector<std::string> arguments;
    int code;
    std::string words;
  };
  const std::vector<Hostile> all{
      {{"sample", "--mu", "nan", "--out", pile}, 2, "friction coefficient nan is out of range"},
      {{"sample", "--mu", "-0.1", "--out", pile}, 2, "friction coefficient -0.1 is out of range"},
      {{"sample", "--mu", "1.7320508075688773", "--out", pile}, 2, "is out of range"},
      {{"sample", "--mu", "much", "--out", pile}, 2, "--mu: much is not a number; write it in digits"},
      {{"sample", "--columns", "0", "--out", pile}, 2, "0 columns is too narrow"},
      {{"new", "--mu", ",", "--error-of", "c=0.001"}, 2, "\",\" behind --mu is a list of nothing"},
      {{"sample", "--columns", "99999999999", "--out", pile}, 2, "so many beads in a row would need 9.6 TB of memory"},
      {{"sample", "--layers", "12.5", "--out", pile}, 2, "--layers: 12.5 is not a whole number; write it in digits"},
      {{"sample", "--columns", "2147483647", "--layers", "2147483647", "--out", pile}, 3, "TB of memory are needed"},
      {{"sample", "--seed", "99999999999999999999", "--out", pile},
       2,
       "is too large; give at most 1844674407370955161"},
      {{"sample", "--seed", "-1", "--out", pile}, 2, "--seed: -1 is negative"},
      {{"sample", "--sample", "18446744073709551615", "--out", pile}, 2, "one seed names 4294967296 samples"},
      {{"sample", "--samples", "0", "--statistics"}, 2, "--samples 0 measures nothing"},
      {{"sample", "--samples", "18446744073709551615", "--statistics"}, 2, "samples are too many"},
      {{"sample", "--load", "point", "--overload", "nan", "--out", pile}, 2, "--overload: nan is out of range"},
      {{"sample", "--effort", "nan", "--out", pile}, 2, "--effort: nan is out of range"},
      {{"sample", "--colums", "9", "--out", pile}, 2, "sample has no flag --colums (did you mean --columns?)"},
      {{"sample", "--out", "-"}, 2, "name a file, or write ./- for one of that name"},
      {{"sample", "--out", "/dev/full"}, 3, "cannot write '/dev/full': "},
      {{"sample", "--out", scratch.path().string()}, 3, "A folder stands where a file is needed"},
      {{"sample", "--out", (scratch / "none/pile.h5").string()}, 3, "none/pile.h5': "},
      {{"render", pile, "--image", "-"}, 2, "./-"},
      {{"render", pile, "--image", image, "--width", "0"}, 2, "--width 0 is no width"},
      {{"render", pile, "--image", image, "--width", "1000000"}, 2, "1000000 pixels"},
      {{"render", pile, "--image", image, "--dpi", "nan"}, 2, "nan dpi is no resolution"},
      {{"render", pile, "--image", image, "--window=nan,1,0,4"}, 2, "the window nan,1,0,4"},
      {{"render", pile, "--image", image, "--window=-1e308,1e308,0,1e308"}, 2, "the layers 0 to 19"},
      {{"render", pile, image, "--height", "300"}, 2, "--height requires --film"},
      {{"render", pile, image, "--step", "3"}, 2, "--step requires --film"},
      {{"contacts", csv, image, "-j", "2"}, 2, "--threads requires --film"},
      {{"contacts", csv, image, "--window=-5,5,0,9"}, 2, "they reach over -"},
      {{"render", "/dev/zero", "--image", image}, 2, "it is not an ordinary file"},
      {{"render", (scratch / "no\nsuch \033[31m").string(), "--image", image}, 2, "no such [31m' as a pile file: No"},
      {{"doctor", "--out", "/proc/none"}, 3, "something that is needed is missing"},
  };
  for (const Hostile& hostile : all) {
    CAPTURE(fmt::format("{}", fmt::join(hostile.arguments, " ")));
    CommandResult result = granuscope_command(hostile.arguments);
    if (hostile.arguments.front() == "doctor") {
      CHECK_THAT(result.out, Contains("--  results     cannot make the folder '/proc/none'"));
      result.out.clear();
    }
    check_one_message(result, hostile.code, hostile.words);
    CHECK(read_file(pile) == before);
    CHECK_FALSE(fs::exists(image));
    CHECK(hidden_in(scratch.path()).empty());
  }
}

TEST_CASE("The pages for a package replace nobody's files") {
  const test::TemporaryFolder scratch;
  const std::string folder = scratch.path().string();
  CHECK(granuscope_command({"reference", "--files", folder}).code == 0);
  CHECK(granuscope_command({"reference", "--files", folder}).code == 0);
  write_file(scratch / "man/man1/granuscope.1", "mine");
  CHECK_THAT(granuscope_command({"reference", "--files", folder}).err, Contains("granuscope has not written it"));
  CHECK(read_file(scratch / "man/man1/granuscope.1") == "mine");
}

TEST_CASE("Doctor leaves no folder behind") {
  const test::TemporaryFolder scratch;
  (void)granuscope_command({"doctor", "--out", (scratch / "a/b/c").string()});
  CHECK(fs::is_empty(scratch.path()));
}

TEST_CASE("A pile none of which was completed costs nothing per bead that could be told") {
  const auto result = granuscope_command({"sample", "--law", "rejection", "--mu", "0.5", "--columns", "30", "--layers",
                                          "30", "--max-tries", "3", "--samples", "2", "--statistics"});
  CHECK(result.code == 2);
  CHECK_THAT(result.err, Contains("no pile could be completed, so that nothing is known; take"));
  CHECK_THAT(result.out, Contains("\"draws_per_bead\": null") && Contains("\"repaired_per_bead\": null") &&
                             Contains("\"reason\": \"no pile was completed"));
}

TEST_CASE("Titles reach no shell, no plot command and no page unescaped") {
  const test::TemporaryFolder scratch;
  const std::string trap = (scratch / "trap").string();
  const std::string title =
      "`touch " + trap + "` $(touch " + trap + ") 'q' <script>alert(1)</script> {{law}} {{{x}}} ]]>";
  const fs::path file =
      config(scratch,
             replaced(two_plots(), "name = \"small\"",
                      "name = \"" + title + "\"\ndescription = \"\\n<img src=x onerror=alert(2)>\\n{{#results}}\\n\""));
  // The folder's name reaches gnuplot and WeasyPrint.
  const fs::path out = scratch / "`touch trap` 'q' \"d\" <b> {{x}} $(y)\nline";
  const auto result = run(file, out);
  CHECK(result.code == 0);
  CHECK_FALSE(fs::exists(trap));
  CHECK_FALSE(fs::exists("trap"));
  const std::string page = read_file(out / "report.html");
  CHECK_THAT(page, Contains("&lt;script&gt;alert(1)&lt;/script&gt; {{law}} {{{x}}}") && Contains("{{#results}}"));
  CHECK_THAT(page, !Contains("alert(1)</script") && !Contains("<script>alert") && !Contains("<img src=x"));
  CHECK_THAT(read_file(out / "summary.md"), !Contains("<script") && !Contains("<img"));
  CHECK_THAT(read_file(out / "claims.xml"), Contains("&lt;script&gt;") && !Contains("<script"));
  CHECK(fs::exists(out / "report.pdf"));
  for (const auto& [name, key] : contents_of(out / "figures")) {
    CAPTURE(name, key);
    if (name.ends_with(".gp")) CHECK_THAT(read_file(out / "figures" / name), !Contains("touch"));
  }
}

TEST_CASE("A run meets what is in its folder already") {
  const test::TemporaryFolder scratch;
  const fs::path file = config(scratch, small + no_pdf);
  const fs::path out = scratch / "out";
  REQUIRE(run(file, out).code == 0);
  const auto before = contents_of(out);

  {
    INFO("another run at work");
    const FileDescriptor held(::open(out.c_str(), O_RDONLY | O_DIRECTORY));
    REQUIRE(::flock(held.get(), LOCK_EX | LOCK_NB) == 0);
    check_one_message(run(file, out), 5, "another run");
    CHECK(contents_of(out) == before);
  }
  {
    INFO("the ensembles of another seed: said before they are replaced");
    const fs::path other =
        config(scratch, replaced(small + no_pdf, "[lattice]", "[sampling]\nseed = 7\n[lattice]"), "f.toml");
    CHECK_THAT(run(other, out, {"--dry-run"}).out,
               Contains("mu = 0.3; replaces the file there: it is of another experiment: seed = 7 where 1 is there"));
    CHECK(contents_of(out) == before);
  }
  {
    INFO("the user's own file in the place of the resolved one");
    const std::string own = "# my thoughts\n" + small;
    std::ofstream(out / "experiment.toml") << own;
    check_one_message(run(out / "experiment.toml", out), 2, "this file with its comments would be lost");
    CHECK(read_file(out / "experiment.toml") == own);
    fs::remove(out / "experiment.toml");
    CHECK(run(file, out, {"--only", "sample"}).code == 0);
  }
  {
    INFO("the user's own file in the place of a result, by force");
    const std::string name = "summary.md", page = "index.html", history = (scratch / "nights").string();
    const std::string summary = read_file(out / name);
    fs::create_directory(history);
    for (const fs::path& own : {out / name, fs::path(history) / page}) std::ofstream(own) << small;
    check_one_message(run(out / "." / name, out, {"--force"}), 2, "in the place of this experiment");
    check_one_message(granuscope_command({"nightly", history + "/" + page, "--history", history}), 2,
                      "in the place of this experiment");
    CHECK(read_file(out / name) + read_file(fs::path(history) / page) == small + small);
    std::ofstream(out / name) << summary;
  }
  {
    INFO("its own resolved file, which it may be run from");
    CHECK(run(out / "experiment.toml", out, {"--only", "sample"}).code == 0);
    CHECK(contents_of(out) == before);
  }
  {
    INFO("ensembles that were damaged");
    std::string bytes = read_file(out / "ensembles/mu-0.3.h5");
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    std::ofstream(out / "ensembles/mu-0.3.h5") << bytes;
    std::ofstream(out / "ensembles/mu-0.h5") << "no longer HDF5";
    CHECK(run(file, out, {"--only", "sample"}).code == 0);
    CHECK(contents_of(out) == before);
  }
}

TEST_CASE("Helpers that fail cost nothing that was there") {
  const test::TemporaryFolder scratch;
  const fs::path file = config(scratch, two_plots());
  const fs::path out = scratch / "out";
  REQUIRE(run(file, out).code == 0);
  const auto before = contents_of(out);
  const test::FakePrograms programs(scratch / "programs");

  {
    INFO("gnuplot complains on two lines");
    programs.only("gnuplot", "printf 'line 1: bad\\n ^ here\\n' >&2; exit 1");
    check_failed_at_the_end(run(file, out), "it ended with status 1: line 1: bad  ^ here; the figure would be missing");
    CHECK(contents_of(out) == before);
  }
  {
    INFO("WeasyPrint fails where a PDF is required");
    programs.only("weasyprint", "printf 'Traceback\\n  somewhere\\nOSError: no\\n' >&2; exit 1");
    check_one_message(run(file, out, {"--require-pdf"}), 3, "WeasyPrint ended with status 1: OSError: no. report.html");
    CHECK(contents_of(out) == before);
  }
  {
    INFO("WeasyPrint fails where a PDF would be nice");
    programs.only("weasyprint", "kill -KILL $$");
    const auto result = run(file, out, {"--quiet"});  // it was asked for, and is not there
    CHECK(result.code == 0);
    CHECK_THAT(result.err, Contains("WeasyPrint was ended by signal 9 (Killed)") && Contains("is from an earlier run"));
    CHECK(contents_of(out) == before);
  }
  CHECK(hidden_in(out).empty());
}

TEST_CASE("A gnuplot that crashes or draws nothing costs nothing that was there") {
  const test::TemporaryFolder scratch;
  const fs::path file = config(scratch, small + no_pdf);
  const fs::path out = scratch / "out";
  REQUIRE(run(file, out).code == 0);
  const auto before = contents_of(out);
  const test::FakePrograms programs(scratch / "programs");
  const auto fails = [&](const std::string& script, const std::string& words) {
    programs.only("gnuplot", script);
    check_failed_at_the_end(run(file, out), words);
    CHECK(contents_of(out) == before);
  };
  fails("kill -SEGV $$", "it was ended by signal 11 (Segmentation fault);");
  fails("exit 0", ".svg is missing or empty");
  CHECK(hidden_in(out).empty());
}

TEST_CASE("A full disk at any write leaves whole files only") {
  const test::TemporaryFolder scratch;
  const fs::path file = config(scratch, small);
  REQUIRE(run(file, scratch / "whole").code == 0);
  const auto whole = contents_of(scratch / "whole");
  struct Disk {
    std::uint64_t limit;
    std::vector<const char*> gone;  ///< what is not there yet; without its manifest a run is not finished
  };
  const std::vector<Disk> disks{{1'000, {"ensembles"}},
                                {10'000, {"ensembles"}},
                                {fs::file_size(scratch / "whole/ensembles/mu-0.3.h5") - 1, {"ensembles"}},
                                {10'000, {"piles", "figures"}},
                                {fs::file_size(scratch / "whole/figures/force-chains.png") - 1, {"figures"}},
                                {20'000, {"manifest.json"}},
                                {fs::file_size(scratch / "whole/report.html") / 2, {"manifest.json"}}};
  for (const auto& [limit, gone] : disks) {
    CAPTURE(limit);
    const fs::path out = scratch / "out";
    fs::remove_all(out);
    fs::copy(scratch / "whole", out, fs::copy_options::recursive);
    for (const char* folder : gone) fs::remove_all(out / folder);
    CommandResult result;
    {
      const test::FileSizeLimit full(limit);
      result = run(file, out);
    }
    CHECK(result.code == 3);
    CHECK_THAT(result.err, Contains("cannot write") && Contains("File too large"));
    CHECK(hidden_in(out).empty());
    for (const auto& [name, key] : contents_of(out)) {
      CAPTURE(name);
      CHECK(key == whole.at(name));
    }
  }
}

TEST_CASE("A run killed anywhere is taken up where it was, and cleaned up after", "[long]") {
  const test::TemporaryFolder scratch;
  const fs::path file = config(scratch, replaced(small, "samples = 256", "samples = 2560"));
  REQUIRE(run(file, scratch / "whole").code == 0);
  const fs::path out = scratch / "out";
  int killed = 0;
  for (double seconds = 0.02; seconds < 20; seconds *= 1.25) {
    ProcessSpec spec;
    spec.arguments = {std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope", "run", file.string(), "--out", out.string()};
    spec.timeout_seconds = seconds;
    const ProcessResult result = run_process(spec);
    if (!result.timed_out) break;
    ++killed;
    if (!fs::exists(out)) continue;
    // Whatever has its name is whole.
    const auto whole = contents_of(scratch / "whole");
    for (const auto& [name, key] : contents_of(out)) {
      if (name.find("/.") != std::string::npos || name.starts_with(".")) continue;
      CAPTURE(seconds, name);
      CHECK(key == whole.at(name));
    }
  }
  CHECK(killed >= 5);
  CHECK(run(file, out).code == 0);
  CHECK(hidden_in(out).empty());
  CHECK(read_file(out / "summary.json") == read_file(scratch / "whole" / "summary.json"));
}

TEST_CASE("What nests without end is refused, and so is what was changed since its run") {
  const test::TemporaryFolder scratch;
  const std::string at = scratch.path().string(), many(100'000, '[');
  write_file(scratch / "deep.json", R"({"results": )" + many + "1" + std::string(100'000, ']') + "}");
  const std::string deep = (scratch / "deep.json").string();
  CHECK_THAT(granuscope_command({"compare", deep, deep}).err, Contains(deep + ": JSON that nests deeper"));
  std::string key = "a";
  for (int k = 0; k < 100'000; ++k) key += ".a";
  for (const std::string& text : {key + " = 1\n", "x = {" + key + " = 1}\n", "[" + key + "]\n"}) {
    write_file(scratch / "deep.toml", text);
    CHECK_THAT(granuscope_command({"run", (scratch / "deep.toml").string(), "--print-config"}).err,
               Contains("more than 100 parts"));
  }
  CHECK(granuscope_command({"run", (scratch / "deep.toml").string(), "--set", key + "=1"}).code == 2);
  const std::string points(300, '.');  // in a text, a comment and numbers they are none
  write_file(scratch / "fine.toml", "[experiment]\ndescription = \"\"\"\n\\\"" + points + "\n\"\"\"\nname = '" +
                                        std::string(150, '.') + "'  # " + points + "\n");
  CHECK(granuscope_command({"run", (scratch / "fine.toml").string(), "--print-config"}).code == 0);

  for (const std::string schema : {"6", "0", "\"x\"", "1.5"}) {
    fs::create_directory(scratch / "of");
    write_file(scratch / "of/summary.json", R"({"results": [], "schema": )" + schema + "}");
    const std::string of = (scratch / "of").string();
    for (const std::vector<std::string>& words : {std::vector<std::string>{"numbers", of}, {"compare", of, of}}) {
      const auto refused = granuscope_command(words);
      CHECK(refused.code == 2);
      CHECK_THAT(refused.err, Contains("summary.json: its schema is " + schema) && Contains("knows 1 to 5"));
    }
  }

  const std::string summary = R"({"results": [{"mu": 0.3, "x\\endcsname\\immediate, \"y": 1.5, "n": 2}]})";
  write_file(scratch / "summary.json", summary);
  const auto manifest = [&](const std::string& digest) {
    write_file(scratch / "manifest.json",
               R"({"stages": ["report"], "files": [{"path": "summary.json", "sha256": ")" + digest + "\"}]}");
  };
  manifest(sha256(summary));
  CHECK_THAT(granuscope_command({"numbers", at, "--all"}).out,
             Contains("granuscope@\\detokenize{mu-0.3/x-endcsname-immediate,-\"y}\\endcsname"));
  CHECK_THAT(granuscope_command({"numbers", at, "--all", "--format", "csv"}).out,
             Contains("\"mu-0.3/x\\endcsname\\immediate, \"\"y\",1.5,nan,"));
  manifest(sha256("other"));
  const auto changed = granuscope_command({"numbers", at});
  CHECK(changed.code == 2);
  CHECK_THAT(changed.err, Contains("summary.json is not what the run left there"));
  // The same bytes, elsewhere; and a manifest that was changed itself.
  write_file(scratch / "elsewhere", summary);
  fs::remove(scratch / "summary.json");
  fs::create_symlink(scratch / "elsewhere", scratch / "summary.json");
  manifest(sha256(summary));
  CHECK_THAT(granuscope_command({"numbers", at}).err, Contains("summary.json is not what the run left there"));
  fs::rename(scratch / "elsewhere", scratch / "summary.json");
  CHECK(granuscope_command({"numbers", at}).code == 0);
  write_file(scratch / "manifest.json", R"({"stages": ["report"], "files": [], "digest": "0"})");
  CHECK_THAT(granuscope_command({"numbers", at}).err, Contains("manifest.json is not what the run left there"));
}

TEST_CASE("What the files of others say moves no cursor, and has an end") {
  const test::TemporaryFolder scratch;
  const auto quiet = [&](const std::vector<std::string>& arguments, const std::string& words) {
    const CommandResult result = granuscope_command(arguments);
    INFO(result.err);
    CHECK_THAT(result.out, Contains(words) && !Contains("\x1b"));
  };
  const auto summary = [&](const std::string& name, const std::string& verdict) {
    write_file(scratch / name,
               R"({"results": [], "claims": [{"id": "c", "verdict": ")" + verdict + R"("}], "n\u001b[31m": 1})");
    return (scratch / name).string();
  };
  quiet({"compare", summary("a.json", "a"), summary("b.json", "\\u001b[31mb")}, "verdict changed: c: [31mb where");
  fs::rename(scratch / "a.json", scratch / "summary.json");
  quiet({"numbers", scratch.path().string(), "--all", "--format", "csv"}, "n [31m,1,");
  quiet({"doctor", "--out", (scratch / "d\x1b[31m").string()}, "d [31m can be written");
  Pile pile = read_pile(stored_pile(scratch));
  pile.law = "\x1b[31m";
  write_pile(scratch / "law.h5", pile);
  quiet({"audit", (scratch / "law.h5").string()}, "law [31m, seed");
  const fs::path run = scratch / "run\x1b[31m";
  fs::create_directories(run / "ensembles");
  write_file(run / "ensembles/mu-0.3.h5", "no HDF5");
  quiet({"run", config(scratch, small).string(), "--out", run.string(), "--force", "--dry-run"}, "run [31m/ensembles");

  fs::resize_file(scratch / "b.json", 2'000'000'000'000);  // holes, which take no space
  const CommandResult endless = granuscope_command({"compare", (scratch / "b.json").string(), "b.json"});
  CHECK(endless.code == 2);
  CHECK_THAT(endless.err, Contains("are too many for a file of its kind"));
  std::string keys;
  for (int k = 0; k < 20'000; ++k) keys += "k" + std::to_string(k) + " = 1\n";
  CHECK_THAT(granuscope_command({"run", config(scratch, keys, "keys.toml").string(), "--print-config"}).err,
             Contains("more than 1000 things are wrong"));
}
