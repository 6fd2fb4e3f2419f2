// Whatever happened to a folder before, a run leaves the bytes of one plain run.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "kit/sanitized.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/sample_stage.h"
#include "sharded_run.h"
#include "support/error.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

constexpr int last_step = 3;

/// The tiny experiment with as many samples, or as small errors, as it has after so many times of growing.
Experiment grown(const std::string& kind, int step) {
  Experiment experiment = unplotted(sharded_experiment(kind == "precise" ? "multiplexed" : kind));
  const std::vector<std::size_t> samples = {72, 101, 104, 200};  // 101: the beginning of no larger one
  experiment.response.samples = samples.at(static_cast<std::size_t>(step));
  if (kind == "precise") {
    // Each asks for more samples: what has as many as the next one needs stays as it is, with its own precision in it.
    const std::vector<double> errors = {3e-2, 1.8e-2, 9e-3, 6e-3};
    experiment.mu = {0.5};
    experiment.response.samples = 72;
    experiment.precision = {errors.at(static_cast<std::size_t>(step)), 0, 2000};
    experiment.studies = {};
  }
  return experiment;
}

/// What happens to the folder of a run, and to folders of shards beside it, in an order given by a seed.
class History {
 public:
  History(const std::string& kind, unsigned seed, const fs::path& root) : kind_(kind), root_(root), random_(seed) {
    told_ = kind + ", seed " + std::to_string(seed) + ":";
  }

  const std::string& told() const { return told_; }

  void happen() {
    switch (upto(8)) {
      case 0:
        return run();
      case 1:
        return stop();
      case 2:
        return kill();
      case 3:
        return shard();
      case 4:
        return merge();
      case 5:
        return damage();
      case 6:
        return grow();
      default:
        return stop(), grow();
    }
  }

  /// Everything that is still missing.
  void end() {
    step_ = last_step;
    tell("run to the end");
    RunOptions options = with_threads(main());
    options.only = {Stage::report};
    run_experiment(now(), options);
  }

 private:
  /// 0 .. count - 1. The distributions of the standard library differ from one to the next, this does not.
  int upto(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  void tell(const std::string& what) { told_ += " " + what + ";"; }
  fs::path main() const { return root_ / "run"; }
  Experiment now() const { return grown(kind_, step_); }
  RunOptions with_threads(const fs::path& folder) {
    RunOptions options = quiet(folder, {Stage::sample});
    options.threads = std::vector<int>{1, 2, 5}.at(static_cast<std::size_t>(upto(3)));
    tell(std::to_string(options.threads) + " threads");
    return options;
  }

  void run() {
    tell("run");
    run_experiment(now(), with_threads(main()));
  }

  void grow() {
    if (step_ == last_step) return;
    tell("grow");
    ++step_;
  }

  /// One ensemble, kept after each piece, and interrupted once it has been kept, or when it is drawn.
  void stop() {
    std::vector<PlannedEnsemble> ensembles = all_ensembles(now(), main());
    PlannedEnsemble& planned = ensembles.at(static_cast<std::size_t>(upto(static_cast<int>(ensembles.size()))));
    tell("stop " + planned.label);
    const fs::path part = main() / part_file(planned);
    make_folder(main());
    keep_experiment(main());
    std::atomic<bool> over = false;
    std::thread stopper([&] {
      while (!over && !fs::exists(part)) std::this_thread::yield();
      request_interruption(true);
    });
    const int threads = 1 + upto(2);
    std::exception_ptr failure;
    try {
      obtain_ensemble(planned, main(), threads, ProgressStyle::silent, {0, 0});
    } catch (const Interrupted&) {
      tell("(stopped)");
    } catch (...) {
      failure = std::current_exception();
    }
    over = true;
    stopper.join();
    request_interruption(false);
    if (failure) std::rethrow_exception(failure);
  }

  /// A run that is killed at any moment: nothing of it can put anything in order.
  void kill() {
    const int milliseconds = upto(test::sanitized ? 600 : 60);
    tell("kill after " + std::to_string(milliseconds) + " ms");
    const RunOptions options = with_threads(main());
    const Experiment experiment = now();
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      try {
        run_experiment(experiment, options);
      } catch (...) {
        ::_exit(1);
      }
      ::_exit(0);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    CHECK((WIFSIGNALED(status) || WEXITSTATUS(status) == 0));
  }

  /// Some blocks, in the folder of the run or in one beside it; a folder of another experiment refuses them.
  void shard() {
    const int count = 1 + upto(4), place = upto(3);
    const Shard one{1 + upto(count), count};
    tell("shard " + std::to_string(one.number) + "/" + std::to_string(count) + " in " + std::to_string(place));
    try {
      run_shard(now(), with_threads(folder(place)), one);
    } catch (const InputError& refused) {
      tell("(refused: " + std::string(refused.what()).substr(0, 60) + ")");
    }
  }

  /// Of all folders into the run; blocks that are missing, damaged or of another experiment refuse it.
  void merge() {
    std::vector<fs::path> folders;
    for (int place = 0; place < 3; ++place) {
      if (fs::exists(folder(place))) folders.push_back(folder(place));
    }
    if (folders.empty()) return;
    tell("merge");
    try {
      merge_folders(folders, main(), ProgressStyle::silent);
    } catch (const InputError& refused) {
      tell("(refused: " + std::string(refused.what()).substr(0, 60) + ")");
    }
  }

  /// One byte of one file, or its end.
  void damage() {
    std::vector<fs::path> files;
    if (!fs::exists(main() / "ensembles")) return;
    for (const auto& [name, bytes] : ensembles_in(main())) files.push_back(main() / name);
    if (files.empty()) return;
    const fs::path& file = files.at(static_cast<std::size_t>(upto(static_cast<int>(files.size()))));
    std::string bytes = read_file(file);
    if (bytes.empty()) return;
    const auto at = static_cast<std::size_t>(upto(static_cast<int>(bytes.size())));
    const bool cut = upto(2) == 0;
    tell((cut ? "cut " : "change ") + file.filename().string() + " at " + std::to_string(at));
    if (cut) {
      bytes.resize(at);
    } else {
      bytes[at] = static_cast<char>(bytes[at] ^ 0x55);
    }
    write_file(file, bytes);
  }

  fs::path folder(int place) const { return place == 0 ? main() : root_ / ("shards-" + std::to_string(place)); }
  /// What a run leaves first of all, so that its folder is known for one.
  void keep_experiment(const fs::path& folder) const {
    write_file(folder / "experiment.toml", print_experiment(now()));
  }

  std::string kind_;
  fs::path root_;
  std::mt19937 random_;
  std::string told_;
  int step_ = 0;
};

/// `histories` of each kind, each of so many events, end like a plain run on three threads.
void check_histories(unsigned first_seed, int histories, int events) {
  for (const std::string kind : {"point", "paired", "multiplexed", "fluctuation", "precise"}) {
    const TemporaryFolder plain;
    RunOptions options = quiet(plain.path(), {Stage::report});
    options.threads = 3;
    run_experiment(grown(kind, last_step), options);
    const auto expected = ensembles_in(plain.path());
    const std::string summary = read_file(plain / "summary.json");
    for (int k = 0; k < histories; ++k) {
      const TemporaryFolder folder;
      History history(kind, first_seed + static_cast<unsigned>(k), folder.path());
      try {
        for (int event = 0; event < events; ++event) history.happen();
        history.end();
      } catch (const std::exception& error) {
        FAIL(history.told() << " " << error.what());
      }
      INFO(history.told());
      const auto files = ensembles_in(folder / "run");
      for (const auto& [name, bytes] : files) {
        INFO(name);
        CHECK(expected.contains(name));
        CHECK((!expected.contains(name) || bytes == expected.at(name)));
      }
      CHECK(files.size() == expected.size());
      CHECK((read_file(folder / "run/summary.json") == summary));
    }
  }
}

}  // namespace

TEST_CASE("a run ends with the bytes of a plain one, whatever was drawn, killed, grown, damaged and merged before") {
  check_histories(1, 1, 8);
}

TEST_CASE("so it does after many longer histories", "[long]") {
  // GRANUSCOPE_HISTORY_SEED tells again what has failed.
  const char* const asked = std::getenv("GRANUSCOPE_HISTORY_SEED");
  check_histories(asked == nullptr ? std::random_device()() : static_cast<unsigned>(std::stoul(asked)), 5, 16);
}
