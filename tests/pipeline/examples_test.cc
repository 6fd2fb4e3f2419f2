// The examples: the same files for every number of threads, within their budgets.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/process.h"

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

/// examples/quick.toml with small piles and few of them: its figures and studies are those of the example, but for
/// those that count work, and how the fields couple beside them.
Experiment reduced_quick() {
  // Without the verdicts expected: some are of claims that it does not make here.
  const TemporaryFolder folder;
  const std::string quick = read_file(fs::path(GRANUSCOPE_SOURCE_DIR) / "examples/quick.toml");
  write_file(folder / "reduced.toml", std::string_view(quick).substr(0, quick.find("[gate.expect]")));
  return read_experiment(folder / "reduced.toml", {"lattice.columns=120",
                                                   "lattice.layers=70",
                                                   "friction.mu=[0.0, 0.2, 0.25, 0.3, 0.4]",
                                                   "response.samples=256",
                                                   "fit.first_layer=25",
                                                   "fit.last_layer=49",
                                                   "fit.shallow_layer=13",
                                                   "fit.scaling_window=[0.2, 0.4]",
                                                   "fit.other_scaling_windows=[[0.2, 0.3]]",
                                                   "figures.response_profiles.layers=[31, 49]",
                                                   "studies.error_against_time.repetitions=8",
                                                   "studies.error_against_time.columns=100",
                                                   "studies.error_against_time.layers=60",
                                                   "studies.deep_response.mu=[0.3]",
                                                   "studies.deep_response.octaves=3",
                                                   "studies.deep_response.first_lag=4",
                                                   "studies.deep_response.columns=48",
                                                   "studies.deep_response.samples=256",
                                                   "studies.mode_coupling.mu=[0.5]",
                                                   "studies.mode_coupling.octaves=3",
                                                   "studies.mode_coupling.columns=160",
                                                   "studies.mode_coupling.samples=256",
                                                   "studies.mode_coupling.loaded_samples=256",
                                                   "studies.mode_coupling.fluctuation_layer=256",
                                                   "studies.mode_coupling.fluctuation_samples=256",
                                                   "studies.redrawn_beads.samples=256",
                                                   "studies.counted_work.mu=[]",
                                                   "studies.chain_share.samples=256",
                                                   "report.pdf=false"});
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
    const Experiment experiment = reduced_quick();
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

// The reports of whole examples: not too large to send, nor too long to read, with pictures as large as they were made.

namespace {

/// What an attachment may have; the pages of examples/quick.toml and paper.toml have 3.42 and 3.78 million bytes.
constexpr std::uintmax_t size_budget = 4'000'000;

/// An example with all its figures, tables, depths and friction coefficients, but few piles: they do not change how
/// large its page is, other than by a digit here and there.
Experiment example_with_few_piles(const std::string& name, const std::vector<std::string>& changes) {
  const TemporaryFolder folder;
  const std::string whole = read_file(fs::path(GRANUSCOPE_SOURCE_DIR) / "examples" / (name + ".toml"));
  // Without the verdicts expected: some differ where piles are few.
  write_file(folder / "few.toml", std::string_view(whole).substr(0, whole.find("[gate.expect]")));
  return read_experiment(folder / "few.toml", changes);
}

std::string output_of(const std::vector<std::string>& arguments, const fs::path& folder) {
  ProcessSpec process;
  process.arguments = arguments;
  process.working_folder = folder;
  const ProcessResult result = run_process(process);
  REQUIRE(result.exit_code == 0);
  return result.standard_output;
}

int pages_of(const fs::path& folder) {
  const std::string info = output_of({"pdfinfo", "report.pdf"}, folder);
  return std::stoi(info.substr(info.find("Pages:") + 6));
}

/// The pixels per inch at which a PDF shows its pictures.
std::vector<int> resolutions_of(const fs::path& folder) {
  std::istringstream lines(output_of({"pdfimages", "-list", "report.pdf"}, folder));
  std::vector<int> resolutions;
  std::string line;
  for (int k = 0; std::getline(lines, line); ++k) {
    std::istringstream words(line);
    std::string word;
    for (int column = 0; column < 13; ++column) words >> word;
    if (k > 1) resolutions.push_back(std::stoi(word));  // two lines of heading
  }
  return resolutions;
}

struct Example {
  Experiment experiment;
  int most_pages = 0;
};

}  // namespace

TEST_CASE("the reports of the examples keep their budgets of bytes and pages, and the size of their pictures",
          "[long]") {
  const std::string few = "response.samples=512";
  for (const auto& [experiment, most_pages] :
       {Example{example_with_few_piles("quick",
                                       {few, "studies.deep_response.samples=256", "studies.chain_share.samples=256"}),
                11},
        Example{example_with_few_piles(
                    "paper", {few, "studies.nonlinearity.multiplexed_samples=256",
                              "studies.nonlinearity.point_samples=512", "studies.small_friction.samples=256",
                              "studies.chain_share.samples=256", "studies.counted_work.sizes=[50, 100, 200, 400]"}),
                12}}) {
    INFO(experiment.name);
    const TemporaryFolder folder;
    run_experiment(experiment, quiet(folder.path()));
    const auto size = fs::file_size(folder / "report.html");
    CHECK(size <= size_budget);
    CHECK(size > size_budget / 4);  // all of it is there
    CHECK(pages_of(folder.path()) <= most_pages);
    // As they were rendered, so that their text has its 8 pt.
    const std::vector<int> resolutions = resolutions_of(folder.path());
    CHECK(resolutions.size() == 3);
    for (const int resolution : resolutions) {
      CHECK(std::abs(resolution - experiment.force_chains.scene.dpi) <= 1);
    }
  }
}

// What README and docs/results.md quote of examples/quick.toml is what it finds.

namespace {

std::string in_words(const nlohmann::json& number) {
  if (!number.value("power_law", true)) {
    const nlohmann::json& about = number.at("about_law");
    return fmt::format("{}, χ² {}/{}", significant(number.at("value"), 3), significant(about.at("chi2"), 2),
                       about.at("degrees_of_freedom").get<int>());
  }
  return value_with_error(number.at("value"), number.at("stderr"));
}

/// The row of a table of exponents.
std::string exponents_row(const std::string& read, const std::string& window, const nlohmann::json& found) {
  return fmt::format("| {} | {} | {} | {} | {} |", read, window, in_words(found.at("gamma")),
                     in_words(found.at("beta")), in_words(found.at("alpha")));
}

}  // namespace

TEST_CASE("README, docs/results.md and docs/record.md say what examples/quick.toml finds", "[long]") {
  const TemporaryFolder folder;
  const fs::path source = GRANUSCOPE_SOURCE_DIR;
  run_experiment(read_experiment(source / "examples/quick.toml", {"report.pdf=false"}), quiet(folder.path()));
  const nlohmann::json summary = nlohmann::json::parse(read_file(folder / "summary.json"));
  const nlohmann::json& best = summary.at("studies").at("literal_reading").at("best");
  const std::string readme = read_file(source / "README.md"), findings = read_file(source / "docs/results.md");
  for (const std::string& row :
       {exponents_row(fmt::format("x_p/z and W²/z at z = {}", significant(best.at("z"), 3)), "0.1–0.3", best),
        exponents_row("slopes with depth", "0.1–0.3", summary.at("scaling")),
        exponents_row("slopes of the linear response", "0.05–0.1", summary.at("scaling").at("readings").at(1))}) {
    CHECK_THAT(readme, Catch::Matchers::Contains(row));
  }
  const std::string record = read_file(source / "docs/record.md");
  for (const nlohmann::json& one : summary.at("results")) {
    const double mu = one.at("mu");
    if (mu == 0) continue;                                  // exact
    const bool main = mu == 0.1 || mu == 0.3 || mu == 0.6;  // the record has all rows
    CHECK_THAT(main ? findings : record,
               Catch::Matchers::Contains(fmt::format("| {} | {} | {} | {} |", mu, in_words(one.at("c")),
                                                     in_words(one.at("D")), in_words(one.at("c_thrust")))));
  }
}
