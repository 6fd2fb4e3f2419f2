// Ensembles drawn in parts, by growing and by shards, and what must not be merged.
#include <catch2/catch.hpp>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "kit/temporary_folder.h"
#include "pipeline/block_files.h"
#include "pipeline/run_folder.h"
#include "pipeline/shards.h"
#include "sharded_run.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

// Drawn by shards, in any number and order, an ensemble has the bytes of one drawn in one piece.

namespace {

void draw_shards(const Experiment& experiment, const fs::path& folder, const std::vector<Shard>& shards) {
  for (const Shard& shard : shards) {
    RunOptions options = quiet(folder);
    options.threads = 1 + shard.number % 2;
    run_shard(experiment, options, shard);
  }
}

}  // namespace

TEST_CASE("a shard is named by its number or by the environment") {
  const TemporaryFolder folder;
  std::map<std::string, std::string> variables;
  const auto named = [&](const std::string& text) {
    const Shard shard = shard_named(
        text, [&](const char* name) { return variables[name]; }, folder.path());
    return std::pair{shard.number, shard.count};
  };
  CHECK(named("3/16") == std::pair{3, 16});
  for (const std::string wrong : {"0/3", "4/3", "3", "1/3/5", "a/b", "-1/3", "1/", "/3", "1/99999999"}) {
    CAPTURE(wrong);
    CHECK_THROWS_WITH(named(wrong), Contains("names no shard") && Contains("K/N"));
  }
  CHECK_THROWS_WITH(named("auto"), Contains("no variables of a Slurm array"));

  SECTION("a Slurm array, whatever its first number and step") {
    variables = {{"SLURM_ARRAY_TASK_ID", "7"},   {"SLURM_ARRAY_TASK_COUNT", "4"}, {"SLURM_ARRAY_TASK_MIN", "3"},
                 {"SLURM_ARRAY_TASK_STEP", "2"}, {"SLURM_PROCID", "0"},  // of the batch script, which is alone
                 {"SLURM_NTASKS", "2"}};
    CHECK(named("auto") == std::pair{3, 4});
    variables["SLURM_STEP_NUM_TASKS"] = "2";  // under srun
    variables["SLURM_PROCID"] = "1";
    CHECK(named("auto") == std::pair{6, 8});
    variables["SLURM_ARRAY_TASK_ID"] = "1";
    CHECK_THROWS_WITH(named("auto"), Contains("none of them"));
  }
  SECTION("a part of a Slurm array is none of a smaller one") {
    for (const std::string task : {"3", "7"}) {  // --array=3,7
      variables = {{"SLURM_ARRAY_TASK_ID", task},
                   {"SLURM_ARRAY_TASK_COUNT", "2"},
                   {"SLURM_ARRAY_TASK_MIN", "3"},
                   {"SLURM_ARRAY_TASK_MAX", "7"},
                   {"SLURM_ARRAY_TASK_STEP", "1"}};
      CHECK_THROWS_WITH(named("auto"), Contains("--shard K/N"));
    }
    variables = {{"SLURM_ARRAY_TASK_ID", "5"},
                 {"SLURM_ARRAY_TASK_COUNT", "1"},
                 {"SLURM_ARRAY_TASK_MIN", "5"},
                 {"SLURM_ARRAY_TASK_MAX", "5"}};  // one task again
    CHECK_THROWS_WITH(named("auto"), Contains("--shard K/N"));
    variables = {{"SLURM_ARRAY_TASK_ID", "6"},
                 {"SLURM_ARRAY_TASK_COUNT", "3"},
                 {"SLURM_ARRAY_TASK_MIN", "1"},
                 {"SLURM_ARRAY_TASK_MAX", "7"},
                 {"SLURM_ARRAY_TASK_STEP", "3"}};
    CHECK_THROWS_WITH(named("auto"), Contains("--shard K/N"));
    variables["SLURM_ARRAY_TASK_ID"] = "7";  // --array=1-7:3 is whole
    CHECK(named("auto") == std::pair{3, 3});
    variables = {{"SLURM_ARRAY_TASK_ID", "1"},
                 {"SLURM_ARRAY_TASK_COUNT", "1"},
                 {"SLURM_ARRAY_TASK_MIN", "1"},
                 {"SLURM_ARRAY_TASK_MAX", "1"}};
    CHECK(named("auto") == std::pair{1, 1});
    make_folder(folder / "shards");  // where an array of four has worked, this is its first task again
    write_file(folder / "shards/2-of-4", "");
    CHECK_THROWS_WITH(named("auto"), Contains("may be a part") && Contains("--shard K/4"));
    CHECK(named("1/1") == std::pair{1, 1});
  }
  SECTION("Open MPI") {
    variables = {{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "3"}};
    CHECK(named("auto") == std::pair{3, 3});
  }
  SECTION("MPICH") {
    variables = {{"PMI_RANK", "0"}, {"PMI_SIZE", "5"}};
    CHECK(named("auto") == std::pair{1, 5});
  }
}

TEST_CASE("blocks are dealt once each, and evenly by what they cost") {
  const std::vector<PlannedEnsemble> ensembles = all_ensembles(sharded_experiment(), {});
  REQUIRE(ensembles.size() == 5);
  double dearest = 0, all = 0;
  for (const PlannedEnsemble& one : ensembles) {
    dearest = std::max(dearest, relative_cost(one.spec));
    all += relative_cost(one.spec) * one.spec.response.blocks;
  }
  for (const int count : {1, 2, 3, 5, 16, 31}) {
    CAPTURE(count);
    std::set<std::pair<std::size_t, int>> dealt;
    const auto hands = deal(ensembles, count);
    REQUIRE(hands.size() == static_cast<std::size_t>(count));
    for (const auto& hand : hands) {
      double cost = 0;
      CHECK_FALSE(hand.empty());
      for (const Atom& atom : hand) {
        CHECK(dealt.insert({atom.ensemble, atom.block}).second);
        cost += relative_cost(ensembles[atom.ensemble].spec);
      }
      CHECK(cost <= all / count + dearest);
    }
    CHECK(dealt.size() == atoms_of(ensembles).size());
  }
  CHECK_THROWS_WITH(deal(ensembles, 1000), Contains("raise response.blocks"));
}

TEST_CASE("a shard that is stopped goes on where it was, and draws no block twice") {
  const Experiment experiment = sharded_experiment();
  const TemporaryFolder folder;
  request_interruption(true);
  CHECK_THROWS_AS(run_shard(experiment, quiet(folder.path()), {1, 2}), Interrupted);
  request_interruption(false);
  draw_shards(experiment, folder.path(), {{1, 2}});
  const auto drawn = ensembles_in(folder.path());
  std::map<std::string, fs::file_time_type> times;
  for (const auto& [file, bytes] : drawn) times[file] = fs::last_write_time(folder / file);

  // A damaged block and a foreign one are drawn again, others not.
  const std::string damaged = times.begin()->first, foreign = std::next(times.begin())->first;
  std::string bytes = drawn.at(damaged);
  bytes[bytes.size() - 9] = static_cast<char>(bytes[bytes.size() - 9] ^ 1);
  write_file(folder / damaged, bytes);
  write_file(folder / foreign, "not even HDF5");
  draw_shards(experiment, folder.path(), {{1, 2}});
  CHECK(ensembles_in(folder.path()) == drawn);
  for (const auto& [file, time] : times) {
    if (file != damaged && file != foreign) CHECK(fs::last_write_time(folder / file) == time);
  }
}

TEST_CASE("a shard of which no pile could be completed keeps its blocks, and is an experiment that cannot be used") {
  Experiment experiment = small_experiment();
  experiment.sampling.effort = 1;
  experiment.mu = {0.3};
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(run_shard(experiment, quiet(folder.path()), {1, 1}),
                    Contains("shard 1/1: no pile of its blocks could be completed; take"));
  CHECK_FALSE(ensembles_in(folder.path()).empty());
}

TEST_CASE("a block that was begun is gone on with") {
  // Parts are kept whenever there is something to keep, and the fourth group is interrupted.
  const TemporaryFolder folder, other;
  Experiment experiment = sharded_experiment();
  experiment.response.samples = 9 * 64;
  const std::vector<PlannedEnsemble> ensembles = plan_ensembles(experiment, folder.path());
  const PlannedEnsemble& planned = ensembles.at(1);
  const PartPolicy often = {0, 1e9};
  const BlockFiles files(planned, folder.path()), whole(planned, other.path());
  whole.draw(4, planned.spec.sampler, nullptr, {});
  int kept = 0;
  EnsembleRecord begun = begin_blocks(planned.spec, 4, 1);
  draw_in_pieces(planned.spec, planned.spec.sampler, 0, begun, 1, nullptr, often, [&](std::uint64_t groups) {
    if (++kept != 2) return;
    EnsembleRecord part = begun;
    part.configuration = block_configuration(planned, 4) + "groups_drawn=" + std::to_string(groups) + "\n";
    make_folder(files.folder());
    write_ensemble(files.folder() / "4.part.h5", part);
  });
  REQUIRE(kept >= 2);
  CHECK(files.count() == 0);
  files.draw(4, planned.spec.sampler, nullptr, {});
  CHECK(read_file(files.file(4)) == read_file(whole.file(4)));
  CHECK_FALSE(fs::exists(files.folder() / "4.part.h5"));
}

TEST_CASE("blocks at their places make the ensemble that copies of them make") {
  const TemporaryFolder one, other;
  const Experiment experiment = sharded_experiment();
  PlannedEnsemble planned = plan_ensembles(experiment, one.path()).at(1);
  const BlockFiles files(planned, other.path());
  obtain_ensemble(planned, one.path(), 1, ProgressStyle::silent);
  const std::string expected = read_file(one / planned.file.string());

  // Drawn and put by two processes; the second finds two blocks drawn already.
  const PlacedBlocks placed(planned, other.path());
  placed.begin();
  std::vector<BlockNote> notes(static_cast<std::size_t>(planned.spec.response.blocks));
  const auto shared = placed.open();
  files.draw(1, planned.spec.sampler, nullptr, {});
  files.draw(4, planned.spec.sampler, nullptr, {});
  const auto drawn = fs::last_write_time(files.file(4));
  int next = planned.spec.response.blocks;
  draw_atoms(
      {planned}, other.path(), 1, ProgressStyle::silent, nullptr, {},
      [&]() -> std::optional<Atom> {
        return next == 0 ? std::nullopt : std::optional(Atom{0, --next});
      },
      [&](const Atom& atom, const EnsembleRecord& block) {
        shared->put(static_cast<std::size_t>(atom.block), block.sums);
        notes.at(static_cast<std::size_t>(atom.block)) = note_of(block);
      });
  CHECK(fs::last_write_time(files.file(4)) == drawn);
  CHECK(files.count() == planned.spec.response.blocks);
  CHECK_FALSE(placed.finish());  // nobody knows yet that all are there

  const fs::path kept = files.folder() / "whole.notes";
  placed.keep_notes(notes);
  CHECK(placed.complete());
  SECTION("without a look at their files") {
    for (int block = 0; block < planned.spec.response.blocks; ++block) fs::remove(files.file(block));
  }
  SECTION("or with one, where the notes are damaged") {
    std::string bytes = read_file(kept);
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    write_file(kept, bytes);
    CHECK_FALSE(placed.complete());
  }
  SECTION("or those of another experiment") {
    PlannedEnsemble another = planned;
    another.spec.sampler.seed += 1;
    PlacedBlocks(another, other.path()).keep_notes(notes);
    CHECK_FALSE(placed.complete());
  }
  files.join(ProgressStyle::silent);
  CHECK(read_file(other / planned.file.string()) == expected);
  CHECK_FALSE(fs::exists(files.folder()));
}

TEST_CASE("blocks go on from the fewer piles that are there") {
  const TemporaryFolder one, other;
  Experiment few = sharded_experiment(), many = few;
  few.response.samples = 80;
  many.response.samples = 200;
  undivided(few, one.path());
  const auto whole = undivided(many, other.path());
  const PlannedEnsemble planned = plan_ensembles(many, one.path()).at(1);
  CHECK(planned.groups_before == 10);
  BlockFiles(planned, one.path()).complete(2, ProgressStyle::silent, {});
  CHECK(read_file(one / planned.file.string()) == whole.at(planned.file.string()));
}

TEST_CASE("an ensemble too large to be drawn in memory has the same bytes") {
  const TemporaryFolder folder;
  PlannedEnsemble planned;
  planned.label = "large";
  planned.file = "ensembles/large.h5";
  planned.spec.sampler.mu = 0;
  planned.spec.lattice = {2000, 53};
  planned.spec.response.samples = 256;
  for (int layer = 0; layer < 33; ++layer) planned.spec.layers.push_back(layer);  // 17 MB
  const MeasuredEnsemble drawn = obtain_ensemble(planned, folder.path(), 2, ProgressStyle::silent);
  CHECK(drawn.record.sums.elsewhere != nullptr);
  const std::string bytes = read_file(folder / "ensembles/large.h5");
  write_ensemble(folder / "at-once.h5", run_ensemble(planned.spec, 2, nullptr));
  CHECK(bytes == read_file(folder / "at-once.h5"));
}

TEST_CASE("the plan of a shard has its own blocks, and that of a run what shards have drawn") {
  const Experiment experiment = sharded_experiment();
  const TemporaryFolder folder;
  const auto left = [&](const std::vector<PlannedStep>& steps) {
    std::uint64_t samples = 0;
    for (const PlannedStep& step : steps) samples += step.stage == Stage::sample ? step.samples : 0;
    return samples;
  };
  const RunOptions options = quiet(folder.path(), {Stage::sample});
  const std::uint64_t all = left(plan_run(experiment, options));
  std::uint64_t together = 0;
  for (const int number : {1, 2, 3}) together += left(plan_shard(experiment, options, {number, 3}));
  CHECK(together == all);
  CHECK(fs::is_empty(folder.path()));  // nothing is written
  run_shard(experiment, options, {2, 3});
  const auto drawn = plan_shard(experiment, options, {2, 3});
  REQUIRE_FALSE(drawn.empty());
  CHECK(left(drawn) == 0);
  CHECK(drawn.front().reused);
  CHECK(left(plan_run(experiment, options)) ==
        left(plan_shard(experiment, options, {1, 3})) + left(plan_shard(experiment, options, {3, 3})));
}

TEST_CASE("shards keep off each other and off other experiments") {
  const Experiment experiment = sharded_experiment();
  const TemporaryFolder folder;
  draw_shards(experiment, folder.path(), {{1, 20}});
  {
    const RunFolder at_work(folder.path());
    CHECK_THROWS_WITH(run_shard(experiment, quiet(folder.path()), {2, 20}), Contains("another run is working"));
  }
  {
    const RunFolder at_work(folder.path(), FolderUse::shared);
    CHECK_NOTHROW(run_shard(experiment, quiet(folder.path()), {2, 20}));
    CHECK_THROWS_WITH(undivided(experiment, folder.path()), Contains("another run or shard is working"));
  }
  Experiment other = experiment;
  other.sampling.seed = 6;
  CHECK_THROWS_WITH(run_shard(other, quiet(folder.path()), {2, 20}),
                    Contains("experiment.toml") && Contains("another experiment"));
}

// What must not be merged, each with one message that names it.

namespace {

Experiment shared_experiment(int seed = 5) {
  Experiment experiment = sharded_experiment();
  experiment.mu = {0.3};
  experiment.studies = {};
  experiment.sampling.seed = static_cast<std::uint64_t>(seed);
  return experiment;
}

const std::string blocks = "ensembles/mu-0.3.blocks/";

/// Two folders, a and b, with half of the blocks each.
struct Halves {
  TemporaryFolder folder;
  fs::path a = folder / "a", b = folder / "b";
  Halves() {
    run_shard(shared_experiment(), quiet(a), {1, 2});
    run_shard(shared_experiment(), quiet(b), {2, 2});
  }
  fs::path of_a() const { return a / (blocks + "0.h5"); }

  void merge() const { merge_folders({a, b}, folder / "out", ProgressStyle::silent); }
  std::string refusal() const {
    try {
      merge();
    } catch (const InputError& error) {
      CHECK_FALSE(fs::exists(folder / "out/ensembles/mu-0.3.h5"));
      return error.what();
    }
    return "it was merged";
  }
};

void change(const fs::path& file, const std::function<void(EnsembleRecord&)>& what) {
  EnsembleRecord record = read_ensemble(file);
  what(record);
  record.configuration_key = cache_key(record.configuration);
  write_ensemble(file, record);
}

void replace_in(std::string& text, const std::string& from, const std::string& to) {
  REQUIRE(text.find(from) != std::string::npos);
  text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("hostile folders are not merged, and nothing of them is lost") {
  const Halves halves;
  const fs::path zero = halves.of_a();
  SECTION("the same block with other numbers") {
    fs::copy_file(zero, halves.b / (blocks + "0.h5"));
    change(zero, [](EnsembleRecord& one) { one.sums.quantities.at("weight").sum[3] += 1; });
    CHECK_THAT(halves.refusal(), Contains("a/" + blocks + "0.h5") && Contains("b/" + blocks + "0.h5") &&
                                     Contains("block 0 of mu = 0.3 with different numbers"));
  }
  SECTION("the same block, counted differently") {
    fs::copy_file(zero, halves.b / (blocks + "0.h5"));
    change(zero, [](EnsembleRecord& one) { ++one.counts.uniforms; });
    CHECK_THAT(halves.refusal(), Contains("with different numbers"));
  }
  SECTION("half a file") {
    const std::string bytes = read_file(zero);
    write_file(zero, bytes.substr(0, bytes.size() / 2));
    CHECK_THAT(halves.refusal(), Contains("a/" + blocks + "0.h5") && Contains("cut short"));
  }
  SECTION("a bit flipped") {
    std::string bytes = read_file(zero);
    bytes[bytes.size() - 100] = static_cast<char>(bytes[bytes.size() - 100] ^ 4);
    write_file(zero, bytes);
    CHECK_THAT(halves.refusal(), Contains("a/" + blocks + "0.h5") && Contains("damaged"));
  }
  SECTION("a foreign file") {
    write_file(zero, "c,D\n1,2\n");
    CHECK_THAT(halves.refusal(), Contains("a/" + blocks + "0.h5") && Contains("not an HDF5 file"));
  }
  SECTION("another seed") {
    fs::remove_all(halves.a);
    run_shard(shared_experiment(6), quiet(halves.a), {1, 2});
    CHECK_THAT(halves.refusal(), Contains("another experiment") && Contains("seed = 6 where 5 is there"));
  }
  SECTION("another version of the sampling") {
    change(zero, [](EnsembleRecord& one) {
      const std::string line = "sampling_version=" + one.sampling_version + "\n";
      replace_in(one.configuration, line, "sampling_version=0\n");
    });
    CHECK_THAT(halves.refusal(),
               Contains("another experiment") && Contains("sampling_version =") && Contains("where 0 is there"));
  }
  SECTION("a block under another one's name") {
    fs::rename(zero, halves.a / (blocks + "8.h5"));
    CHECK_THAT(halves.refusal(), Contains("block = 8 where 0 is there"));
  }
  SECTION("an ensemble that nobody asked for") {
    fs::create_directories(halves.a / "ensembles/mu-0.4.blocks");
    CHECK_THAT(halves.refusal(), Contains("mu-0.4.blocks") && Contains("does not have"));
  }
  SECTION("no folder") {
    CHECK_THROWS_WITH(merge_folders({halves.folder / "c"}, halves.a, ProgressStyle::silent), Contains("is no folder"));
  }
  SECTION("no experiment") {
    CHECK_THROWS_WITH(merge_folders({halves.folder.path()}, halves.a, ProgressStyle::silent),
                      Contains("no experiment.toml"));
  }
  CHECK(ensembles_in(halves.b).size() >= 4);
}

TEST_CASE("folders at work are not merged, and the same folder twice is one") {
  const Halves halves;
  {
    const RunFolder at_work(halves.b, FolderUse::shared);
    CHECK_THROWS_AS(halves.merge(), BusyError);
  }
  CHECK_NOTHROW(merge_folders({halves.a, halves.b, halves.a / "."}, halves.a, ProgressStyle::silent));
}

TEST_CASE("missing blocks are listed with the commands that draw them") {
  const Halves halves;
  run_shard(shared_experiment(), quiet(halves.b), {3, 4});
  fs::remove(halves.of_a());
  fs::remove(halves.b / (blocks + "1.h5"));
  const std::string refusal = halves.refusal();
  CHECK_THAT(refusal, Contains("2 blocks are missing") && Contains("of mu = 0.3: 0 to 1"));
  // By the shards of the dealing into most, which has been seen in b.
  const std::string run = "granuscope run " + (halves.b / "experiment.toml").string() + " --shard ";
  CHECK_THAT(refusal, Contains(run + "1/4 --out " + halves.b.string()) && Contains(run + "2/4"));
  CHECK_THAT(refusal, !Contains("3/4"));
  run_shard(shared_experiment(), quiet(halves.b), {1, 4});
  run_shard(shared_experiment(), quiet(halves.b), {2, 4});
  CHECK_NOTHROW(halves.merge());
}

TEST_CASE("Blocks of another shape than the experiment makes are refused, and nothing is removed") {
  const Halves halves;
  const std::string sound = read_file(halves.of_a());
  const std::vector<std::function<void(EnsembleRecord&)>> damages = {
      [](EnsembleRecord& record) { ++record.sums.layers.back(); },
      [](EnsembleRecord& record) { record.sums.count[0] += 8; },
      [](EnsembleRecord& record) {
        auto part = record.sums.quantities.extract(record.sums.quantities.begin());
        part.key() = "other";
        record.sums.quantities.insert(std::move(part));
      },
      [](EnsembleRecord& record) {
        record.failed.push_back({1, 1, "granuscope sample; curl x"});
      }};
  for (const auto& damage : damages) {
    write_file(halves.of_a(), sound);
    change(halves.of_a(), damage);
    CHECK_THAT(halves.refusal(), Contains("than its configuration says"));
    CHECK(fs::exists(halves.of_a()));
  }
}
