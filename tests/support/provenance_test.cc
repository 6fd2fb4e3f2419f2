#include "support/provenance.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>
#include <set>

#include "support/atomic_file.h"
#include "support/child_process.h"
#include "support/temporary_folder.h"

using namespace granuscope;
using granuscope::test::TemporaryFolder;

namespace {

/// What cmake/git_state.cmake writes for a source folder.
std::string git_state_of(const std::filesystem::path& source) {
  const TemporaryFolder folder;
  ProcessSpec spec;
  spec.arguments = {"cmake", "-DSOURCE_DIR=" + source.string(), "-DOUTPUT=" + (folder / "git_state.h").string(), "-P",
                    GRANUSCOPE_SOURCE_DIR "/cmake/git_state.cmake"};
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

using Catch::Matchers::Contains;

}  // namespace

TEST_CASE("provenance knows the program, its build and its machine") {
  const Provenance provenance = collect_provenance();
  CHECK(std::regex_match(provenance.program_version, std::regex(R"(granuscope \d+\.\d+\.\d+)")));
  CHECK((provenance.git_commit == "unknown" || std::regex_match(provenance.git_commit, std::regex("[0-9a-f]{40,64}"))));
  CHECK(std::regex_match(provenance.compiler, std::regex(R"(\w+ \d+\.\d+.*)")));
  CHECK_THAT(provenance.compiler_flags, Contains("-ffp-contract=off") && Contains("-std=c++20"));
  CHECK_FALSE(provenance.build_type.empty());
  CHECK_FALSE(provenance.host_cpu.empty());
  CHECK_THAT(provenance.operating_system, Contains("Linux"));
  CHECK(provenance.hardware_threads >= 1);

  std::set<std::string> names;
  for (const auto& [name, version] : provenance.libraries) {
    CHECK(std::regex_search(version, std::regex(R"(^\d+(\.\d+)+)")));
    names.insert(name);
  }
  CHECK(names.size() == provenance.libraries.size());
  for (const char* name : {"Eigen", "GSL", "HDF5", "libpng", "FreeType", "fmt", "TBB", "Highway", "OpenSSL"}) {
    CHECK(names.count(name) == 1);
  }
}

TEST_CASE("nothing baked in is a path of the building machine") {
  const Provenance provenance = collect_provenance();
  const std::regex path("(^|[ =])/[a-z]");
  CHECK_FALSE(std::regex_search(provenance.compiler_flags, path));
  CHECK_FALSE(std::regex_search(provenance.compiler, path));
  CHECK_FALSE(std::regex_search(provenance_line(provenance), path));
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
  CHECK(std::regex_match(current_time(), std::regex(R"(20\d\d-[01]\d-[0-3]\dT[0-2]\d:[0-5]\d:[0-6]\dZ)")));
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
  CHECK(std::regex_search(clean, std::regex("commit = \"[0-9a-f]{40}\"")));
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
