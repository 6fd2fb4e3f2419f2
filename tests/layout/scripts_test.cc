// The scripts at the top, called the way that does nothing: with a word they do not know.
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

namespace fs = std::filesystem;

TEST_CASE("the scripts find their folder from elsewhere and through a link") {
  const fs::path scratch = fs::path(GRANUSCOPE_BINARY_DIR) / "scratch scripts";
  fs::remove_all(scratch);
  fs::create_directories(scratch);
  for (const char* script : {"reproduce", "check"}) {
    CAPTURE(script);
    fs::create_symlink(fs::path(GRANUSCOPE_SOURCE_DIR) / script, scratch / script);
    for (const fs::path& name : {fs::path(GRANUSCOPE_SOURCE_DIR) / script, scratch / script}) {
      const std::string command =
          "cd / && '" + name.string() + "' unknown-word >'" + (scratch / "said").string() + "' 2>&1";
      const int status = std::system(command.c_str());  // NOLINT(concurrency-mt-unsafe): nothing else runs
      REQUIRE(WIFEXITED(status));
      CHECK(WEXITSTATUS(status) == 2);  // usage
    }
  }
  fs::remove_all(scratch);
}
