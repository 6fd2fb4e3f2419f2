// Verbs beside the main line.
#include <fcntl.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): SIGKILL
#include <sys/file.h>
#include <unistd.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/in_process.h"
#include "kit/file_size_limit.h"
#include "kit/png_image.h"
#include "kit/search_path.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/run_folder.h"
#include "report/citation.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

// nightly, history and compare as cron and CI meet them.

namespace {

const std::string program = std::string(GRANUSCOPE_BINARY_DIR) + "/granuscope";

std::string write_config(const test::TemporaryFolder& scratch) {
  std::ofstream(scratch / "small.toml") << one_plot_text;
  return (scratch / "small.toml").string();
}

}  // namespace

TEST_CASE("A night says nothing while all is well, alarms with 1, and is told by history") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch), folder = (scratch / "nights").string();
  const auto night = [&](const std::vector<std::string>& more = {}) {
    ProcessSpec spec;
    spec.arguments = {program, "nightly", config, "--history", folder, "-j", "2"};
    spec.arguments.insert(spec.arguments.end(), more.begin(), more.end());
    return run_process(spec);
  };
  const ProcessResult first = night();
  CHECK(first.exit_code == 0);
  CHECK(first.standard_error.empty());
  CHECK(first.standard_output.empty());
  const ProcessResult alarmed = night({"--set", "sampling.seed=77"});
  CHECK(alarmed.exit_code == 1);
  CHECK(alarmed.standard_error.empty());
  CHECK_THAT(alarmed.standard_output, Contains("experiment (open): "));
  CHECK_THAT(read_file(scratch / "nights/alert.md"), Contains("sampling.seed = 77 where 1 was"));

  const CommandResult list = granuscope_command({"history", folder, "list"});
  CHECK(list.code == 0);
  CHECK_THAT(list.out, Contains("1 ") && Contains("fine, 256 samples") && Contains("experiment (open)"));
  const auto shown = nlohmann::json::parse(granuscope_command({"history", folder, "show", "1", "--json"}).out);
  CHECK(shown["nights"][0]["numbers"][0]["name"] == "c at mu = 0");
  CHECK_THAT(granuscope_command({"history", folder, "show", "1"}).out,
             Contains("number") && Contains("c_thrust at mu = 0.3  0.5") && Contains("/report.html"));
  CHECK(nlohmann::json::parse(granuscope_command({"history", folder, "list", "--json"}).out)["nights"].size() == 2);
  const std::string csv = granuscope_command({"history", folder, "export", "--format", "csv"}).out;
  CHECK_THAT(csv, Contains("night,date,status,samples,name,value,stderr") && Contains("c_thrust at mu = 0.3"));
  CHECK(granuscope_command({"history", folder, "accept", "2"}).code == 0);
  CHECK_FALSE(fs::exists(scratch / "nights/alert.md"));
  CHECK(granuscope_command({"history", folder, "forget", "2"}).code == 0);
  CHECK(granuscope_command({"history", folder, "show", "2"}).code == 2);
  CHECK(granuscope_command({"history", folder, "show"}).code == 2);
  CHECK_THAT(granuscope_command({"history", scratch.path().string(), "list"}).err,
             Contains("no history in this folder"));

  const int lock = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  REQUIRE(::flock(lock, LOCK_EX | LOCK_NB) == 0);
  const ProcessResult busy = night();
  CHECK(busy.exit_code == 5);
  CHECK_THAT(busy.standard_error, Contains("choose another folder"));
  CHECK(granuscope_command({"history", folder, "forget", "1"}).code == 5);
  ::close(lock);
  CHECK(night({"--grow", "0"}).exit_code == 2);
  const CommandResult run = granuscope_command({"run", config, "--out", folder});
  CHECK(run.code == 2);
  CHECK_THAT(run.err, Contains("belongs to a history"));
}

TEST_CASE("A night without gnuplot has its numbers, and ends with 3") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch), folder = (scratch / "nights").string();
  const test::SearchPath none((scratch / "no-programs").string());
  const CommandResult night = granuscope_command({"nightly", config, "--history", folder, "--grow", "10", "--verbose"});
  CHECK(night.code == 3);
  CHECK_THAT(night.out, Contains("report (open): ") && Contains("gnuplot is not found in PATH"));
  CHECK_THAT(night.err, Contains("--grow 10 is rounded up to 256"));
  CHECK_THAT(granuscope_command({"history", folder, "show", "1"}).out, Contains("c at mu = 0.3"));
}

TEST_CASE("A night that is killed is gone on with by the next one, to the same pool", "[long]") {
  const test::TemporaryFolder killed, whole;
  const auto night = [&](const test::TemporaryFolder& scratch) {
    ProcessSpec spec;
    spec.arguments = {program, "nightly", write_config(scratch), "--history", (scratch / "nights").string()};
    return run_process(spec).exit_code;
  };
  REQUIRE(night(whole) == 0);
  REQUIRE(night(whole) == 0);
  for (int n = 0; n < 2; ++n) {
    {
      // While the figure of the pool is plotted, when the pool's ensembles have grown.
      const test::FakePrograms programs(killed / "programs");
      programs.only("gnuplot", "kill -KILL $PPID");
      REQUIRE(night(killed) == 128 + SIGKILL);
    }
    const std::string listed = granuscope_command({"history", (killed / "nights").string(), "list"}).out;
    CHECK(std::count(listed.begin(), listed.end(), '\n') == n);
    REQUIRE(night(killed) == 0);
  }
  for (const char* file : {"summary.json", "ensembles/mu-0.3.h5", "figures/response-profiles.svg"}) {
    INFO(file);
    CHECK((read_file(killed / "nights/pool" / file) == read_file(whole / "nights/pool" / file)));
  }
  const auto numbers = [](const test::TemporaryFolder& scratch) {
    auto json = nlohmann::json::parse(
        granuscope_command({"history", (scratch / "nights").string(), "show", "2", "--json"}).out);
    return json["nights"][0]["numbers"];
  };
  CHECK(numbers(killed) == numbers(whole));
}

TEST_CASE("compare answers in one line and, as a gate, by its status") {
  const test::TemporaryFolder scratch;
  const std::string config = write_config(scratch);
  const auto run = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", config, "--quiet", "--out", (scratch / name).string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    REQUIRE(granuscope_command(arguments).code == 0);
    return (scratch / name).string();
  };
  const std::string one = run("one", {}), two = run("two", {"-j", "1"});
  const std::string seed = run("seed", {"--set", "sampling.seed=5"}),
                    wide = run("wide", {"--set", "lattice.columns=62"});
  CommandResult result = granuscope_command({"compare", one, two, "--gate"});
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Matchers::StartsWith("same: every value and error is equal"));
  result = granuscope_command({"compare", one, seed, "--gate", "--json", (scratch / "a.json").string()});
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Matchers::StartsWith("same experiment but for sampling.seed = 5 where 1 was"));
  CHECK(nlohmann::json::parse(read_file(scratch / "a.json"))["likeness"] == "other samples");
  CHECK(granuscope_command({"compare", one, wide}).code == 0);
  result = granuscope_command({"compare", one, wide, "--gate"});
  CHECK(result.code == 1);
  CHECK_THAT(result.out, Contains("other experiments: lattice.columns = 62 where 60 was"));
  CHECK(granuscope_command({"compare", one, (scratch / "none").string()}).code == 2);
}

// A finished run as a research object, looked at by another program's eyes.

namespace {

const char* const citation = R"(cff-version: 1.2.0
title: "Piles: a study"
type: dataset
license: CC-BY-4.0
doi: 10.1234/piles.5
authors:
  - family-names: Müller
    given-names: Ada
    orcid: https://orcid.org/0000-0001-2345-6789
    affiliation: >-
      Institute of
      Sand
  - name: The pile group
)";

/// What RO-Crate 1.1 demands of the archive, and that each file is what the crate says; prints what a reader wants.
const char* const look = R"(
import hashlib, json, sys, zipfile
archive = zipfile.ZipFile(sys.argv[1])
assert archive.testzip() is None
names = archive.namelist()
crate = json.loads(archive.read('ro-crate-metadata.json'))
assert crate['@context'][0] == 'https://w3id.org/ro/crate/1.1/context'
graph = {one['@id']: one for one in crate['@graph']}
assert len(graph) == len(crate['@graph'])
descriptor = graph['ro-crate-metadata.json']
assert descriptor['@type'] == 'CreativeWork' and descriptor['about'] == {'@id': './'}
assert descriptor['conformsTo'] == {'@id': 'https://w3id.org/ro/crate/1.1'}
root = graph['./']
for key in ('name', 'description', 'datePublished', 'license'): assert root[key], key
parts = [one['@id'] for one in root['hasPart']]
assert sorted(parts + ['ro-crate-metadata.json']) == sorted(names)
for part in parts:
    data = archive.read(part)
    assert graph[part]['@type'] == 'File' and graph[part]['contentSize'] == str(len(data)), part
    assert graph[part]['sha256'] == hashlib.sha256(data).hexdigest(), part
def referred(value):
    if isinstance(value, dict):
        if set(value) == {'@id'}: yield value['@id']
        for one in value.values(): yield from referred(one)
    if isinstance(value, list):
        for one in value: yield from referred(one)
for id in referred(crate['@graph']): assert id in graph or id.startswith('https://w3id.org/'), id
run, program = graph['#run'], graph['#granuscope']
assert run['instrument'] == {'@id': '#granuscope'} and run['object'] == [{'@id': 'experiment.toml'}]
# Process Run Crate 0.5
assert root['conformsTo'] == {'@id': 'https://w3id.org/ro/wfrun/process/0.5'}
assert graph[root['conformsTo']['@id']]['version'] == '0.5'
assert run['@type'] == 'CreateAction' and run['actionStatus'] == 'http://schema.org/CompletedActionStatus'
import datetime
started, ended = (datetime.datetime.fromisoformat(run[key]) for key in ('startTime', 'endTime'))
assert started <= ended and started.utcoffset() == datetime.timedelta(0)
assert all('encodingFormat' in graph[part] for part in parts)
assert run.get('agent') == root.get('author')
assert ('version' in program) + ('softwareVersion' in program) == 1
# The same rules for the graph that a reader of JSON-LD makes of it, with the terms of RO-Crate's context that it uses.
try:
    import rdflib
except ImportError:
    print('without rdflib')
else:
    terms = {key: 'http://schema.org/' + key for key in (
        'about actionStatus affiliation agent author contentSize CreateAction CreativeWork Dataset datePublished '
        'description encodingFormat endTime familyName givenName hasPart identifier instrument license mentions name '
        'object Organization Person result SoftwareApplication softwareRequirements softwareVersion startTime version').split()}
    terms.update(File='http://schema.org/MediaObject', conformsTo='http://purl.org/dc/terms/conformsTo',
                 sha256=crate['@context'][1]['sha256'])
    read = rdflib.Graph().parse(data=json.dumps({'@context': terms, '@graph': crate['@graph']}), format='json-ld',
                                publicID='http://crate.example/')
    told = sum(len(value) if isinstance(value, list) else 1
               for one in crate['@graph'] for key, value in one.items() if key != '@id')
    assert len(read) == told, (len(read), told)  # no key without a meaning, no value that is lost
    ask = lambda what: read.query('PREFIX s: <http://schema.org/> PREFIX d: <http://purl.org/dc/terms/> ' + what)
    assert ask('ASK { <http://crate.example/> d:conformsTo ?p ; s:mentions ?run . ?p a s:CreativeWork . '
               'FILTER STRSTARTS(STR(?p), "https://w3id.org/ro/wfrun/process/") . '
               '?run a s:CreateAction ; s:instrument ?program . ?program a s:SoftwareApplication }').askAnswer
    for broken in ('?run s:object|s:result ?what . FILTER NOT EXISTS { ?what a s:MediaObject }',
                   '?run s:agent ?who . FILTER NOT EXISTS { ?who a ?kind . FILTER (?kind IN (s:Person, s:Organization)) }',
                   '<http://crate.example/> s:hasPart ?file . FILTER NOT EXISTS { ?file a s:MediaObject ; s:name ?name }'):
        assert not ask('ASK { ' + broken + ' }').askAnswer, broken
# What the specification 1.0 of codecheck.yml, and the register's rules on it, ask of who submits: it names each figure
# once, with its data, and all of it is there. A checker and a report come later; in their place stands nothing.
import yaml
codecheck = archive.read('codecheck.yml').decode()
assert codecheck.startswith('---\n') and not any(word in codecheck for word in ('FIXME', 'TODO', 'XXXX'))
checked = yaml.safe_load(codecheck)
assert set(checked) == {'version', 'paper', 'source', 'manifest'}
assert checked['version'] == 'https://codecheck.org.uk/spec/config/1.0/'
for later in ('codechecker', 'report', 'summary', 'check_time', 'certificate'): assert later in codecheck.split('# To be added')[1]
paper = checked['paper']
assert paper['title'] and paper['reference'] and program['identifier'] in checked['source']
assert ('authors' in paper) == ('author' in root) == ('paper.authors' not in codecheck)
for author in paper.get('authors', []):
    assert author['name']
    total = 0
    for digit in author.get('ORCID', '').replace('-', '')[:-1]: total = (total + int(digit)) * 2
    assert 'ORCID' not in author or author['ORCID'][-1] == '0123456789X'[(12 - total % 11) % 11], author
named = [one['file'] for one in checked['manifest']]
assert all(one['comment'] for one in checked['manifest'])
assert set(named) <= set(names) and len(named) == len(set(named)), named
figures = {name.rsplit('.', 1)[0] for name in names if name.startswith('figures/') and not name.endswith('-narrow.svg')
           and name.endswith(('.svg', '.png'))}
assert all(any(one.startswith(figure + '.') for one in named) for figure in figures), (figures, named)
assert {name for name in names if name.endswith('.csv')} <= set(named) and 'summary.json' in named
print(root['name'], '|', root['license']['@id'], '|', [graph[one['@id']] for one in root.get('author', [])])
print(paper['title'], '|', paper['reference'])
print(run['description'], '|', program['softwareVersion'], '|', len([n for n in names if n.startswith('ensembles/')]))
)";

std::string told_by(const fs::path& archive) {
  ProcessSpec python;
  python.arguments = {"/usr/bin/python3", "-c", look, archive.string()};
  python.environment = {{"PYTHONUTF8", "1"}};
  const ProcessResult result = run_process(python);
  INFO(result.standard_error);
  CHECK(result.exit_code == 0);
  return result.standard_output;
}

fs::path finished_run(const test::TemporaryFolder& scratch) {
  std::ofstream(scratch / "small.toml") << one_plot_text;
  const fs::path out = scratch / "out";
  REQUIRE(granuscope_command({"run", (scratch / "small.toml").string(), "--out", out.string(), "--quiet"}).code == 0);
  return out;
}

}  // namespace

TEST_CASE("A packed run is a research object: hashes, authors, licence, command and commit, the same bytes each time") {
  const test::TemporaryFolder scratch;
  const fs::path out = finished_run(scratch), archive = scratch / "run.zip", again = scratch / "again.zip";
  std::ofstream(scratch / "CITATION.cff") << citation;
  std::vector<std::string> pack = {"pack", out.string(), "--citation", (scratch / "CITATION.cff").string(), "--out"};
  const auto packed = [&](const fs::path& target, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = pack;
    arguments.push_back(target.string());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return granuscope_command(arguments);
  };
  REQUIRE(packed(archive).code == 0);
  const std::string told = told_by(archive);
  CHECK_THAT(told, Contains("Piles: a study: results of the experiment small | https://spdx.org/licenses/CC-BY-4.0"));
  CHECK_THAT(told, Contains("'givenName': 'Ada', 'familyName': 'Müller', 'affiliation': 'Institute of Sand'"));
  CHECK_THAT(told, Contains("'@id': 'https://orcid.org/0000-0001-2345-6789', '@type': 'Person', 'name': 'Ada Müller'"));
  CHECK_THAT(told, Contains("'@type': 'Organization', 'name': 'The pile group'"));
  CHECK_THAT(told, Contains("Piles: a study | https://doi.org/10.1234/piles.5"));
  if (told.find("without rdflib") != std::string::npos) WARN("without python3-rdflib the crate is not read as JSON-LD");
  CHECK_THAT(told, Contains("granuscope run experiment.toml --out . | 0.1.0 (commit ") && Contains(" | 0\n"));
  REQUIRE(packed(again).code == 0);
  CHECK((read_file(archive) == read_file(again)));
  REQUIRE(packed(again, {"--with-ensembles"}).code == 0);
  CHECK_THAT(told_by(again), Contains(" | 2\n"));

  // What else Citation File Format 1.2 allows.
  std::ofstream(scratch / "CITATION.cff") << "license:\n  - MIT\n  - Apache-2.0\nauthors:\n  - alias: carol\n"
                                             "  - given-names: Ada\n    orcid: 0000-0001-2345-6789\n";
  REQUIRE(packed(again).code == 0);
  ProcessSpec unzip;
  unzip.arguments = {"python3", "-c",
                     "import sys, zipfile; print(zipfile.ZipFile(sys.argv[1]).read('ro-crate-metadata.json').decode())",
                     again.string()};
  unzip.environment = {{"PYTHONUTF8", "1"}};
  std::string crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("licenses/MIT") && Contains("licenses/Apache-2.0") && !Contains("No licence is stated") &&
                        Contains("\"carol\"") && Contains("https://orcid.org/0000-0001-2345-6789"));
  // An ORCID as a link with more, or none at all.
  std::ofstream(scratch / "CITATION.cff")
      << "authors:\n  - alias: carol\n    orcid: https://orcid.org/0000-0001-2345-6789/\n"
         "  - alias: dora\n    orcid: 0000-0001\n";
  REQUIRE(packed(again).code == 0);
  crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("\"https://orcid.org/0000-0001-2345-6789\"") && Contains("\"#author-2\""));
  std::ofstream(scratch / "CITATION.cff") << "authors:\n  - family-names: M\xFCller\n";
  CHECK_THAT(packed(again).err, Contains("not in UTF-8"));
  // What is no name of SPDX has no page there.
  std::ofstream(scratch / "CITATION.cff") << "license: My own terms\nauthors:\n  - alias: carol\n";
  REQUIRE(packed(again).code == 0);
  crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("\"My own terms\"") && Contains("\"#licence-1\"") && !Contains("spdx.org"));
  // Persons by what they have, a number of the archive among several, a link for a DOI, an empty licence.
  std::ofstream(scratch / "CITATION.cff")
      << "type: dataset\nlicense: \"\"\nidentifiers:\n  - type: swh\n    value: swh:1\n"
         "  - type: doi\n    value: https://doi.org/10.5281/zenodo.1\nauthors:\n"
         "  - email: dora@example.org\n    orcid: \"javascript:alert(1)\"\n  - family-names: Davis\n"
         "    given-names: Sammy\n    name-suffix: Jr.\n  - alias: carol\n";
  REQUIRE(packed(again).code == 0);
  crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("\"https://doi.org/10.5281/zenodo.1\"") && Contains("No licence is stated") &&
                        Contains("\"dora@example.org\"") && Contains("\"Sammy Davis Jr.\"") &&
                        !Contains("\"Organization\"") && !Contains("licenses/\"") && !Contains("javascript"));
  // A program's citation names neither a run nor a paper; without a type it is a program's.
  std::ofstream(scratch / "CITATION.cff") << "license-url: https://example.org/own\ntitle: A program\n"
                                             "doi: 10.1234/program\nauthors:\n  - name: The group\n";
  REQUIRE(packed(again).code == 0);
  CHECK_THAT(told_by(again), Catch::Matchers::StartsWith("Results of the experiment small |"));
  CHECK_THAT(
      told_by(again),
      Contains("Re] Stress response function of a two-dimensional ordered packing of frictional beads "
               "(experiment small) | Replication of L. Breton, P. Claudin, É. Clément and J.-D. Zucker, Europhys. "
               "Lett. 60, 813 (2002)"));
  crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("https://example.org/own") && !Contains("No licence is stated"));

  // Sources are those of the commit that made the run, or none.
  const CommandResult elsewhere = packed(again, {"--with-sources", scratch.path().string()});
  CHECK(elsewhere.code == 2);
  CHECK_THAT(elsewhere.err, Contains("git finds no commit"));
  const std::string commit = nlohmann::json::parse(read_file(out / "manifest.json"))["provenance"]["git_commit"];
  ProcessSpec known;
  known.arguments = {"git", "-C", GRANUSCOPE_SOURCE_DIR, "cat-file", "-e", commit};
  if (run_process(known).exit_code == 0) {
    // What a received clone has set runs no command.
    const fs::path clone = scratch / "clone", ran = scratch / "ran";
    const auto git = [&](std::vector<std::string> words) {
      words.insert(words.begin(), "git");
      ProcessSpec process;
      process.arguments = words;
      REQUIRE(run_process(process).exit_code == 0);
    };
    git({"clone", "--quiet", "--shared", "--no-checkout", GRANUSCOPE_SOURCE_DIR, clone.string()});
    const std::string touch = "touch " + ran.string() + "; cat";
    for (const char* key : {"tar.tar.gz.command", "filter.x.smudge", "core.fsmonitor"})
      git({"-C", clone.string(), "config", key, touch});
    write_file(clone / ".git/info/attributes", "* filter=x\n");
    REQUIRE(packed(again, {"--with-sources", clone.string()}).code == 0);
    CHECK_FALSE(fs::exists(ran));
    REQUIRE(packed(again, {"--with-sources", GRANUSCOPE_SOURCE_DIR}).code == 0);
    (void)told_by(again);
    ProcessSpec list;
    list.arguments = {"python3", "-c",
                      "import io, sys, tarfile, zipfile; print(tarfile.open(fileobj=io.BytesIO(zipfile.ZipFile("
                      "sys.argv[1]).read('sources.tar.gz'))).getnames())",
                      again.string()};
    CHECK_THAT(run_process(list).standard_output,
               Contains("granuscope-" + commit.substr(0, 12) + "/src/pages/report/citation.cc"));
  } else {
    WARN("the program's commit is not in the repository: no sources were packed");
  }

  const auto refused = [&](const std::string& words) {
    const CommandResult result = packed(again);
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(words));
  };
  std::ofstream(scratch / "CITATION.cff") << "title: nobody\n";
  refused("names no authors");
  std::ofstream(scratch / "CITATION.cff") << "authors:\n  - alias: carol\n  - tel: \"12\"\n";
  refused("author 2 has neither name nor alias");
  std::ofstream(scratch / "CITATION.cff") << "license: {name: MIT}\nauthors:\n  - alias: carol\n";
  refused("licence is neither a name nor a list");
  // Whom the archive names is told: the citation that lies here may be that of the program.
  std::ofstream(scratch / "CITATION.cff")
      << "license: [MIT, CC0-1.0]\nauthors:\n  - alias: carol\n    orcid: https://orcid.org/0000-0001-2345-6789\n"
         "  - alias: dora\n    orcid: https://orcid.org/0000-0001-2345-6789\n";
  CHECK_THAT(packed(again).err, Contains("it names carol and others, MIT or CC0-1.0"));
  CHECK_THAT(run_process(unzip).standard_output, Contains("\"dora\"") && Contains("#author-2"));
  std::ofstream(scratch / "CITATION.cff") << "authors: [\n";
  refused("this is no YAML");
  std::ofstream(scratch / "CITATION.cff") << citation;
  const std::string summary = read_file(out / "summary.md");
  write_file(out / "summary.md", summary + "edited");
  refused("summary.md has changed");
  fs::remove(out / "summary.md");
  refused("summary.md is missing");
  // What a link points to, or a path leads to, is not packed, even if it is what the manifest tells of.
  write_file(scratch / "secret", summary);
  fs::create_symlink(scratch / "secret", out / "summary.md");
  refused("summary.md leads out of the folder");
  fs::remove(out / "summary.md");
  const std::string manifest = read_file(out / "manifest.json");
  for (const std::string& path :
       {std::string("../secret"), (scratch / "secret").string(), std::string("figures/../../secret")}) {
    std::string forged = manifest;
    forged.replace(forged.find("\"summary.md\""), 12, "\"" + path + "\"");
    write_file(out / "manifest.json", forged);
    refused(path + " leads out of the folder");
  }
  fs::rename(out / "manifest.json", scratch / "manifest.json");
  fs::create_symlink(scratch / "manifest.json", out / "manifest.json");
  refused("manifest.json is a link");
  fs::remove(out / "manifest.json");
  refused("no manifest.json");
  CHECK((read_file(archive) != read_file(again)));  // what was there is not lost by what is refused
}

TEST_CASE("An article has title, numbers and figures of its run, and LaTeX sets it") {
  const test::TemporaryFolder scratch;
  const fs::path out = finished_run(scratch), target = scratch / "article";
  write_file(scratch / "CITATION.cff",
             "authors:\n  - name: \"A & B_C: \\\"50%\\\" 漢\"\n    orcid: 0000-0001-2345-6789\n");
  const auto article = [&] {
    return granuscope_command(
        {"article", out.string(), "-o", target.string(), "--citation", (scratch / "CITATION.cff").string()});
  };
  {
    const test::FileSizeLimit full(10'000);
    CHECK(article().code == 3);
  }
  CHECK_FALSE(fs::exists(target));  // whole or not at all
  const CommandResult written = article();
  INFO(written.err);
  REQUIRE(written.code == 0);
  CHECK(article().code == 2);  // the folder has files by now
  const auto summary = nlohmann::json::parse(read_file(out / "summary.json"));
  bool failed = false;
  for (const auto& claim : summary["claims"]) {
    failed = failed || (claim["verdict"] == "not reproduced" && claim["beyond_paper"] == false);
  }
  const std::string metadata = read_file(target / "metadata.yaml"), content = read_file(target / "content.tex");
  CHECK_THAT(content, Contains("They follow the law granusolve, and the estimator point measures the response"));
  CHECK_THAT(metadata, Contains(failed ? "title: \"[¬Re] Stress" : "title: \"[Re] Stress"));
  // What a codechecker is to look at has the same title.
  const std::string archive = (scratch / "run.zip").string();
  REQUIRE(granuscope_command({"pack", out.string(), "-o", archive}).code == 0);
  ProcessSpec unzip;
  unzip.arguments = {"python3", "-c",
                     "import sys, zipfile; print(zipfile.ZipFile(sys.argv[1]).read('codecheck.yml').decode())",
                     archive};
  unzip.environment = {{"PYTHONUTF8", "1"}};
  CHECK_THAT(run_process(unzip).standard_output, Contains(failed ? "[¬Re] Stress" : "[Re] Stress"));
  CHECK_THAT(metadata, Contains("name: \"A & B_C: \\\"50%\\\" 漢\"") && Contains("orcid: \"0000-0001-2345-6789\""));
  for (const auto& figure : summary["figures"]) {
    CHECK_THAT(content, Contains("{figures/" + figure["id"].get<std::string>() + "."));
  }
  for (const auto& claim : summary["claims"]) {
    if (!claim["measured"].is_null()) {
      CHECK_THAT(content, Contains("\\granuscope{claims/" + claim["id"].get<std::string>() + "/measured}"));
    }
  }
  ProcessSpec latex;
  latex.arguments = {"pdflatex", "-interaction=nonstopmode", "-halt-on-error", "article.tex"};
  latex.working_folder = target;
  if (!find_program("pdflatex")) {
    WARN("no pdflatex here: the article was not set");
    return;
  }
  for (int pass = 0; pass < 2; ++pass) {
    const ProcessResult set = run_process(latex);
    INFO(set.standard_output);
    REQUIRE(set.exit_code == 0);
    if (pass == 1) CHECK_THAT(set.standard_output, !Contains("undefined"));
  }
  CHECK(fs::file_size(target / "article.pdf") > 20'000);
}

TEST_CASE("No article replicates the paper by another model") {
  const test::TemporaryFolder scratch;
  write_file(scratch / "q.toml",
             "[model]\nname = \"q-model\"\n[lattice]\ncolumns = 40\nlayers = 30\n[response]\nsamples = 256\n"
             "[scenes.force_chains]\nshow = false\n[report]\npdf = false\n");
  const std::string out = (scratch / "out").string();
  REQUIRE(granuscope_command({"run", (scratch / "q.toml").string(), "--out", out, "--quiet"}).code == 0);
  const CommandResult refused = granuscope_command({"article", out, "--out", (scratch / "article").string()});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("this run is of the model q-model"));
  CHECK_FALSE(fs::exists(scratch / "article"));
}

TEST_CASE("An archive appears whole or not at all") {
  const test::TemporaryFolder scratch;
  std::string bytes(200'000, 'x');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>((i * i * 2654435761U) >> 13U);
  {
    const test::FileSizeLimit full(8192);
    CHECK_THROWS_AS(write_zip(scratch / "a.zip", {{"a", "", bytes}}, "2026-01-31T02:00:00Z"), EnvironmentError);
  }
  CHECK_THROWS_AS(write_zip(scratch / "a.zip", {{"a", scratch / "none", ""}}, "2026-01-31T02:00:00Z"),
                  EnvironmentError);
  CHECK(fs::is_empty(scratch.path()));
  write_zip(scratch / "a.zip", {{"a", "", bytes}}, "2026-01-31T02:00:00Z");
  CHECK(fs::file_size(scratch / "a.zip") > 8192);
}

TEST_CASE("A run that came to no report is not packed, and without CITATION.cff nobody is named") {
  const test::TemporaryFolder scratch;
  const fs::path out = finished_run(scratch), archive = scratch / "run.zip";
  PackOptions nobody;
  CHECK(pack_run(out, archive, nobody) > 5);
  CHECK_THAT(told_by(archive), Contains("Results of the experiment small | #licence | []"));
  const fs::path bare = scratch / "bare";
  std::vector<std::string> without_figures{"run", (scratch / "small.toml").string(), "--out", bare.string(), "--quiet"};
  for (const char* one : {"figures.bead_forces", "figures.response_profiles", "figures.transport_with_depth",
                          "figures.propagation_against_diffusion", "figures.propagation_and_thrust",
                          "figures.scaling_with_friction", "scenes.force_chains", "scenes.response_field"}) {
    without_figures.insert(without_figures.end(), {"--set", std::string(one) + ".show=false"});
  }
  REQUIRE(granuscope_command(without_figures).code == 0);
  CHECK_FALSE(fs::exists(bare / "figures"));
  CHECK(granuscope_command({"figure", bare.string()}).code == 0);
  CHECK(pack_run(bare, scratch / "bare.zip", nobody) > 3);
  REQUIRE(granuscope_command({"run", (scratch / "small.toml").string(), "--out", out.string(), "--quiet", "--only",
                              "sample", "--set", "sampling.seed=9"})
              .code == 0);
  CHECK_THROWS_WITH(pack_run(out, archive, nobody), Contains("did not come to its report"));
  const std::string run = out.string();
  const std::vector<std::vector<std::string>> readers = {
      {"numbers", run}, {"figure", run}, {"compare", run, run}, {"article", run, "-o", (scratch / "new").string()}};
  for (const int code : {5, 2}) {  // at work, and stopped
    const auto at_work = code == 5 ? std::make_unique<RunFolder>(out) : nullptr;
    for (const auto& one : readers) {
      INFO(one.front());
      CHECK(granuscope_command(one).code == code);
    }
    if (code == 5) CHECK_THROWS_AS(pack_run(out, archive, nobody), BusyError);
  }
}

// A film of a window that slides down a pile.

TEST_CASE("A film slides down a pile: frames of one size, the same bytes for every number of threads") {
  const test::TemporaryFolder folder;
  const std::string at = folder.path().string(), pile = at + "/pile.h5";
  REQUIRE(
      granuscope_command({"sample", "--mu", "0.3", "--columns", "24", "--layers", "40", "--load", "point", "-o", pile})
          .code == 0);
  const auto film = [&](const std::string& to, std::vector<std::string> flags) {
    std::vector<std::string> arguments = {"render", pile, "--film", at + "/" + to, "--dpi", "60"};
    if (std::ranges::find(flags, "--height") == flags.end()) arguments.insert(arguments.end(), {"--height", "270"});
    if (flags[0] != "--width") arguments.insert(arguments.end(), {"--width", "480"});
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    return granuscope_command(arguments);
  };
  const auto one = film("one", {"-j", "1"});
  INFO(one.err);
  REQUIRE(one.code == 0);
  REQUIRE(film("two", {"-j", "2"}).code == 0);
  std::size_t frames = 0;
  std::string before;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "one")) {
    const std::string bytes = read_file(entry.path());
    CHECK((bytes == read_file(folder / "two" / entry.path().filename())));
    const Image image = test::read_png(entry.path());
    CHECK(image.width == 480);
    CHECK(image.height == 270);
    CHECK((bytes != before));
    before = bytes;
    ++frames;
  }
  CHECK(frames > 20);
  CHECK(one.err.find("pad=") == std::string::npos);
  const auto odd = film("it's 5%", {"--width", "481", "--step", "10"});
  CHECK_THAT(odd.err, Contains("it'\\''s 5%%/frame-%05d.png' -vf 'pad="));
  CHECK_THAT(one.err, Contains("wrote " + std::to_string(frames) + " frames of") &&
                          Contains("the lowest 20 layers follow another law"));
  {
    const test::SearchPath none((folder / "no-programs").string());
    CHECK_THAT(film("three", {"--step", "10"}).err, Contains("a video of them takes ffmpeg, which is not here:"));
  }

  // The frame is in one place from the first to the last, whatever numbers stand beside it: nothing but white above it,
  // and its corner where both have it.
  const Image first = test::read_png(folder / "one/frame-00000.png");
  const Image last = test::read_png(folder / ("one/frame-000" + std::to_string(frames - 1) + ".png"));
  const auto corner = [](const Image& image) {
    for (int y = 0; y < image.height; ++y) {
      int dark = 0;
      for (int x = 0; x < image.width; ++x) dark += image.at(x, y).r < 200 ? 1 : 0;
      if (dark > image.width / 2) return y;
    }
    return -1;
  };
  CHECK(corner(first) > 0);
  CHECK(corner(first) == corner(last));

  const auto shorter = film("one", {"--step", "2"});
  CHECK(shorter.code == 2);
  CHECK_THAT(shorter.err, Contains("this is a frame of another film"));
  const auto shallow = film("none", {"--window=-12,12,0,5"});
  CHECK(shallow.code == 2);
  CHECK_THAT(shallow.err, Contains("nothing is left to slide over"));
  CHECK(film("none", {"--height", "40"}).code == 2);
  // Whatever room the numbers beside a frame take, it has the height that was asked for.
  for (const int height : {200, 240, 279}) {
    const std::string to = "high" + std::to_string(height);
    REQUIRE(film(to, {"--step", "30", "--height", std::to_string(height)}).code == 0);
    CHECK(test::read_png(folder / to / "frame-00000.png").height == height);
  }
  CHECK(film("none", {"--step", "0"}).code == 2);
  CHECK(film("none", {"--image", at + "/a.png"}).code == 2);
  CHECK_FALSE(std::filesystem::exists(folder / "none"));
}
