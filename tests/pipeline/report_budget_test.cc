// The reports of whole examples: not too large to send, nor too long to read, with pictures as large as they were made.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/files.h"
#include "support/process.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// What an attachment may have; the pages of examples/quick.toml and paper.toml have 3.14 and 3.34 million bytes.
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
                9},
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
    CHECK(resolutions.size() == 4);
    for (const int resolution : resolutions) {
      CHECK(std::abs(resolution - experiment.force_chains.scene.dpi) <= 1);
    }
  }
}
