// What an ensemble that is stopped leaves behind, and how it is continued.
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "kit/sanitized.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/ensemble_stage.h"
#include "pipeline/pipeline.h"
#include "quiet_run.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// Interrupts `draw` once this part of its ensemble is there, which it leaves.
template <typename Draw>
void interrupt_at(const fs::path& part, const Draw& draw) {
  std::atomic<bool> over = false;
  std::thread stopper([&] {
    while (!over && !fs::exists(part)) std::this_thread::yield();
    request_interruption(true);
  });
  CHECK_THROWS_AS(draw(), Interrupted);
  over = true;
  stopper.join();
  request_interruption(false);
  CHECK(fs::exists(part));
}

}  // namespace

TEST_CASE("an ensemble stopped half way is continued from its last part, to the same bytes") {
  const TemporaryFolder whole, stopped;
  Experiment experiment = small_experiment();
  experiment.response.samples = 32 * group_size * (test::sanitized ? 6 : 24);
  const std::size_t one = 2;
  std::vector<PlannedEnsemble> planned = plan_ensembles(experiment, whole.path());
  obtain_ensemble(planned[one], whole.path(), 2, ProgressStyle::silent);

  const PartPolicy after_each_group{0, 0};
  planned = plan_ensembles(experiment, stopped.path());
  CHECK(planned[one].begun == 0);
  const fs::path part = stopped.path() / part_file(planned[one]);
  const auto draw = [&] { obtain_ensemble(planned[one], stopped.path(), 1, ProgressStyle::silent, after_each_group); };
  interrupt_at(part, draw);
  CHECK_FALSE(fs::exists(stopped.path() / planned[one].file));

  // Another experiment does not go on from there, this one does.
  Experiment other = experiment;
  other.sampling.seed += 1;
  CHECK(plan_ensembles(other, stopped.path())[one].begun == 0);
  planned = plan_ensembles(experiment, stopped.path());
  CHECK(planned[one].begun > 0);
  std::string plan;
  for (const PlannedStep& step : plan_run(experiment, quiet(stopped.path()))) plan += step.what + "\n";
  CHECK_THAT(plan, Catch::Contains("of them there already"));
  draw();
  CHECK(read_file(stopped.path() / planned[one].file) == read_file(whole.path() / planned[one].file));
  CHECK_FALSE(fs::exists(part));
}

TEST_CASE("chains are kept part by part, too, though they draw few beads for their time") {
  const TemporaryFolder whole, stopped;
  PlannedEnsemble planned;
  planned.label = "chains";
  planned.file = "ensembles/chains.h5";
  planned.spec.sampler.law = Law::polytope;
  planned.spec.sampler.mu = 0.3;
  planned.spec.sampler.thinning = 10;  // the burn-in is measured, for the same key again when it goes on
  planned.spec.lattice = {6, 6};
  planned.spec.response.samples = 32 * group_size * 4;
  PlannedEnsemble at_once = planned;
  obtain_ensemble(at_once, whole.path(), 2, ProgressStyle::silent);

  const fs::path part = stopped.path() / part_file(planned);
  PartPolicy often;
  often.seconds = 0.01;
  interrupt_at(part, [&] { obtain_ensemble(planned, stopped.path(), 1, ProgressStyle::silent, often); });
  look_for(planned, stopped.path());
  CHECK(planned.begun > 0);
  obtain_ensemble(planned, stopped.path(), 2, ProgressStyle::silent);
  CHECK(read_file(stopped.path() / planned.file) == read_file(whole.path() / planned.file));
}

TEST_CASE("a damaged part of an ensemble is drawn again") {
  const TemporaryFolder whole, folder;
  const Experiment experiment = small_experiment();
  std::vector<PlannedEnsemble> planned = plan_ensembles(experiment, whole.path());
  obtain_ensemble(planned[1], whole.path(), 2, ProgressStyle::silent);
  make_folder(folder.path() / "ensembles");
  write_file(folder.path() / part_file(planned[1]), "no ensemble");
  planned = plan_ensembles(experiment, folder.path());
  CHECK(planned[1].begun == 0);
  planned[1].begun = 1;  // as if only its configuration had been whole
  obtain_ensemble(planned[1], folder.path(), 2, ProgressStyle::silent);
  CHECK(read_file(folder.path() / planned[1].file) == read_file(whole.path() / planned[1].file));
}
