// What `cmake --install` and the packages leave works without the project's folder.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "kit/temporary_folder.h"

using namespace granuscope;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string build_folder = GRANUSCOPE_BINARY_DIR;

/// Runs a line of the shell in `folder`; what it says is told if it ends otherwise than with 0.
void require_done(const fs::path& folder, const std::string& command) {
  const std::string said = (folder / "said").string();
  const int status = std::system(  // NOLINT(concurrency-mt-unsafe): nothing else runs
      ("cd '" + folder.string() + "' && { " + command + "; } >'" + said + "' 2>&1").c_str());
  std::ostringstream text;
  text << std::ifstream(said).rdbuf();
  INFO(command << '\n' << text.str());
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
}

bool has_program(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null").c_str()) == 0;  // NOLINT(concurrency-mt-unsafe)
}

constexpr const char* small_experiment = R"(
[lattice]
columns = 64
layers = 64
[friction]
mu = [0.0, 0.3]
[response]
samples = 256
[fit]
first_layer = 24
last_layer = 42
[figures.response_profiles]
layers = [30]
[scenes.force_chains]
columns = 20
layers = 12
width_px = 500
dpi = 110
)";

}  // namespace

TEST_CASE("a program outside the project uses the installed library", "[long]") {
  const test::TemporaryFolder folder;
  const std::string prefix = (folder / "prefix").string();
  require_done(folder.path(), "cmake --install '" + build_folder + "' --prefix '" + prefix + "'");
  require_done(folder.path(), "cmake -S '" GRANUSCOPE_SOURCE_DIR
                              "/examples/library' -B consumer -DCMAKE_BUILD_TYPE=Release "
                              "-DCMAKE_PREFIX_PATH='" +
                                  prefix + "' && cmake --build consumer");
  require_done(folder.path(), "cd consumer && ./consumer");
  // What a package manager and a shell look for.
  for (const char* file :
       {"bin/granuscope", "share/man/man1/granuscope-run.1.gz", "share/man/man5/granuscope-experiment.5.gz",
        "share/bash-completion/completions/granuscope", "share/zsh/vendor-completions/_granuscope",
        "share/fish/vendor_completions.d/granuscope.fish", "share/granuscope/templates/palette.txt",
        "share/doc/granuscope/examples/quick.toml", "share/doc/granuscope/LICENSE",
        "share/doc/granuscope/CITATION.cff"}) {
    INFO(file);
    CHECK(fs::is_regular_file(fs::path(prefix) / file));
  }
}

TEST_CASE("the Debian package, unpacked into an empty folder, makes a report", "[long]") {
  if (!has_program("dpkg-deb")) {
    WARN("no dpkg-deb here: nothing was tested");
    return;
  }
  const test::TemporaryFolder folder;
  require_done(folder.path(), "cpack -G DEB --config '" + build_folder + "/CPackConfig.cmake' -B packages");
  require_done(folder.path(), "dpkg-deb -x packages/granuscope_*.deb root");
  std::ofstream(folder / "small.toml") << small_experiment;
  require_done(folder.path(),
               "env -i PATH=\"$PWD/root/usr/bin:/usr/bin:/bin\" HOME=\"$PWD\" sh -ec '"
               "granuscope example quick | grep -q lattice; granuscope run small.toml --out report'");
  CHECK(fs::file_size(folder / "report/report.html") > 50'000);
  CHECK(fs::exists(folder / "report/figures/force-chains.png"));
  require_done(folder.path(), "dpkg-deb -f packages/granuscope_*.deb Depends Recommends Suggests");
  std::ostringstream fields;
  fields << std::ifstream(folder / "said").rdbuf();
  CHECK_THAT(fields.str(), Contains("libhdf5") && Contains("gnuplot-nox") && Contains("Recommends: libosmesa6") &&
                               Contains("Suggests: weasyprint"));
  if (fs::exists(fs::path(build_folder) / "granuscope-mpi")) {
    require_done(folder.path(),
                 "dpkg-deb -x packages/granuscope-mpi_*.deb root && test -x root/usr/bin/granuscope-mpi");
    require_done(folder.path(), "dpkg-deb -f packages/granuscope-mpi_*.deb Depends | grep -q 'granuscope (= '");
  }
  if (has_program("lintian")) require_done(folder.path(), "lintian --allow-root --fail-on error packages/*.deb");
}
