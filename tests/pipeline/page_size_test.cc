// The page of a whole example is not too large to send.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "experiment/experiment_file.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "support/atomic_file.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// What an attachment may have; the pages of examples/quick.toml and paper.toml have 3.26 and 3.46 million bytes.
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

}  // namespace

TEST_CASE("the pages of the examples keep their size budget", "[long]") {
  const std::string few = "response.samples=512";
  for (const Experiment& experiment :
       {example_with_few_piles("quick", {few, "studies.deep_response.samples=256", "studies.chain_share.samples=256"}),
        example_with_few_piles(
            "paper", {few, "studies.nonlinearity.multiplexed_samples=256", "studies.nonlinearity.point_samples=512",
                      "studies.small_friction.samples=256", "studies.chain_share.samples=256",
                      "studies.counted_work.sizes=[50, 100, 200, 400]"})}) {
    INFO(experiment.name);
    const TemporaryFolder folder;
    run_experiment(experiment, quiet(folder.path()));
    const auto size = fs::file_size(folder / "report.html");
    CHECK(size <= size_budget);
    CHECK(size > size_budget / 4);  // all of it is there
  }
}
