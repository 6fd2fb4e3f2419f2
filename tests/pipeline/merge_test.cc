// What must not be merged, each with one message that names it.
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kit/temporary_folder.h"
#include "pipeline/run_folder.h"
#include "pipeline/shards.h"
#include "sharded_run.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

Experiment experiment(int seed = 5) {
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
    run_shard(experiment(), quiet(a), {1, 2});
    run_shard(experiment(), quiet(b), {2, 2});
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

TEST_CASE("the same block twice is taken once") {
  const Halves halves;
  fs::copy_file(halves.of_a(), halves.b / (blocks + "0.h5"));
  halves.merge();
  const TemporaryFolder one;
  CHECK(ensembles_in(halves.folder / "out") == undivided(experiment(), one.path()));
}

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
    run_shard(experiment(6), quiet(halves.a), {1, 2});
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
  run_shard(experiment(), quiet(halves.b), {3, 4});
  fs::remove(halves.of_a());
  fs::remove(halves.b / (blocks + "1.h5"));
  const std::string refusal = halves.refusal();
  CHECK_THAT(refusal, Contains("2 blocks are missing") && Contains("of mu = 0.3: 0 to 1"));
  // By the shards of the dealing into most, which has been seen in b.
  const std::string run = "granuscope run " + (halves.b / "experiment.toml").string() + " --shard ";
  CHECK_THAT(refusal, Contains(run + "1/4 --out " + halves.b.string()) && Contains(run + "2/4"));
  CHECK_THAT(refusal, !Contains("3/4"));
  run_shard(experiment(), quiet(halves.b), {1, 4});
  run_shard(experiment(), quiet(halves.b), {2, 4});
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
