// packages.txt against an empty system: what the sources include and start has to come with what is listed there, since
// every machine on which the tests run has more than that.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "kit/temporary_folder.h"

using namespace granuscope;

namespace {

struct Answer {
  int status = 0;
  std::string said;
};

/// What bash answers to `commands` at the top of the project, with the functions of cmake/packages_brought.sh.
Answer ask(const std::string& commands) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "script") << "set -euo pipefail\ncd '" GRANUSCOPE_SOURCE_DIR "'\n. cmake/packages.sh\n"
                                   << ". cmake/packages_brought.sh\nfolder='" << folder.path().string() << "'\n"
                                   << commands << '\n';
  const int status = std::system(  // NOLINT(concurrency-mt-unsafe): nothing else runs
      ("bash '" + (folder / "script").string() + "' >'" + (folder / "said").string() + "' 2>&1").c_str());
  std::ostringstream said;
  said << std::ifstream(folder / "said").rdbuf();
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, said.str()};
}

}  // namespace

// Without sanitizers: all of it is the work of other programs, and takes seconds.
TEST_CASE("packages.txt brings each header and program that the sources name onto an empty system", "[unsanitized]") {
  const Answer possible = ask("can_simulate");
  if (possible.status != 0) {
    WARN("packages.txt has not been held against an empty system: " << possible.said);
    return;
  }
  // Figures in the font TeX need latex and dvips; without them an error names the packages to install.
  const Answer lacking = ask(R"(
    packages_brought "$folder" run >"$folder/brought"
    not_brought "$folder/brought" "latex dvips" $(find src -path src/services/mpi -prune -o -name '*.cc' -print -o -name '*.h' -print) |
      sed 's/^/for src, [run] lacks what brings /'
    packages_brought "$folder" run check >"$folder/brought"
    not_brought "$folder/brought" "" $(find src/services/mpi tests -name '*.cc' -o -name '*.h') |
      sed 's/^/for tests and src\/services\/mpi, [run] and [check] lack what brings /')");
  INFO("add that package, or one that depends on it, to packages.txt");
  CHECK(lacking.said == "");
  CHECK(lacking.status == 0);
}
