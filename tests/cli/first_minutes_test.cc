// What somebody writes who has not read the documentation, and what an installation puts beside the program.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/in_process.h"
#include "experiment/experiment_file.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "report/page_overlays.h"
#include "support/templates.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;

namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// Exit status of a command line of the shell.
int status_of_shell(const std::string& command) {
  const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): nothing else runs
  REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("Without a word the program prints its help, as a mistake") {
  const auto result = granuscope_command({});
  CHECK(result.code == 2);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains("Usage: granuscope") && Contains("Verbs:") && Contains("example"));
}

TEST_CASE("Help and version are found by the usual words") {
  CHECK(granuscope_command({"help"}).out == granuscope_command({"--help"}).out);
  CHECK(granuscope_command({"help", "render"}).out == granuscope_command({"render", "--help"}).out);
  CHECK(granuscope_command({"version"}).out == granuscope_command({"--version"}).out);
  CHECK(granuscope_command({"-V"}).out == granuscope_command({"--version"}).out);
  CHECK_THAT(granuscope_command({"version"}).out, StartsWith("granuscope 0."));
}

TEST_CASE("A file where a verb belongs is answered with the command that takes it") {
  CHECK_THAT(granuscope_command({"my.toml"}).err, Contains("did you mean: granuscope run my.toml?"));
  CHECK_THAT(granuscope_command({"my.h5"}).err, Contains("did you mean: granuscope render my.h5?"));
  const test::TemporaryFolder folder;
  std::ofstream(folder / "experiment") << "[lattice]\n";
  CHECK_THAT(granuscope_command({(folder / "experiment").string()}).err, Contains("did you mean: granuscope run "));
}

TEST_CASE("Only a near name is offered, and a flag of one letter is named") {
  CHECK_THAT(granuscope_command({"sample", "--colums", "8"}).err, Contains("did you mean --columns?"));
  CHECK_THAT(granuscope_command({"sample", "--best"}).err,
             Contains("has no flag --best;") && !Contains("did you mean"));
  CHECK_THAT(granuscope_command({"sample", "-x", "2"}).err, Contains("sample has no flag -x"));
  CHECK_THAT(
      granuscope_command({"sample", "--layesr", "9", "-x", "2", "--colums=9"}).err,
      Contains("sample has no flags --layesr (did you mean --layers?), -x, --colums (did you mean --columns?);"));
  CHECK_THAT(granuscope_command({"run"}).err, Contains("granuscope example"));
  CHECK_THAT(granuscope_command({"--xyzzy"}).err, Contains("there is no flag --xyzzy; but for --help and --version"));
  for (const char* version : {"-v", "-version", "--versoin"}) {
    const auto result = granuscope_command({version});
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(version) && Contains("did you mean -V (--version)?"));
  }
  CHECK_THAT(granuscope_command({"-H"}).err, Contains("did you mean -h (--help)?"));
  for (const char* dashes : {"-", "--"}) CHECK(granuscope_command({dashes}).code == 2);
  CHECK_THAT(granuscope_command({"audit", "one", "two", "three"}).err, Contains("\"two\" is one word more"));
}

namespace {

/// A slip, and words of its answer: the command that was meant.
struct Slip {
  std::vector<std::string> words;
  std::string answer;
};

const std::string picture = GRANUSCOPE_SOURCE_DIR "/tests/data/pictures/point.h5";

const std::vector<Slip> slips = {
    // A key of the file as a flag
    {{"run", "s.toml", "--mu", "0.2"}, "run has no flag --mu (write --set friction.mu=0.2);"},
    {{"run", "s.toml", "--mu=0.2,0.3"}, "(write --set friction.mu=0.2,0.3)"},
    {{"run", "s.toml", "--samples", "256"}, "(write --set response.samples=256)"},
    {{"run", "s.toml", "--seed", "2"}, "(write --set sampling.seed=2)"},
    {{"run", "s.toml", "--first-layer", "9", "--pdf"}, "--pdf (write --set report.pdf=VALUE)"},
    {{"nightly", "s.toml", "--history", "h", "--samples", "256"}, "(write --set response.samples=256)"},
    {{"new", "--columns", "100"}, "or: granuscope run FILE --set lattice.columns=100)"},
    {{"new", "--law", "polytope"}, "or: granuscope run FILE --set sampling.law=polytope)"},
    // Flags and verbs of other programs
    {{"render", "p.h5", "--cmap", "grey"}, "(did you mean --colour-map?)"},
    {{"render", "p.h5", "--colormap", "grey"}, "(did you mean --colour-map?)"},
    {{"run", "s.toml", "--output", "o"}, "--output (did you mean -o?)"},
    {{"run", "s.toml", "-n", "4"}, "-n (did you mean -j?)"},
    {{"run", "s.toml", "--resume"}, "--resume (the same command goes on from where it stopped)"},
    {{"run", "s.toml", "--OUT", "o"}, "--OUT (did you mean --out?)"},
    {{"plot"}, "did you mean: granuscope figure OUT?"},
    {{"status"}, "did you mean: granuscope run FILE --dry-run?"},
    {{"quick"}, "did you mean: granuscope example quick?"},
    // A number that is none
    {{"new", "--mu", "0.1:0.3:0.1"}, "--mu: 0.1:0.3:0.1 is not a number"},
    {{"new", "--error-of", "c=0.3%"}, "--error-of c=0.3%: 0.3% is not a number"},
    {{"nightly", "s.toml", "--history", "h", "--grow", "1,5"}, "1,5 is not a whole number; write it in digits"},
    {{"render", picture, "a.png", "--width", "86,5mm"}, "86,5mm: there is a decimal comma in it; write a point"},
    {{"render", picture, "a.png", "--font-size", "\u20138"}, "there is the dash U+2013 in it; write - for minus"},
    // A word in the place of another
    {{"figure", "out/s", "response-profiles", "r.png"},
     "\"r.png\" is one word more than is expected here; write -o r.png;"},
    {{"sample", "--mu", "0.3", "pile.h5"}, "write -o pile.h5;"},
    {{"numbers", "out/s", "mu-0.2/c"}, "write --only mu-0.2/c;"},
    {{"new", "mine.toml"}, "write -o mine.toml;"},
    {{"render", "pile.png"}, "pile.png is a picture, and the pile comes first: granuscope render PILE.h5 pile.png"},
    {{"render", picture, "film.mp4"}, "film.mp4 is a film, of which render makes the frames"},
    {{"render", picture, "--film", "film.mp4"}, "give a folder for them: --film FOLDER"},
    {{"render", picture, "a.png", "--language", "French"}, "there is no language french for figures; write fr,"},
};

}  // namespace

TEST_CASE("Each slip is answered with the command that was meant") {
  for (const Slip& slip : slips) {
    const auto result = granuscope_command(slip.words);
    INFO(slip.words.front() << ' ' << slip.words.back());
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(slip.answer));
  }
  CHECK_FALSE(std::filesystem::exists("film.mp4"));
  // What is offered is there.
  const std::string flags = granuscope_command({"reference", "--verbs"}).out;
  std::istringstream hints{std::string(template_file("hints.txt"))};
  for (std::string line; std::getline(hints, line);) {
    if (line.starts_with('#')) continue;
    const std::string word = line.substr(0, line.find(" = ")), here = line.substr(line.find(" = ") + 3);
    INFO(line);
    if (here.starts_with('-')) CHECK_THAT(flags, Contains(here + ",") || Contains(here + "`"));
    if (word.starts_with('-')) continue;
    CHECK_THAT(granuscope_command({word}).err, Contains("did you mean: granuscope " + here + "?"));
    CHECK(granuscope_command({"help", here.substr(0, here.find(' '))}).code == 0);
  }
  CHECK_THAT(granuscope_command({"new", "--mu", "0.2", "--error-of", "D=0.00001", "--layers", "60"}).out,
             Contains("; not reached: precision.most_samples = 100000 ends it there, about "));
}

TEST_CASE("Every built-in example is listed by its title, and printed as it stands in examples/") {
  const auto list = granuscope_command({"example"});
  CHECK(list.code == 0);
  int examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GRANUSCOPE_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".toml") continue;
    ++examples;
    const std::string name = entry.path().stem().string();
    INFO(name);
    CHECK_THAT(list.out, Contains(name) && Contains(read_experiment(entry.path()).name));
    CHECK((granuscope_command({"example", name}).out == text_of(entry.path())));
    CHECK((granuscope_command({"example", name + ".toml"}).out == text_of(entry.path())));
  }
  CHECK(examples >= 6);
  const auto unknown = granuscope_command({"example", "nothing"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("built in are") && Contains("quick"));
  CHECK_THAT(granuscope_command({"example", "quikc"}).err, Contains("did you mean quick?"));
}

TEST_CASE("A reader that leaves early ends the program without a word") {
  const test::TemporaryFolder folder;
  const std::string program = GRANUSCOPE_BINARY_DIR "/granuscope ";
  const std::string experiment = GRANUSCOPE_SOURCE_DIR "/examples/quick.toml ";
  // The second program waits until the first reader has gone.
  for (const std::string& verb : {"run " + experiment + "--print-config", std::string("reference")}) {
    INFO(verb);
    const std::string errors = (folder / "errors").string();
    CHECK(status_of_shell("bash -o pipefail -c '{ sleep 0.2; " + program + verb + " 2>" + errors + "; } | true'") == 0);
    CHECK(text_of(errors).empty());
  }
}

TEST_CASE("doctor and audit print JSON") {
  const auto doctor = granuscope_command({"doctor", "--json"});
  const auto findings = nlohmann::json::parse(doctor.out);
  CHECK(findings.at("good").get<bool>() == (doctor.code == 0));
  CHECK(findings.at("findings").size() >= 8);
  for (const auto& finding : findings.at("findings")) CHECK_FALSE(finding.at("text").get<std::string>().empty());

  const std::string pile = GRANUSCOPE_SOURCE_DIR "/tests/data/pictures/point.h5";
  const auto audited = nlohmann::json::parse(granuscope_command({"audit", pile, "--json"}).out);
  CHECK(audited.at("good").get<bool>());
  CHECK(audited.at("max_balance_residual").at("value").get<double>() > 0);
  CHECK(audited.at("max_balance_residual").at("value").get<double>() < audited.at("allowed").get<double>());
  CHECK_THAT(granuscope_command({"audit", pile}).out, Contains(audited.at("law").get<std::string>()));
}

TEST_CASE("Manual pages and completions know every verb and flag, and their readers accept them") {
  const test::TemporaryFolder folder;
  REQUIRE(granuscope_command({"reference", "--files", folder.path().string()}).code == 0);
  const std::string reference = granuscope_command({"reference", "--verbs"}).out;
  const std::string bash = text_of(folder / "bash-completion/completions/granuscope");
  const std::string zsh = text_of(folder / "zsh/vendor-completions/_granuscope");
  const std::string fish = text_of(folder / "fish/vendor_completions.d/granuscope.fish");
  std::istringstream lines(reference);
  int flags = 0;
  std::string page;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("### granuscope ")) {
      const std::string verb = line.substr(15);
      INFO(verb);
      page = text_of(folder / ("man/man1/granuscope-" + verb + ".1"));
      CHECK_THAT(page, StartsWith(".TH "));
      CHECK_THAT(bash, Contains(" " + verb + ")"));
      CHECK_THAT(zsh, Contains(" " + verb + ")"));
      CHECK_THAT(fish, Contains("-a " + verb + " "));
    }
    const std::size_t at = line.find("--");
    if (!line.starts_with("| `") || at == std::string::npos || at > 8) continue;
    const std::string flag = line.substr(at + 2, line.find_first_of("`,", at) - at - 2);
    std::string in_roff;
    for (const char c : flag) in_roff += c == '-' ? std::string("\\-") : std::string(1, c);
    INFO(flag);
    CHECK_THAT(page, Contains("\\fB\\-\\-" + in_roff + "\\fR"));
    CHECK_THAT(bash, Contains("--" + flag));
    CHECK_THAT(zsh, Contains("--" + flag));
    CHECK_THAT(fish, Contains("-l " + flag));
    ++flags;
  }
  CHECK(flags > 40);
  const std::string keys = text_of(folder / "man/man5/granuscope-experiment.5");
  CHECK_THAT(keys, Contains("\\fBlattice.columns\\fR (default 500; beads;"));
  CHECK_THAT(keys, Contains("|T| / (mu N)"));  // the bar of a Markdown cell, without its mark

  // bash completes a verb and a flag.
  const std::string script = (folder / "script").string();
  std::ofstream(script) << ". '" << (folder / "bash-completion/completions/granuscope").string() << "'\n"
                        << "COMP_WORDS=(granuscope ren) COMP_CWORD=1; _granuscope; echo \"${COMPREPLY[*]}\"\n"
                        << "COMP_WORDS=(granuscope render --im) COMP_CWORD=2; _granuscope; echo \"${COMPREPLY[*]}\"\n";
  CHECK(status_of_shell("bash -eu " + script + " >" + script + ".out") == 0);
  CHECK(text_of(script + ".out") == "render\n--image\n");
  // The formatter of manual pages, where it is installed, has nothing to warn about.
  if (status_of_shell("command -v groff >/dev/null") == 0) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "man")) {
      if (!entry.is_regular_file()) continue;
      const std::string said = (folder / "said").string();
      CHECK(status_of_shell("groff -k -ww -man -Tutf8 -z '" + entry.path().string() + "' 2>" + said) == 0);
      INFO(entry.path());
      CHECK(text_of(said).empty());
    }
  }
}

TEST_CASE("render takes the picture as its second word") {
  const test::TemporaryFolder folder;
  const std::string pile = GRANUSCOPE_SOURCE_DIR "/tests/data/pictures/point.h5";
  const auto result = granuscope_command({"render", pile, (folder / "a.png").string(), "--width", "400"});
  CHECK(result.code == 0);
  CHECK(std::filesystem::file_size(folder / "a.png") > 1000);
}

namespace {

/// Debian's interpreter, which has Debian's modules; "" where `module` is missing.
std::string python_with(const std::string& module) {
  const std::string python = "/usr/bin/python3";
  if (status_of_shell("test -x " + python + " && " + python + " -c 'import " + module + "' 2>/dev/null") == 0)
    return python;
  WARN("no " << python << " with " << module << " here: nothing was tested");
  return "";
}

}  // namespace

TEST_CASE("The Python examples read an ensemble and a pile") {
  const std::string python = python_with("h5py");
  if (python.empty()) return;
  const test::TemporaryFolder folder;
  const std::string scripts = GRANUSCOPE_SOURCE_DIR "/examples/python/", at = folder.path().string();
  std::ofstream(folder / "e.toml") << "[lattice]\ncolumns = 64\nlayers = 64\n[friction]\nmu = [0.0]\n[response]\n"
                                      "samples = 256\n[fit]\nfirst_layer = 24\nlast_layer = 42\n"
                                      "[figures.response_profiles]\nshow = false\n";
  REQUIRE(granuscope_command({"run", at + "/e.toml", "--out", at + "/out", "--only", "sample"}).code == 0);
  REQUIRE(status_of_shell(python + " " + scripts + "response_profile.py " + at + "/out/ensembles/mu-0.h5 24 >" + at +
                          "/r.csv") == 0);
  // Without friction the overload of 1 goes down two lines of beads, half of it each, at c0 z from the middle.
  std::istringstream rows(text_of(folder / "r.csv"));
  std::string head;
  std::getline(rows, head);
  CHECK(head == "x,P");
  std::getline(rows, head);
  CHECK(head == "#bead diameters,1/bead diameter");
  double sum = 0;
  for (std::string row; std::getline(rows, row);) {
    const double x = std::atof(row.c_str()), value = std::atof(row.c_str() + row.find(',') + 1);
    INFO(row);
    CHECK(value == Approx(std::abs(x) == 12 ? 0.5 : 0.0).margin(1e-9));
    sum += value;
  }
  CHECK(sum == Approx(1).margin(1e-6));

  // render takes the ensemble, too.
  CHECK(granuscope_command({"render", at + "/out/ensembles/mu-0.h5", at + "/field.png", "--width", "500"}).code == 0);
  CHECK(std::filesystem::file_size(folder / "field.png") > 1000);
  CHECK(granuscope_command({"render", at + "/out/ensembles/mu-0.h5", at + "/x.png", "--scene", "weight"}).code == 2);

  REQUIRE(
      granuscope_command({"sample", "--mu", "0.3", "--columns", "20", "--layers", "12", "--out", at + "/p.h5"}).code ==
      0);
  if (!python_with("vtkmodules").empty()) {  // tubes of the contacts between beads, as wide as their forces
    REQUIRE(granuscope_command({"export", at + "/p.h5", "-o", at + "/p.vtu"}).code == 0);
    REQUIRE(status_of_shell(python + " " + scripts + "paraview_tubes.py " + at + "/p.vtu " + at + "/t.vtp") == 0);
    CHECK_THAT(text_of(folder / "t.vtp"),
               Contains("Name=\"N\"") && Contains("NumberOfStrips=\"" + std::to_string(2 * 20 * 11 * 8) + "\""));
  }
  if (python_with("matplotlib").empty()) return;
  REQUIRE(status_of_shell("MPLCONFIGDIR=" + at + " " + python + " " + scripts + "force_chains.py " + at + "/p.h5 " +
                          at + "/c.png 2>/dev/null") == 0);
  CHECK(text_of(folder / "c.png").substr(1, 3) == "PNG");
  CHECK(std::filesystem::file_size(folder / "c.png") > 10'000);
}

TEST_CASE("Numbers of a run are listed for a paper, and its figures plotted again") {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "summary.json")
      << R"({"schema": 2, "results": [{"mu": 0.3, "c": {"value": 0.5607, "stderr": 0.0005}, "samples": 3456, "peak_position": 7}],
             "scaling": {"beta": {"value": 2.522, "stderr": 0.05}, "gamma": {"value": null, "stderr": null, "reason": "x"},
                         "alpha": {"value": 1.10437, "stderr": 0.032, "power_law": false}},
             "claims": [{"id": "D-of-mu", "measured": -1.5, "stderr": 0.02}], "figures": [{"id": "b", "title": "Forces of a bead", "height": 3}, {"id": "piles", "title": "Piles"}]})";
  const std::string at = folder.path().string();
  const auto tex = granuscope_command({"numbers", at, "--all"});
  CHECK(tex.code == 0);
  const auto names = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"numbers", at, "--format", "json"}, found;
    words.insert(words.end(), flags.begin(), flags.end());
    const auto list = nlohmann::ordered_json::parse(granuscope_command(words).out);
    for (const auto& [name, number] : list.items()) found.push_back(name);
    return found;
  };
  CHECK(names({}) ==
        std::vector<std::string>{"mu-0.3/c", "beta", "gamma", "alpha", "claims/D-of-mu/measured"});  // no samples
  CHECK(names({"--only", "c,beta"}) == std::vector<std::string>{"mu-0.3/c", "beta"});
  CHECK(names({"--only", "samples"}) == std::vector<std::string>{"mu-0.3/samples"});
  CHECK(names({"--all", "--only", "mu-0.3"}) ==
        std::vector<std::string>{"mu-0.3/mu", "mu-0.3/c", "mu-0.3/samples", "mu-0.3/peak_position"});
  CHECK_THAT(granuscope_command({"numbers", at, "--only", "delta"}).err, Contains("no number has the name delta"));
  CHECK_THAT(granuscope_command({"numbers", at, "--only", "c, delta "}).err, Contains("no number has the name delta;"));
  for (const auto& [wrong, meant] : std::map<std::string, std::string>{{"C", "did you mean c?"},
                                                                       {"mu=0.3/c", "; there are mu-0.3; "},
                                                                       {"mu-0.30/c", "; there are mu-0.3; "},
                                                                       {"mu-0.25/c", "; there are mu-0.3; "},
                                                                       {"x_p", "did you mean peak_position?"}}) {
    CHECK_THAT(granuscope_command({"numbers", at, "--only", wrong}).err, Contains(meant));
  }
  CHECK_THAT(tex.out,
             Contains("\\csname granuscope@\\detokenize{beta}\\endcsname{\\ensuremath{2.522(50)}}") &&
                 Contains("granuscope@\\detokenize{mu-0.3/c}\\endcsname{\\ensuremath{0.56070(50)}}") &&
                 Contains("granuscope@\\detokenize{alpha}\\endcsname{\\ensuremath{1.10}}% no power law\n") &&
                 Contains("granuscope@\\detokenize{mu-0.3/samples}\\endcsname{\\ensuremath{3456}}") &&
                 Contains("granuscope@\\detokenize{claims/D-of-mu/measured}\\endcsname{\\ensuremath{-1.500(20)}}") &&
                 !Contains("detokenize{gamma}") && Contains("\n% gamma is unknown: x\n") && !Contains("height"));
  CHECK_THAT(granuscope_command({"numbers", at, "--format", "csv"}).out,
             StartsWith("name,value,standard_error,text\n") && Contains("beta,2.522,0.05,2.522(50)\n") &&
                 Contains("\ngamma,nan,nan,n/a\n"));
  const auto json = nlohmann::json::parse(granuscope_command({"numbers", at, "--format", "json"}).out);
  CHECK(json.at("beta").at("stderr") == 0.05);
  CHECK(granuscope_command({"numbers", at, "--format", "xml"}).code == 2);
  CHECK(granuscope_command({"numbers", at + "/summary.json", "--format", "CSV"}).out ==
        granuscope_command({"numbers", at, "--format", "csv"}).out);
  CHECK(granuscope_command({"numbers", at + "/nowhere"}).code == 2);
  CHECK(granuscope_command({"figure", at, "beta"}).code == 2);
  CHECK(granuscope_command({"figure", at}).code == 2);
  std::filesystem::create_directories(folder / "figures");
  std::ofstream(folder / "figures/b.gp") << "x";
  std::ofstream(folder / "figures/a.gp") << "x";
  CHECK(granuscope_command({"figure", at}).out ==
        "1  b      Forces of a bead\n2  piles  Piles (a picture: granuscope render)\n3  a\n");
  CHECK_THAT(granuscope_command({"figure", at, "4"}).err, Contains("there is no figure 4") && Contains("1 to 3"));
  for (const char* third : {"3", "fig3", "figure3"})
    CHECK_THAT(granuscope_command({"figure", at, third}).err, Contains("a.json"));
  std::filesystem::copy_file(GRANUSCOPE_SOURCE_DIR "/examples/figures/force-chains.png", folder / "figures/piles.png");
  // The command is computed from what is there, not read from a picture that somebody may have sent.
  CHECK_THAT(granuscope_command({"figure", at, "piles"}).err,
             Contains("piles is a picture of beads") && EndsWith(": the report says how, below it\n"));
  std::filesystem::create_directories(folder / "piles");
  std::ofstream(folder / "piles/piles.h5") << "x";
  CHECK_THAT(granuscope_command({"figure", at, "piles"}).err,
             EndsWith(": granuscope render " + at + "/piles/piles.h5 piles.png --width 86mm\n"));
  std::ofstream(folder / "manifest.json")
      << R"({"stages": ["plot", "report"], "skipped": ["The figure of c is left out: why.", "x"]})";
  CHECK_THAT(granuscope_command({"figure", at, "c-of-mu"}).err,
             EndsWith("there is no plot c-of-mu; The figure of c is left out: why.\n"));
  std::filesystem::remove(folder / "manifest.json");
  CHECK_THAT(granuscope_command({"figure", at, "pile"}).err, Contains("did you mean piles?"));
  CHECK_THAT(granuscope_command({"run", "no-such-folder/quick"}).err,
             Contains("granuscope example quick >quick.toml writes the built-in one"));
  CHECK_THAT(granuscope_command({"figure", at, "beta", "--width", "wide"}).err,
             Contains("write 86mm, 8.6cm or 3.37in"));
  CHECK_THAT(granuscope_command({"figure", at, "beta", "--width", "0mm"}).err, Contains("--width 0mm is no width"));
  CHECK_THAT(granuscope_command({"figure", at, "beta", "--font-size", "8mm"}).err, Contains("write 8pt or 8"));
  CHECK_THAT(granuscope_command({"figure", at, "beta", "--font-size", "8pt"}).err, Contains("there is no plot beta"));
  CHECK(granuscope_command({"numbers", at, "--all", "-o", at + "/numbers.tex"}).out.empty());
  CHECK(text_of(folder / "numbers.tex") == tex.out);
}

TEST_CASE("explain tells what a word means, names the nearest words, and lists all") {
  CHECK_THAT(granuscope_command({"explain", "c_thrust"}).out, StartsWith("c_thrust, ") && Contains("√(κ/3)"));
  CHECK_THAT(granuscope_command({"explain", "Granusolve"}).out, Contains("law") && Contains("Backtrack: "));
  CHECK_THAT(granuscope_command({"explain", "jackknives"}).err, Contains("did you mean jackknife?"));
  CHECK_THAT(granuscope_command({"explain", "N"}).out, StartsWith("N, normal force: "));
  CHECK_THAT(granuscope_command({"explain", "n/a"}).out, StartsWith("n/a, "));
  CHECK_THAT(granuscope_command({"explain", "standard", "errors"}).out, StartsWith("standard error, "));
  const std::string several = granuscope_command({"explain", "D", "block", "jackknife", "not", "decided"}).out;
  CHECK_THAT(several,
             StartsWith("D, ") && Contains("\nblock: ") && Contains("\njackknife: ") && Contains("\nverdict, "));
  CHECK_THAT(granuscope_command({"explain", "block", "zzzzzzzz"}).err, Contains("no word zzzzzzzz"));
  for (const char* word : {"block", "jackknife", "pull", "p", "moved", "primary", "rival", "saturated", "multiplexed",
                           "not decided", "exponent"}) {
    CHECK(granuscope_command({"explain", word}).code == 0);
  }
  CHECK_THAT(granuscope_command({"explain", "pull"}).out, Contains("from the paper's") && Contains("two runs"));
  CHECK(granuscope_command({"explain", "zzzzzzzz"}).code == 2);
  std::set<std::string> names;
  for (const GlossaryEntry& entry : glossary()) {
    CHECK_FALSE(entry.text.ends_with('.'));
    CHECK_THAT(granuscope_command({"explain"}).out, Contains(fmt::format("{}\n", fmt::join(entry.names, ", "))));
    for (const std::string& name : entry.names) names.insert(name);
  }
  CHECK(names.size() > 80);
}

TEST_CASE("A run takes wording from a folder of templates, and a wrong file there is the user's mistake") {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string();
  std::filesystem::create_directories(folder / "words/plot");
  const auto run = [&] {
    const auto result = granuscope_command(
        {"run", GRANUSCOPE_SOURCE_DIR "/examples/quick.toml", "--print-config", "--templates", at + "/words"});
    use_templates({});
    return result;
  };
  CHECK(run().code == 0);
  std::ofstream(folder / "words/plot/no_such.captions") << "x";
  CHECK(run().code == 2);
  CHECK_THAT(run().err, Contains("the program has no template plot/no_such.captions"));
}

TEST_CASE("A run takes page, style sheets and tables from a folder of templates, and makes them anew without it") {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string(), words = at + "/words";
  std::ofstream(folder / "e.toml") << one_plot_text;
  const auto run = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> arguments = {"run", at + "/e.toml", "--out", at + "/out"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const auto result = granuscope_command(arguments);
    use_templates({});
    INFO(result.err);
    REQUIRE(result.code == 0);
    return text_of(folder / "out/report.html");
  };
  const auto add_to = [&](const std::string& name, const std::string& end) {
    std::filesystem::create_directories((folder / ("words/" + name)).parent_path());
    std::ofstream(folder / ("words/" + name)) << template_file(name) << end;
  };
  add_to("screen.css", "\nbody { color: #123456 }\n");
  add_to("print.css", "\n@page { size: 150mm 230mm }\n");
  add_to("report.html.mustache", "<p>Our own last words</p>\n");
  add_to("summary.md.mustache", "\nOur own summary\n");
  std::filesystem::create_directories(folder / "words/tables");
  std::string table(template_file("tables/transport.table"));
  REQUIRE(table.starts_with("caption: "));
  std::ofstream(folder / "words/tables/transport.table") << table.insert(9, "Ours ");
  const std::string ours = run({"--templates", words});
  CHECK_THAT(ours, Contains("body { color: #123456 }") && Contains("Our own last words") && Contains("Ours "));
  CHECK_THAT(text_of(folder / "out/summary.md"), Contains("Our own summary"));
  const std::string french = run({"--templates", GRANUSCOPE_SOURCE_DIR "/templates/fr"});
  CHECK_THAT(french, Contains("Réponse moyenne et profondeur") && Contains("<strong>L’article.</strong>") &&
                         !Contains("Our own"));
  CHECK_THAT(text_of(folder / "out/figures/response-profiles.svg"), Contains("diamètres de bille"));
  const std::string built_in = run({});
  CHECK_THAT(built_in, !Contains("#123456") && !Contains("Our own") && !Contains("Ours "));
  CHECK_THAT(text_of(folder / "out/summary.md"), !Contains("Our own summary"));

  const bool with_pdf = status_of_shell("command -v weasyprint pdfinfo >/dev/null") == 0;
  if (!with_pdf) {
    WARN("no weasyprint or no pdfinfo here: the style sheet of the PDF was not tested");
    return;
  }
  std::ofstream(folder / "e.toml")
      << std::string(one_plot_text).replace(one_plot_text.find("pdf = false"), 11, "pdf = true");
  run({"--templates", words, "--require-pdf"});
  CHECK(status_of_shell("pdfinfo " + at + "/out/report.pdf | grep 'Page size: *425.* x 65[12]' >/dev/null") == 0);
}

TEST_CASE("A machine without OpenGL paints the same picture, and doctor says so") {
  const test::TemporaryFolder folder;
  const std::string render = GRANUSCOPE_BINARY_DIR "/granuscope render " GRANUSCOPE_SOURCE_DIR
                                                   "/tests/data/pictures/point.h5 --width 2400 --image " +
                             (folder / "").string();
  // No Mesa has a driver of this name. Mesa leaks when it finds none, in a module that it then unloads, so that
  // LeakSanitizer cannot be told whose leak it is.
  const std::string without = "env GALLIUM_DRIVER=none-such LIBGL_ALWAYS_SOFTWARE=1 ASAN_OPTIONS=detect_leaks=0 ";
  const std::string said = (folder / "said").string();
  CHECK(status_of_shell(without + render + "auto.png 2>" + said) == 0);
  CHECK_THAT(text_of(said), Contains("without OpenGL") && Contains("GALLIUM_DRIVER"));
  CHECK(status_of_shell(render + "none.png --backend none 2>/dev/null") == 0);
  CHECK((text_of(folder / "auto.png") == text_of(folder / "none.png")));
  CHECK(status_of_shell(without + render + "osmesa.png --backend osmesa 2>/dev/null") == 3);  // asked for by name
  CHECK(status_of_shell(without + GRANUSCOPE_BINARY_DIR "/granuscope doctor >" + said) == 0);
  CHECK_THAT(text_of(said), Contains("the processor paints the same pixels"));
}

TEST_CASE("A flag without a verb is named, with the verbs that have it") {
  CHECK_THAT(granuscope_command({"--dry-run"}).err, Contains("--dry-run stands behind a verb: run"));
  CHECK_THAT(granuscope_command({"--dry-rum=1"}).err,
             Contains("there is no flag --dry-rum=1; did you mean --dry-run of run?"));
}

TEST_CASE("A new experiment has what was asked for, its piles and its time, and writes over nothing", "[unsanitized]") {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "mine.toml").string();
  const auto written =
      granuscope_command({"new", "--mu", "0.2,0.3", "--error-of", "c=0.002", "--layers", "60", "-o", file});
  CHECK(written.code == 0);
  CHECK(written.err == "wrote " + file + "\n");
  const std::string text = text_of(file);
  CHECK_THAT(text, Contains("mine.toml --print-config") && Contains("60 beads, on this machine roughly ") &&
                       Contains("piles, mu = 0.2, for the precision asked"));
  const Experiment experiment = read_experiment(file);
  CHECK(experiment.name == "mine");
  CHECK(experiment.mu == std::vector<double>{0.2, 0.3});
  CHECK(experiment.precision.c == 0.002);
  CHECK(experiment.lattice.layers == 60);
  const auto again = granuscope_command({"new", "-o", file});
  CHECK(again.code == 2);
  CHECK_THAT(again.err, Contains("is there already"));
  CHECK(text_of(file) == text);
  CHECK_THAT(granuscope_command({"new", "--error-of", "x=1"}).err, Contains("write c=0.001 or D=0.01"));
  CHECK_THAT(granuscope_command({"new", "--error-of", "c=much"}).err, Contains("much is not a number"));
  CHECK_THAT(granuscope_command({"new", "--error-of", "c=0,001"}).err, Contains("decimal comma"));
  for (const char* none : {"c=0", "D=-0.01"}) {
    CHECK_THAT(granuscope_command({"new", "--error-of", none}).err, Contains("an error is larger than 0"));
  }
  for (const char* friction : {"0,1", "0,3"})
    CHECK_THAT(granuscope_command({"new", "--mu", friction}).err, Contains("decimal comma"));
  for (const char* friction : {"−0.1", "0,1"})
    CHECK_THAT(granuscope_command({"sample", "--mu", friction}).err, Contains("; write"));
  CHECK_THAT(granuscope_command({"sample", "--mu", "−0.1"}).err, Contains("U+2212"));
  CHECK_THAT(granuscope_command({"new", "--mu", "−0.1"}).err, Contains("U+2212"));
  CHECK_THAT(granuscope_command({"new", "--mu", "0.1;0.2"}).err, Contains("0.1;0.2 is not a number"));
  CHECK(granuscope_command({"new", "--mu", "0.0,1"}).code == 0);
  for (const std::vector<std::string>& friction :
       std::vector<std::vector<std::string>>{{"0.2, 0.3"}, {" 0.2 ,0.3"}, {"0.2", "0.3"}, {"0.2,", "0.3"}}) {
    std::vector<std::string> words = {"new", "--error-of", "c=0.01, D=0.1", "--layers", "40", "--mu"};
    words.insert(words.end(), friction.begin(), friction.end());
    CHECK_THAT(granuscope_command(words).out, Contains("mu = [0.2, 0.3]") && Contains("\nc = 0.01\nD = 0.1\n"));
  }
  CHECK_THAT(granuscope_command({"new", "--mu", "2"}).err, Contains("friction.mu: 2 is out of range"));
  CHECK_THAT(granuscope_command({"new", "--estimator", "points"}).err, Contains("multiplexed"));
  CHECK_THAT(granuscope_command({"new", "--estimator", "paired"}).err, Contains("gives no c and D"));
}

TEST_CASE("A new experiment says where c and D will be unknown, with an error wanted and without", "[unsanitized]") {
  const std::string why = "at layer 39 the fitted width ";
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--error-of", "c=0.01"}}) {
    std::vector<std::string> words = {"new", "--mu", "0.1,0.3", "--layers", "60"};
    words.insert(words.end(), more.begin(), more.end());
    CHECK_THAT(granuscope_command(words).out, Contains(why) && Contains("take more layers"));
  }
  CHECK_THAT(granuscope_command({"new", "--mu", "0.2,0.3", "--layers", "60"}).out, !Contains("unknown"));
}

TEST_CASE("Piles that are there for a precision are said to be there once") {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "e.toml").string(), out = (folder / "out").string();
  REQUIRE(granuscope_command({"new", "--mu", "0.3", "--layers", "60", "--error-of", "c=0.01", "-o", file}).code == 0);
  const std::vector<std::string> run = {"run", file, "--out", out, "--set", "lattice.columns=128"};
  std::vector<std::string> sample = run, plan = run;
  sample.insert(sample.end(), {"--only", "sample", "-q"});
  plan.emplace_back("--dry-run");
  REQUIRE(granuscope_command(sample).code == 0);
  CHECK_THAT(granuscope_command(plan).out, Contains("(by the errors so far) (there already)\n"));
}

TEST_CASE("Each thing that is wrong with a file has a line of its own") {
  const test::TemporaryFolder folder;
  const std::string file = (folder / "mine.toml").string();
  std::ofstream(file) << "[friction]\nmu = 3\n[lattice]\nlayer = 5\n";
  const auto result = granuscope_command({"run", file, "--print-config"});
  CHECK(result.code == 2);
  CHECK_THAT(result.err, StartsWith("granuscope: " + file + ":2:1: friction.mu: 3 is out of range") &&
                             Contains("\ngranuscope: " + file + ":4:1: unknown key lattice.layer"));
}

TEST_CASE("A picture that shows the lowest layers says what they are") {
  const test::TemporaryFolder folder;
  const std::string pile = (folder / "pile.h5").string(), image = (folder / "pile.png").string();
  REQUIRE(granuscope_command({"sample", "--columns", "20", "--layers", "30", "--out", pile}).code == 0);
  CHECK_THAT(granuscope_command({"render", pile, image}).err,
             Contains("the lowest 20 layers follow another law") && Contains("--window=-10,10,0,9 leaves them out"));
  CHECK_THAT(granuscope_command({"render", pile, image, "--window=-10,10,0,9"}).err, !Contains("another law"));
}
