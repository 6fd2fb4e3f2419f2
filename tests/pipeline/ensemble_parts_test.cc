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
#include "pipeline/block_files.h"
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

namespace {

/// An ensemble of `groups` groups, drawn whole in `folder`.
PlannedEnsemble drawn(const fs::path& folder, std::uint64_t groups, std::uint64_t grows_from = 0) {
  PlannedEnsemble planned;
  planned.label = "mu = 0.3";
  planned.file = "ensembles/mu-0.3.h5";
  planned.spec = small_experiment().main_ensemble(0.3);
  planned.spec.response.samples = groups * group_size;
  planned.grows_from = grows_from;
  look_for(planned, folder);
  obtain_ensemble(planned, folder, 2, ProgressStyle::silent);
  return planned;
}

}  // namespace

TEST_CASE("a larger ensemble that is stopped goes on from its part, or from the smaller one where that is damaged") {
  const TemporaryFolder whole, stopped;
  const std::uint64_t few = 64, many = 64 * 12;
  drawn(whole.path(), many);
  drawn(stopped.path(), few);
  StudyEnsemble larger{"mu = 0.3", "mu-0.3", small_experiment().main_ensemble(0.3)};
  larger.spec.response.samples = many * group_size;
  PlannedEnsemble planned = plan_ensemble(larger, stopped.path());
  const fs::path part = stopped.path() / part_file(planned);
  interrupt_at(part, [&] { obtain_ensemble(planned, stopped.path(), 1, ProgressStyle::silent, {0, 0}); });

  planned = plan_ensemble(larger, stopped.path());
  CHECK(planned.begun > few);
  CHECK(planned.replaces.empty());  // nothing is: the old file is a beginning of the new one
  std::string bytes = read_file(part);
  bytes.resize(bytes.size() / 2);
  write_file(part, bytes);
  planned = plan_ensemble(larger, stopped.path());
  REQUIRE(planned.smaller);
  CHECK(samples_there(planned) == few * group_size);
  obtain_ensemble(planned, stopped.path(), 2, ProgressStyle::silent);
  CHECK((read_file(stopped.path() / planned.file) == read_file(whole.path() / planned.file)));
  CHECK_FALSE(fs::exists(part));
}

TEST_CASE("a whole ensemble leaves nothing unfinished behind, but keeps what is drawn of its next size") {
  const TemporaryFolder folder;
  PlannedEnsemble planned = drawn(folder.path(), 64, 64 * group_size);
  const fs::path part = folder.path() / part_file(planned);
  const BlockFiles blocks(planned, folder.path());
  // Beginnings of this size, left by a stop, go; a file of the user's stays, and its folder with it.
  const auto leave = [&](std::uint64_t groups) {
    PlannedEnsemble other = planned;
    other.spec.response.samples = groups * group_size;
    EnsembleRecord begun = begin_ensemble(other.spec);
    begun.configuration += "groups_drawn=0\n";
    make_folder(blocks.folder());
    for (const fs::path& file : {part, blocks.file(3), blocks.folder() / "4.part.h5"}) write_ensemble(file, begun);
  };
  for (const std::uint64_t grows_from : {std::uint64_t{0}, planned.grows_from}) {
    INFO(grows_from);
    leave(64);
    planned.grows_from = grows_from;
    look_for(planned, folder.path());
    REQUIRE(planned.reusable);
    obtain_ensemble(planned, folder.path(), 2, ProgressStyle::silent);
    CHECK_FALSE(fs::exists(part));
    CHECK_FALSE(fs::exists(blocks.folder()));
  }
  leave(128);
  look_for(planned, folder.path());
  obtain_ensemble(planned, folder.path(), 2, ProgressStyle::silent);
  for (const fs::path& file : {part, blocks.file(3), blocks.folder() / "4.part.h5"}) CHECK(fs::exists(file));
}
