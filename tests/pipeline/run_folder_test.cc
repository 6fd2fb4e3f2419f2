#include "pipeline/run_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>

#include "kit/temporary_folder.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;

TEST_CASE("a folder is one run's at a time") {
  const TemporaryFolder folder;
  const auto path = folder / "deep/er";
  auto first = std::make_unique<RunFolder>(path);
  CHECK(std::filesystem::is_directory(path));
  CHECK_THROWS_WITH(RunFolder(path),
                    Contains("another run or shard is working in") && Contains("choose another folder"));
  CHECK_THROWS_AS(RunFolder(path), BusyError);
  CHECK_NOTHROW(RunFolder(folder / "other"));
  first.reset();
  CHECK_NOTHROW(RunFolder(path));
  CHECK(std::filesystem::is_empty(path));  // the lock leaves no file
}

TEST_CASE("a folder that cannot be is refused") {
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "x";
  CHECK_THROWS_AS(RunFolder(folder / "file"), EnvironmentError);
  CHECK_THROWS_AS(RunFolder("/proc/none"), EnvironmentError);
}
