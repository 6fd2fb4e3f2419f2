#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/atomic_file.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// What was timed may stand in these only.
const std::set<std::string> may_differ = {"manifest.json", "timings.json"};

/// The page with all but its section of timings.
std::string without_timings(const std::string& page) {
  const std::string start = "<section aria-labelledby=\"timings\">", end = "</section>";
  const std::size_t from = page.find(start);
  REQUIRE(from != std::string::npos);
  return page.substr(0, from) + page.substr(page.find(end, from));
}

std::map<std::string, std::string> stable_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (!entry.is_regular_file() || may_differ.contains(name)) continue;
    const std::string bytes = read_file(entry.path());
    files[name] = name == "report.html" ? without_timings(bytes) : bytes;
  }
  return files;
}

/// examples/quick.toml with its smallest piles and few of them: every key, figure and study is that of the example.
Experiment reduced_quick() {
  Experiment experiment = read_experiment(fs::path(GRANUSCOPE_SOURCE_DIR) / "examples/quick.toml");
  std::string text = print_experiment(experiment);
  const auto set = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find("\n" + from);
    REQUIRE(at != std::string::npos);
    text.replace(at + 1, from.size(), to);
  };
  set("columns = 500", "columns = 120");
  set("layers = 200", "layers = 70");
  set("mu = [0.0, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6]", "mu = [0.0, 0.2, 0.25, 0.3, 0.4]");
  set("samples = 8192", "samples = 256");
  set("first_layer = 58", "first_layer = 25");
  set("last_layer = 179", "last_layer = 49");
  set("shallow_layer = 16", "shallow_layer = 13");
  set("scaling_window = [0.1, 0.3]", "scaling_window = [0.2, 0.4]");
  set("other_scaling_windows = [[0.15, 0.6]]", "other_scaling_windows = [[0.2, 0.3]]");
  set("layers = [110, 170]", "layers = [31, 49]");
  set("repetitions = 16", "repetitions = 8");
  set("columns = 256", "columns = 100");
  set("layers = 120", "layers = 60");
  return parse_experiment(text, "quick.toml");
}

void check_same(const std::map<std::string, std::string>& first, const std::map<std::string, std::string>& other) {
  for (const auto& [name, bytes] : first) {
    INFO(name);
    REQUIRE(other.contains(name));
    CHECK((other.at(name) == bytes));  // a difference is named by its file, not printed
  }
  CHECK(other.size() == first.size());
}

}  // namespace

TEST_CASE("every file of two runs apart is the same bytes for 1, 2, 3 and 7 threads", "[long]") {
  std::map<std::string, std::string> first;
  for (const int threads : {1, 2, 3, 7}) {
    const TemporaryFolder folder;
    Experiment experiment = reduced_quick();
    experiment.report.pdf = false;  // it holds what the page holds, and takes seconds
    RunOptions options = quiet(folder.path());
    options.threads = threads;
    run_experiment(experiment, options);
    const std::map<std::string, std::string> files = stable_files(folder.path());
    CHECK(files.contains("figures/error-against-time.svg"));
    if (threads == 3) {  // what is reused is told among the timings, too
      run_experiment(experiment, options);
      check_same(files, stable_files(folder.path()));
    }
    if (first.empty()) first = files;
    check_same(first, files);
  }
}
