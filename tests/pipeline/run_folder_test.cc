#include "pipeline/run_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>

#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

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

TEST_CASE("no link in a folder leads what is written or removed elsewhere") {
  const TemporaryFolder folder;
  fs::create_directories(folder / "run/figures");
  fs::create_directories(folder / "elsewhere");
  write_file(folder / "precious", "kept");
  const fs::path run = folder / "run";
  const auto [link, target] =
      GENERATE(table<std::string, std::string>({{"experiment.toml", "precious"},
                                                {"report.pdf", "precious"},
                                                {"ensembles", "elsewhere"},
                                                {"figures/scaling-with-friction.svg", "precious"},
                                                {"pool", "elsewhere"},
                                                {"history.sqlite", "precious"}}));
  INFO(link);
  fs::create_symlink(folder / target, run / link);
  CHECK_THROWS_WITH(RunFolder(run), Contains(link) && Contains("is a link"));
  CHECK_THROWS_AS(RunFolder(run, FolderUse::shared), InputError);
  CHECK(read_file(folder / "precious") == "kept");
}

TEST_CASE("a folder that is itself a link, and links of the user's own beside the run, do no harm") {
  const TemporaryFolder folder;
  fs::create_directories(folder / "disk");
  fs::create_symlink(folder / "disk", folder / "run");
  fs::create_symlink("/etc/hostname", folder / "disk/mine");
  CHECK_NOTHROW(RunFolder(folder / "run"));
}

TEST_CASE("what no run has left is not replaced") {
  const TemporaryFolder folder;
  const auto file = GENERATE(as<std::string>(), "experiment.toml", "manifest.json", "summary.md", "report.html",
                             "claims.xml", "figures/mine.svg", "ensembles/data.h5");
  INFO(file);
  make_folder((folder / file).parent_path());
  write_file(folder / file, "{\"name\": \"mine\"}\n");
  CHECK_THROWS_WITH(require_own_results(folder.path(), ""), Contains(file) && Contains("no run of granuscope left"));
}

TEST_CASE("a history and what is in it are no folders of runs") {
  const test::TemporaryFolder folder;
  write_file(folder / "history.sqlite", "");
  for (const char* of : {"", "pool", "pool/", "canary", "canary/reference", "reports/2026-01-01", "before"}) {
    INFO(of);
    CHECK_THROWS_WITH(require_no_history(folder / of), Contains("belongs to a history"));
  }
  CHECK_NOTHROW(require_no_history(folder / "runs"));
}

TEST_CASE("what the user keeps beside the results of a run is no reason to refuse it") {
  const TemporaryFolder folder;
  write_file(folder / "notes.md", "mine");
  CHECK_NOTHROW(require_own_results(folder.path(), ""));
  write_file(folder / "experiment.toml", print_experiment(small_experiment()));
  write_file(folder / "summary.md", "of a run that left no manifest");
  CHECK_NOTHROW(require_own_results(folder.path(), ""));
  write_file(folder / "experiment.toml", "# my own words\n" + smallest_experiment_text);
  CHECK_THROWS_AS(require_own_results(folder.path(), ""), InputError);
}

TEST_CASE("only files of known names are removed, and folders only once they are empty") {
  const TemporaryFolder folder;
  fs::create_directories(folder / "shards");
  write_file(folder / "shards/1-of-2", "");
  const auto is_lock = [](std::string_view name) { return name == "1-of-2" || name == "folder" || name == "link"; };
  CHECK(remove_own_files(folder / "shards", is_lock));
  CHECK(remove_own_files(folder / "shards", is_lock));  // there is none any more

  fs::create_directories(folder / "shards/folder");
  write_file(folder / "shards/1-of-2", "");
  write_file(folder / "shards/train.bin", "mine");
  fs::create_symlink(folder / "shards/train.bin", folder / "shards/link");
  CHECK_FALSE(remove_own_files(folder / "shards", is_lock));
  CHECK_FALSE(fs::exists(folder / "shards/1-of-2"));
  CHECK(read_file(folder / "shards/train.bin") == "mine");
  CHECK(fs::is_symlink(folder / "shards/link"));
  CHECK(fs::is_directory(folder / "shards/folder"));
}

TEST_CASE("a run is removed as a whole, or not at all where it holds something else") {
  const TemporaryFolder folder;
  const fs::path run = folder / "pool";
  fs::create_directories(run / "ensembles/mu-0.3.blocks");
  fs::create_directories(run / "figures");
  for (const char* file : {"manifest.json", "summary.json", "ensembles/mu-0.3.h5", "ensembles/mu-0.3.blocks/7.part.h5",
                           "figures/a.svg", "figures/a.gp"}) {
    write_file(run / file, "x");
  }
  const auto mine = GENERATE(as<std::string>(), "thesis.tex", "figures/talk.odp", "ensembles/notes.txt");
  INFO(mine);
  write_file(run / mine, "mine");
  CHECK_THROWS_WITH(remove_run(run), Contains(mine) && Contains("nothing was"));
  CHECK(fs::exists(run / "manifest.json"));
  CHECK(fs::exists(run / "ensembles/mu-0.3.blocks/7.part.h5"));
  fs::remove(run / mine);
  remove_run(run);
  CHECK_FALSE(fs::exists(run));
  CHECK_NOTHROW(remove_run(run));
}
