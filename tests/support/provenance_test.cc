#include "support/provenance.h"

#include <catch2/catch.hpp>
#include <set>

#include "kit/temporary_folder.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using granuscope::test::TemporaryFolder;

namespace {

using Catch::Matchers::Contains;

/// The text with each run of digits as '1': "12.2.0" becomes "1.1.1". (No <regex>: g++ 12 warns inside it when
/// sanitizers are on.)
std::string pattern_of(const std::string& text) {
  std::string pattern;
  for (const char letter : text) {
    const bool digit = letter >= '0' && letter <= '9';
    if (!digit) pattern += letter;
    if (digit && (pattern.empty() || pattern.back() != '1')) pattern += '1';
  }
  return pattern;
}

bool is_commit(const std::string& text) {
  return text.size() >= 40 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

/// Whether a word of the text is an absolute path.
bool holds_path(const std::string& text) {
  for (const char* start : {" /", "=/", "I/", "L/"}) {
    if (text.find(start) != std::string::npos) return true;
  }
  return !text.empty() && text.front() == '/';
}

/// What cmake/git_state.cmake writes for a source folder.
std::string git_state_of(const std::filesystem::path& source) {
  const TemporaryFolder folder;
  ProcessSpec spec;
  const std::string script = std::string(GRANUSCOPE_SOURCE_DIR) + "/cmake/git_state.cmake";
  const std::string output = folder / "git_state.h";
  spec.arguments = {"cmake", "-DSOURCE_DIR=" + source.string(), "-DOUTPUT=" + output, "-P", script};
  const ProcessResult result = run_process(spec);
  INFO(result.standard_error);
  REQUIRE(result.exit_code == 0);
  return read_file(folder / "git_state.h");
}

void git(const std::filesystem::path& folder, std::vector<std::string> arguments) {
  ProcessSpec spec;
  spec.arguments = {"git", "-c", "user.name=n", "-c", "user.email=e@example.org", "-C", folder.string()};
  spec.arguments.insert(spec.arguments.end(), arguments.begin(), arguments.end());
  const ProcessResult result = run_process(spec);
  INFO(result.standard_error);
  REQUIRE(result.exit_code == 0);
}

}  // namespace

TEST_CASE("provenance knows the program, its build and its machine") {
  const Provenance provenance = collect_provenance();
  CHECK(pattern_of(provenance.program_version) == "granuscope 1.1.1");
  CHECK((provenance.git_commit == "unknown" || is_commit(provenance.git_commit)));
  CHECK_THAT(pattern_of(provenance.compiler), Contains(" 1.1"));
  CHECK_THAT(provenance.compiler_flags, Contains("-ffp-contract=off") && Contains("-std=c++20"));
  CHECK_FALSE(provenance.build_type.empty());
  CHECK_FALSE(provenance.host_cpu.empty());
  CHECK_THAT(provenance.operating_system, Contains("Linux"));
  CHECK(provenance.hardware_threads >= 1);

  std::set<std::string> names;
  for (const auto& [name, version] : provenance.libraries) {
    CHECK_THAT(pattern_of(version), Catch::StartsWith("1.1"));
    names.insert(name);
  }
  CHECK(names.size() == provenance.libraries.size());
  for (const char* name : {"Eigen", "GLPK", "GSL", "HDF5", "libpng", "FreeType", "fmt", "Highway", "OpenSSL"}) {
    CHECK(names.count(name) == 1);
  }
}

TEST_CASE("nothing baked in is a path of the building machine") {
  const Provenance provenance = collect_provenance();
  CHECK_FALSE(holds_path(provenance.compiler_flags));
  CHECK_FALSE(holds_path(provenance.compiler));
  CHECK_FALSE(holds_path(provenance_line(provenance)));
}

TEST_CASE("the line for a picture is stable and says whether the sources were changed") {
  Provenance provenance;
  provenance.program_version = "granuscope 1.2.3";
  provenance.git_commit = "0123";
  provenance.compiler = "GNU 12.2.0";
  provenance.host_cpu = "some host";
  CHECK(provenance_line(provenance) == "granuscope 1.2.3, commit 0123, GNU 12.2.0");
  provenance.git_dirty = true;
  CHECK(provenance_line(provenance) == "granuscope 1.2.3, commit 0123 with uncommitted changes, GNU 12.2.0");
}

TEST_CASE("the time is ISO 8601 in UTC") {
  const std::string time = current_time();
  CHECK(time.size() == std::string("2002-03-14T15:09:26Z").size());
  CHECK(pattern_of(time) == "1-1-1T1:1:1Z");
  CHECK(time.substr(0, 2) == "20");
}

TEST_CASE("the commit and the dirty flag follow the checkout") {
  if (!find_program("cmake") || !find_program("git")) return;
  const TemporaryFolder folder;
  CHECK_THAT(git_state_of(folder.path()), Contains("commit = \"unknown\"") && Contains("dirty = false"));

  git(folder.path(), {"init", "-q"});
  CHECK_THAT(git_state_of(folder.path()), Contains("commit = \"unknown\"") && Contains("dirty = false"));
  make_folder(folder / "src");
  write_file(folder / "src/a.cc", "1");
  git(folder.path(), {"add", "."});
  git(folder.path(), {"commit", "-q", "-m", "first"});
  const std::string clean = git_state_of(folder.path());
  const std::string before_commit = "commit = \"";
  REQUIRE_THAT(clean, Contains(before_commit));
  CHECK(is_commit(clean.substr(clean.find(before_commit) + before_commit.size(), 40)));
  CHECK_THAT(clean, Contains("dirty = false"));

  // An author's own experiment changes nothing that is built; a new source file does.
  write_file(folder / "mine.toml", "1");
  CHECK(git_state_of(folder.path()) == clean);
  write_file(folder / "src/b.cc", "1");
  CHECK_THAT(git_state_of(folder.path()), Contains("dirty = true"));
  std::filesystem::remove(folder / "src/b.cc");
  write_file(folder / "src/a.cc", "2");
  CHECK_THAT(git_state_of(folder.path()), Contains("dirty = true"));

  // A source archive unpacked inside somebody's checkout is not that checkout.
  CHECK_THAT(git_state_of(folder / "src"), Contains("commit = \"unknown\"") && Contains("dirty = false"));
}
