#include "pipeline/run_folder.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>

#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "report/run_files.h"
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
  make_folder(folder / "ensembles");
  make_folder(folder / "figures");
  write_file(folder / "ensembles/mu-0.3.h5", "\x89HDF of shards: granuscope ensemble");
  CHECK_NOTHROW(require_own_results(folder.path(), ""));
  for (const char* mine : {"summary.md", "report.pdf", "figures/mine.svg"}) {  // a run tells its folder first
    INFO(mine);
    write_file(folder / mine, "mine");
    CHECK_THROWS_WITH(require_own_results(folder.path(), ""), Contains(mine));
    fs::remove(folder / mine);
  }
  fs::create_symlink("/etc/hostname", folder / "summary.md");  // told by --dry-run, too
  CHECK_THROWS_WITH(require_own_results(folder.path(), ""), Contains("is a link"));
  fs::remove(folder / "summary.md");
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
  for (const char* file : {"summary.json", "ensembles/mu-0.3.h5", "ensembles/mu-0.3.blocks/7.part.h5", "figures/a.csv",
                           "figures/last-a.csv", "figures/a.gp"}) {
    write_file(run / file, "a granuscope ensemble");
  }
  write_file(run / "manifest.json", R"({"figure_files": ["figures/a.csv", "figures/a.gp"]})");
  const auto mine = GENERATE(as<std::string>(), "thesis.tex", "figures/talk.odp", "ensembles/notes.txt",
                             "figures/thesis.pdf", "figures/b.csv", "figures/README", "ensembles/data.h5", "paper.h5");
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

TEST_CASE("What somebody has changed in the folder of a run, or put there, is kept under another name") {
  const TemporaryFolder folder;
  Experiment small = parse_experiment(one_plot_text, "small.toml");
  small.force_chains.show = true;
  run_experiment(small, quiet(folder.path()));
  const auto [file, other] = GENERATE(table<std::string, bool>({{"figures/response-profiles.gp", false},
                                                                {"figures/response-profiles.svg", true},
                                                                {"summary.md", false},
                                                                {"summary.md", true},
                                                                {"report.html", true},
                                                                {"report.pdf", true}}));  // it made none
  CAPTURE(file, other);
  write_file(folder / file, "my own work");
  if (other) small.force_chains.show = false;
  CHECK(keep_changed(folder.path(), true) == std::vector<fs::path>{file});
  CHECK(read_file(folder / file) == "my own work");
  run_experiment(small, quiet(folder.path()));
  CHECK(read_file(folder / (file + ".kept")) == "my own work");
  CHECK(fs::exists(folder / file) == (file != "report.pdf"));
  CHECK(fs::exists(folder / "piles/force-chains.h5") == !other);
  CHECK(keep_changed(folder.path(), true).empty());
}
