// A finished run as a research object, looked at by another program's eyes.
#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "cli/in_process.h"
#include "kit/file_size_limit.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "report/citation.h"
#include "support/error.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const char* const citation = R"(cff-version: 1.2.0
title: "Piles: a study"
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
assert run['instrument'] == {'@id': '#granuscope'} and run['object'] == {'@id': 'experiment.toml'}
print(root['name'], '|', root['license']['@id'], '|', [graph[one['@id']] for one in root.get('author', [])])
print(run['description'], '|', program['softwareVersion'], '|', len([n for n in names if n.startswith('ensembles/')]))
)";

std::string told_by(const fs::path& archive) {
  ProcessSpec python;
  python.arguments = {"python3", "-c", look, archive.string()};
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
  CHECK_THAT(told, Contains("granuscope run experiment.toml --out . | commit ") && Contains(" | 0\n"));
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
  std::ofstream(scratch / "CITATION.cff") << "license-url: https://example.org/own\nauthors:\n  - name: The group\n";
  REQUIRE(packed(again).code == 0);
  crate = run_process(unzip).standard_output;
  CHECK_THAT(crate, Contains("https://example.org/own") && !Contains("No licence is stated"));

  const auto refused = [&](const std::string& words) {
    const CommandResult result = packed(again);
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Contains(words));
  };
  std::ofstream(scratch / "CITATION.cff") << "title: nobody\n";
  refused("names no authors");
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
  REQUIRE(granuscope_command({"run", (scratch / "small.toml").string(), "--out", out.string(), "--quiet", "--only",
                              "sample", "--set", "sampling.seed=9"})
              .code == 0);
  CHECK_THROWS_WITH(pack_run(out, archive, nobody), Contains("did not come to its end with a report"));
}
