// What an ensemble is, its blocks, its units and its time.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "ensemble/small_ensemble.h"
#include "kit/same_bytes.h"
#include "kit/sanitized.h"
#include "kit/standard_error_capture.h"
#include "kit/temporary_folder.h"
#include "sampling/polytope.h"
#include "sampling/sampler.h"
#include "storage/hdf5_file.h"
#include "storage/record_comparison.h"
#include "storage/sample_records.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using test::same_bytes;

// Source: the documented limits of an ensemble, and the contracts of progress and interruption.

EnsembleSpec sound() {
  EnsembleSpec spec;
  spec.sampler.mu = 0.2;
  spec.lattice = {.columns = 8, .layers = 6};
  spec.response.samples = 80;
  spec.response.blocks = 8;
  return spec;
}

TEST_CASE("ensembles that would mean nothing are refused before a pile is drawn") {
  CHECK_NOTHROW(validate(sound()));
  const auto refused = [](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    CHECK_THROWS_AS(validate(spec), InputError);
    CHECK_THROWS_AS(run_ensemble(spec, 2, nullptr), InputError);
  };
  refused([](EnsembleSpec& s) { s.response.blocks = 7; });
  refused([](EnsembleSpec& s) { s.response.blocks = -1; });
  refused([](EnsembleSpec& s) { s.lattice.angle = 61; });
  refused([](EnsembleSpec& s) { s.lattice.angle = 60, s.sampler.mu = 0.6; });  // beyond 1/tan(angle)
  refused([](EnsembleSpec& s) { s.lattice.angle = 45, s.sampler.load_angle = 2; });
  refused([](EnsembleSpec& s) { s.lattice.angle = 45, s.sampler.model.name = ModelName::q_model; });
  refused([](EnsembleSpec& s) { s.response.samples = 56; });  // seven groups for eight blocks
  refused([](EnsembleSpec& s) { s.response.samples = 0; });
  refused([](EnsembleSpec& s) { s.response.samples = (std::uint64_t{1} << 32) + 1; });  // more than one seed names
  refused([](EnsembleSpec& s) { s.response.overload = 0; });
  refused([](EnsembleSpec& s) { s.response.overload = -1; });
  refused([](EnsembleSpec& s) { s.response.overload = std::numeric_limits<double>::quiet_NaN(); });
  refused([](EnsembleSpec& s) { s.response.overload = std::numeric_limits<double>::infinity(); });
  refused([](EnsembleSpec& s) { s.layers = {0, 6}; });
  refused([](EnsembleSpec& s) { s.layers = {-1}; });
  refused([](EnsembleSpec& s) { s.layers = {2, 1}; });
  refused([](EnsembleSpec& s) { s.layers = {1, 1}; });
  refused([](EnsembleSpec& s) { s.lattice.columns = 3; });
  refused([](EnsembleSpec& s) { s.lattice.layers = 0; });
}

TEST_CASE("what is wrong is told by the key of the number that should change") {
  const auto key_after = [](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    const auto found = find_problem(spec);
    return found ? found->key : "none";
  };
  CHECK(key_after([](EnsembleSpec&) {}) == "none");
  CHECK(key_after([](EnsembleSpec& s) { s.lattice.layers = 0; }) == "layers");
  CHECK(key_after([](EnsembleSpec& s) { s.sampler.max_tries = 0; }) == "max_tries");
  CHECK(key_after([](EnsembleSpec& s) { s.sampler.lambda = 0.5; }) == "lambda");
  CHECK(key_after([](EnsembleSpec& s) { s.response.epsilon = least_epsilon / 2; }) == "epsilon");
  CHECK(key_after([](EnsembleSpec& s) { s.response.overload = 2e6; }) == "overload");
  CHECK(key_after([](EnsembleSpec& s) { s.response.opposite = true; }) == "opposite");
  CHECK(key_after([](EnsembleSpec& s) { s.response = multiplexed_response(0.25, true, 2); }) == "sign_run");
  CHECK(key_after([](EnsembleSpec& s) { s.response.samples = 56; }) == "samples");
  EnsembleSpec spec = sound();
  spec.response.blocks = 7;
  CHECK_THROWS_WITH(validate(spec), Catch::StartsWith("blocks: 7 is out of range"));
}

TEST_CASE("a sampler that cannot be made is told from any thread") {
  EnsembleSpec spec = sound();
  spec.sampler.mu = 1.8;
  CHECK_THROWS_AS(run_ensemble(spec, 3, nullptr), InputError);
  spec = sound();
  spec.sampler.effort = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(run_ensemble(spec, 3, nullptr), InputError);
}

TEST_CASE("absurd numbers of samples are called too many") {
  EnsembleSpec spec = sound();
  spec.response.samples = std::numeric_limits<std::uint64_t>::max();
  CHECK_THROWS_WITH(validate(spec), Catch::Contains("too many"));
}

TEST_CASE("a replay command holds whatever decides where a pile fails") {
  EnsembleSpec spec = sound();
  CHECK(replay_command(spec, 3).find("--max-tries") == std::string::npos);
  spec.sampler.law = Law::rejection;
  spec.sampler.max_tries = 50;
  CHECK_THAT(replay_command(spec, 3), Catch::Contains(" --max-tries 50 "));
}

TEST_CASE("the load is one on every top bead, and more on the middle one") {
  EnsembleSpec spec = sound();
  spec.response.overload = 0.25;
  std::vector<double> expected(8, 1.0);
  spec.load = Load::uniform;
  CHECK(top_load(spec) == expected);
  spec.load = Load::point;
  expected[4] = 1.25;
  CHECK(top_load(spec) == expected);
  CHECK(load_named("uniform") == Load::uniform);
  CHECK(load_named("point") == Load::point);
  CHECK_THROWS_AS(load_named("line"), InputError);
}

TEST_CASE("the configuration tells apart whatever changes the numbers, and nothing else") {
  std::set<std::string> texts;
  std::size_t variants = 0;
  const auto variant = [&](auto change) {
    EnsembleSpec spec = sound();
    change(spec);
    texts.insert(configuration_text(spec));
    ++variants;
  };
  variant([](EnsembleSpec&) {});
  variant([](EnsembleSpec& s) { s.sampler.mu = std::nextafter(0.2, 1.0); });
  variant([](EnsembleSpec& s) { s.sampler.seed = 2; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::rejection; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::eloy_clement; });
  variant([](EnsembleSpec& s) { s.sampler.law = Law::polytope; });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.lambda = 0.5;
  });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.burn_in = 100;
  });
  variant([](EnsembleSpec& s) {
    s.sampler.law = Law::polytope;
    s.sampler.thinning = 10;
  });
  variant([](EnsembleSpec& s) { s.sampler.effort = 100; });
  variant([](EnsembleSpec& s) { s.sampler.max_tries = 5; });
  variant([](EnsembleSpec& s) { s.sampler.order = LayerOrder::fixed; });
  variant([](EnsembleSpec& s) { s.lattice.columns = 9; });
  variant([](EnsembleSpec& s) { s.lattice.layers = 7; });
  variant([](EnsembleSpec& s) { s.lattice.angle = 45; });
  variant([](EnsembleSpec& s) { s.load = Load::uniform; });
  variant([](EnsembleSpec& s) { s.response.overload = 0.5; });
  variant([](EnsembleSpec& s) { s.response.samples = 81; });
  variant([](EnsembleSpec& s) { s.response.blocks = 9; });
  variant([](EnsembleSpec& s) { s.layers = {2}; });
  variant([](EnsembleSpec& s) { s.record_profiles = false; });
  variant([](EnsembleSpec& s) { s.record_H = true; });
  CHECK(texts.size() == variants);
  // All layers by name or by default, and an overload that a uniform load does not have, are the same ensemble.
  EnsembleSpec named = sound();
  named.layers = {0, 1, 2, 3, 4, 5};
  CHECK(configuration_text(named) == configuration_text(sound()));
  EnsembleSpec a = sound(), b = sound();
  a.load = b.load = Load::uniform;
  b.response.overload = 3;
  CHECK(configuration_text(a) == configuration_text(b));
}

TEST_CASE("a stored configuration is read back as the ensemble that it tells of") {
  std::vector<EnsembleSpec> all(6, sound());
  all[1].sampler.law = Law::polytope;
  all[1].sampler.lambda = 0.1;
  all[1].sampler.burn_in = 7;
  all[1].sampler.seed = ~std::uint64_t{0};
  all[1].layers = {1, 4};
  all[1].response.estimator = EstimatorName::paired;
  all[2].response = multiplexed_response(1.0 / 3, true, 2);
  all[2].sampler.load_angle = -1.5;
  all[2].record_H = true;
  all[2].record_profiles = false;
  all[3].response.estimator = EstimatorName::fluctuation;
  all[3].response.base_step = 5;
  all[4].load = Load::uniform;
  all[4].sampler.model.name = ModelName::three_leg;
  all[4].sampler.model.three_leg = {.law = MiddleLaw::clipped, .noise = 0.01};
  all[5].sampler.model.name = ModelName::stochastic_osl;
  all[5].sampler.model.stochastic_osl = {
      .disorder = 0.1, .cell_columns = 2, .cell_rows = 3, .noise = NoiseLaw::gaussian};
  for (const ModelName model : {ModelName::q_model, ModelName::diluted_beads}) {
    all.push_back(sound());
    all.back().sampler.model.name = model;
    all.back().sampler.model.q_model = {SplitLaw::beta, 0.5};
    all.back().sampler.model.diluted_beads.share = 0.125;
  }
  for (const EnsembleSpec& spec : all) {
    const std::string text = configuration_text(spec);
    INFO(text);
    CHECK(configuration_text(ensemble_configured(text + "groups_drawn=3\n")) == text);
  }
  CHECK_THROWS_WITH(ensemble_configured("columns=many\n"), Catch::StartsWith("columns: many is not a whole number"));
}

TEST_CASE("progress is advanced by one for each sample, failed ones included") {
  EnsembleSpec spec = sound();
  spec.load = Load::point;
  spec.response.overload = 1e6;  // too isolated to be solved: some piles fail
  spec.sampler.effort = 2;
  test::StandardErrorCapture capture;
  Progress progress("sampling", 80, ProgressStyle::plain);
  const EnsembleRecord record = run_ensemble(spec, 2, &progress);
  progress.finish();
  // Were it not complete, the closing line would read 79/80 or the like.
  CHECK_THAT(capture.text(), Catch::Contains("sampling: 80 in "));
  CHECK_FALSE(record.failed.empty());
}

TEST_CASE("a request to stop ends the ensemble with Interrupted") {
  request_interruption(true);
  CHECK_THROWS_AS(run_ensemble(sound(), 2, nullptr), Interrupted);
  request_interruption(false);
  CHECK_NOTHROW(run_ensemble(sound(), 2, nullptr));
}

// Source of the expected numbers: every pile drawn by itself and summed in the order of its number, straight from the
// definitions of the quantities; equality is exact.

EnsembleSpec small_ensemble() {
  EnsembleSpec spec = test::small_ensemble(ResponseSpec{.overload = 1}, 10);
  spec.lattice.layers = 12;
  spec.response.samples = 8 * 11 + 3;  // the last group is not full, and 12 groups do not divide evenly among 8 blocks
  return spec;
}

TEST_CASE("block sums are the sums over separately drawn piles, exactly") {
  for (const bool profiles : {true, false}) {
    for (const std::vector<int>& layers : {std::vector<int>{}, {0, 3, 11}}) {
      for (const Load load : {Load::uniform, Load::point}) {
        EnsembleSpec spec = small_ensemble();
        spec.record_profiles = profiles;
        spec.layers = layers;
        spec.load = load;
        spec.response.overload = 0.75;
        const EnsembleRecord record = run_ensemble(spec, 1, nullptr);

        const Lattice lattice(spec.lattice);
        std::vector<int> recorded = layers;
        if (recorded.empty()) {
          recorded.resize(12);
          std::iota(recorded.begin(), recorded.end(), 0);
        }
        REQUIRE(record.sums.layers == recorded);
        REQUIRE(record.sums.blocks() == spec.response.blocks);
        CHECK(record.sums.quantities.count("weight") == (profiles ? 1U : 0U));

        // Blocks take turns at the groups of eight; all samples are in.
        std::uint64_t seen = 0;
        const std::size_t n_layers = recorded.size();
        for (std::size_t block = 0; block < 8; ++block) {
          INFO("block " << block);
          std::vector<double> thrust(n_layers), thrust2(n_layers), variance(n_layers), variance2(n_layers);
          std::vector<double> weight(n_layers * 10), weight2(n_layers * 10);
          std::uint64_t count = 0;
          for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
            if (sample / 8 % 8 != block) continue;
            ++count;
            // A sampler of its own for every pile.
            Pile pile(lattice);
            REQUIRE_FALSE(make_sampler(spec.sampler, lattice)->draw(sample, top_load(spec), pile).has_value());
            double total = 0;
            for (const double force : pile.load) total += force;
            for (std::size_t l = 0; l < n_layers; ++l) {
              double sum_H = 0, sum_squares = 0;
              for (int i = 0; i < 10; ++i) {
                const std::size_t at = lattice.index(recorded[l], i);
                const double w = pile.V_R[at] + pile.V_L[at];
                sum_H += pile.H_R[at] - pile.H_L[at];
                sum_squares += (w - 1) * (w - 1);
                weight[l * 10 + static_cast<std::size_t>(i)] += w;
                weight2[l * 10 + static_cast<std::size_t>(i)] += w * w;
              }
              const double alpha = sqrt3 * sum_H / total;
              thrust[l] += alpha, thrust2[l] += alpha * alpha;
              variance[l] += sum_squares / 10, variance2[l] += (sum_squares / 10) * (sum_squares / 10);
            }
          }
          const auto block_of = [&](const std::vector<double>& all, std::size_t width) {
            const auto from = all.begin() + static_cast<std::ptrdiff_t>(block * n_layers * width);
            return std::vector<double>(from, from + static_cast<std::ptrdiff_t>(n_layers * width));
          };
          const auto check = [&](const std::string& name, std::size_t width, const std::vector<double>& sum,
                                 const std::vector<double>& squares) {
            const QuantitySums& sums = record.sums.quantities.at(name);
            REQUIRE(sums.width == static_cast<int>(width));
            CHECK(same_bytes(block_of(sums.sum, width), sum));
            CHECK(sums.has_squares() == (width == 1));
            if (sums.has_squares()) {
              CHECK(same_bytes(block_of(sums.sum_of_squares, width), squares));
            } else {
              CHECK(sums.sum_of_squares.empty());
            }
          };
          check("thrust", 1, thrust, thrust2);
          check("weight_variance", 1, variance, variance2);
          if (profiles) check("weight", 10, weight, weight2);
          CHECK(record.sums.count[block] == count);
          seen += count;
        }
        CHECK(seen == spec.response.samples);
        CHECK(record.counts.beads == spec.response.samples * lattice.beads());
        CHECK(record.failed.empty());
      }
    }
  }
}

TEST_CASE("blocks hold whole groups of eight and differ by one group at most") {
  for (const std::uint64_t samples : {57U, 64U, 65U, 100U, 256U, 1000U}) {
    for (const int blocks : {8, 9, 32}) {
      EnsembleSpec spec = small_ensemble();
      spec.lattice = {.columns = 4, .layers = 1};
      spec.response.samples = samples;
      spec.response.blocks = blocks;
      INFO("samples " << samples << ", blocks " << blocks);
      if ((samples + 7) / 8 < static_cast<std::uint64_t>(blocks)) {
        CHECK_THROWS_AS(validate(spec), InputError);
        continue;
      }
      const std::vector<std::uint64_t> count = run_ensemble(spec, 1, nullptr).sums.count;
      CHECK(std::accumulate(count.begin(), count.end(), std::uint64_t{0}) == samples);
      std::uint64_t fewest = samples, most = 0;
      for (std::size_t block = 0; block < count.size(); ++block) {
        const std::uint64_t groups = (count[block] + 7) / 8;
        fewest = std::min(fewest, groups), most = std::max(most, groups);
        const bool has_last = block == (samples - 1) / 8 % count.size();
        CHECK(count[block] % 8 == (has_last ? samples % 8 : 0));
      }
      CHECK(fewest >= 1);
      CHECK(most <= fewest + 1);
    }
  }
}

TEST_CASE("an ensemble drawn piece by piece is the ensemble drawn at once, bit for bit") {
  for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
    EnsembleSpec spec = small_ensemble();
    spec.response.estimator = estimator;
    spec.response.samples = 8 * 50 + 5;
    spec.sampler.effort = 1.16;  // so that some piles fail, in every piece
    INFO(name_of(estimator));
    const EnsembleRecord whole = run_ensemble(spec, 2, nullptr);
    CHECK(whole.failed.size() > 8);
    REQUIRE(groups_of(spec) == 51);
    REQUIRE(spec.response.blocks == 8);
    EnsembleRecord pieces = begin_ensemble(spec);
    add_groups(spec, 0, 5, pieces, 1, nullptr);  // not one of every block
    CHECK_FALSE(same_bytes(pieces, whole));
    add_groups(spec, 5, 43, pieces, 3, nullptr);
    add_groups(spec, 43, 51, pieces, 2, nullptr);
    CHECK(same_bytes(pieces, whole));
  }
}

TEST_CASE("an ensemble of fewer whole groups is the beginning of one of more") {
  EnsembleSpec few = small_ensemble(), many = small_ensemble();
  few.response.samples = 8 * 19;       // two of each block, and one more of three
  many.response.samples = 8 * 41 + 3;  // an incomplete one at the end
  EnsembleRecord grown = run_ensemble(few, 2, nullptr);
  add_groups(many, groups_of(few), groups_of(many), grown, 2, nullptr);
  const EnsembleRecord at_once = run_ensemble(many, 2, nullptr);
  CHECK(grown.configuration != at_once.configuration);  // it still names the number of samples it began with
  grown.configuration = at_once.configuration;
  CHECK(same_bytes(grown, at_once));
  // Each sample once, in the block of its group.
  std::set<std::uint64_t> seen;
  for (int block = 0; block < many.response.blocks; ++block) {
    std::uint64_t in_block = 0;
    for (std::uint64_t group = group_of_block(many, block, 0); group < groups_of(many);
         group = group_of_block(many, block, group + 1)) {
      const SampleRange samples = samples_of(many, group);
      CHECK(samples.first / 8 % 8 == static_cast<std::uint64_t>(block));
      for (std::uint64_t sample = samples.first; sample < samples.end; ++sample) seen.insert(sample);
      in_block += samples.size();
      CHECK(samples_in_block(many, block, group + 1) == in_block);
    }
    CHECK(at_once.sums.count.at(static_cast<std::size_t>(block)) == in_block);
  }
  CHECK(seen.size() == many.response.samples);
  CHECK(*seen.rbegin() == many.response.samples - 1);
}

TEST_CASE("a pile that runs out of effort is listed with its replay command and enters no sum") {
  EnsembleSpec spec = small_ensemble();
  spec.load = Load::point;
  spec.response.overload = 500;  // so large that some piles complete and some do not
  spec.sampler.effort = 3;
  spec.lattice = {.columns = 20, .layers = 40};
  spec.response.samples = 128;
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const std::uint64_t in = std::accumulate(record.sums.count.begin(), record.sums.count.end(), std::uint64_t{0});
  CAPTURE(in, record.failed.size());
  REQUIRE_FALSE(record.failed.empty());
  REQUIRE(in > 0);
  CHECK(in + record.failed.size() == spec.response.samples);

  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  std::size_t next = 0;
  Pile pile(lattice);
  double weight_of_middle = 0;
  for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
    const auto failure = sampler->draw(sample, top_load(spec), pile);
    if (!failure) {
      const std::size_t at = lattice.index(39, 3);
      weight_of_middle += pile.V_R[at] + pile.V_L[at];
      continue;
    }
    // Listed in the order of the samples.
    REQUIRE(next < record.failed.size());
    const FailedSample& listed = record.failed[next++];
    CHECK(listed.sample == sample);
    CHECK(listed.layer == failure->layer);
    CHECK(listed.replay == replay_command(spec, sample));
    CHECK(listed.replay.find("granuscope sample --law granusolve --mu 0.3 ") == 0);
    for (const std::string& part :
         std::vector<std::string>{"--columns 20 ", "--layers 40 ", "--load point ", "--overload 500 ", "--effort 3 ",
                                  "--seed 7 ", "--sample " + std::to_string(sample) + " "}) {
      INFO(listed.replay);
      CHECK(listed.replay.find(part) != std::string::npos);
    }
  }
  CHECK(next == record.failed.size());
  double recorded = 0;
  const QuantitySums& weight = record.sums.quantities.at("weight");
  for (std::size_t block = 0; block < 8; ++block) recorded += weight.sum[(block * 40 + 39) * 20 + 3];
  CHECK(recorded == Approx(weight_of_middle).epsilon(1e-12));
}

TEST_CASE("rejection and the frictionless pile run as ensembles, too") {
  EnsembleSpec spec = small_ensemble();
  spec.lattice = {.columns = 4, .layers = 3};
  spec.sampler.law = Law::rejection;
  const EnsembleRecord rejected = run_ensemble(spec, 2, nullptr);
  CHECK(rejected.counts.tries > spec.response.samples);
  CHECK(rejected.failed.empty());
  spec = small_ensemble();
  spec.sampler.mu = 0;
  const EnsembleRecord straight = run_ensemble(spec, 2, nullptr);
  const QuantitySums& thrust = straight.sums.quantities.at("thrust");
  // Without friction alpha = 1 in every layer of every pile.
  for (std::size_t k = 0; k < thrust.sum.size(); ++k) {
    const auto count = static_cast<double>(straight.sums.count[k / 12]);
    CHECK(thrust.sum[k] == Approx(count).epsilon(1e-14));
  }
}

// Source: merging is adding.

TEST_CASE("every counter is merged, stored and read back") {
  EnsembleRecord whole = test::awkward_ensemble(), part = whole, expected = whole;
  whole.failed.clear();
  std::uint64_t count = 1;
  for (const auto& [name, counter] : sampler_counters) {
    whole.counts.*counter = count;
    part.counts.*counter = count << 20;
    expected.counts.*counter = count + (count << 20);
    ++count;
  }
  merge_into(whole, part);
  for (const auto& [name, counter] : sampler_counters) {
    INFO(name);
    CHECK(whole.counts.*counter == expected.counts.*counter);
  }
  const test::TemporaryFolder folder;
  write_ensemble(folder / "merged.h5", whole);
  test::check_same(read_ensemble(folder / "merged.h5"), whole);
}

/// Threads of this process.
int threads_now() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("Threads:")) return std::atoi(line.c_str() + 8);
  }
  return -1;
}

TEST_CASE("every index is handled once, and no more threads are started than there are indices") {
  constexpr std::size_t count = 5;
  std::vector<std::atomic<int>> handled(count);
  std::atomic<int> most = 0;
  const int before = threads_now();
  REQUIRE(before >= 1);
  for_each_index(count, 3000, [&](std::size_t i) {
    ++handled[i];
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const int now = threads_now();
    for (int known = most; now > known && !most.compare_exchange_weak(known, now);) {
    }
  });
  for (const std::atomic<int>& times : handled) CHECK(times == 1);
  CHECK(most <= before + static_cast<int>(count));
  int bodies = 0;
  for_each_index(0, 4, [&](std::size_t) { ++bodies; });
  CHECK(bodies == 0);
}

}  // namespace

// Whoever reads an ensemble file without this program finds in it what each of its numbers is.

namespace {

std::vector<EnsembleSpec> an_ensemble_of_every_kind() {
  std::vector<EnsembleSpec> all;
  all.push_back(test::small_ensemble(ResponseSpec{.overload = 1}, 24));
  all.push_back(test::small_ensemble({.estimator = EstimatorName::paired}, 24));
  all.push_back(test::small_ensemble(multiplexed_response(0.2), 24));
  all.push_back(all.back());
  all.back().sampler.model.name = ModelName::three_leg;
  all.push_back(test::small_ensemble({.estimator = EstimatorName::fluctuation}, 24));
  all.back().response.first_base = 20;
  all.back().response.reference_lag = 4;
  all.back().response.base_step = 2;
  all.back().lattice.layers = 60;
  all.back().layers = {1, 3, 8};
  return all;
}

}  // namespace

TEST_CASE("every dataset of an ensemble file has its unit and its axes") {
  const test::TemporaryFolder folder;
  for (const EnsembleSpec& spec : an_ensemble_of_every_kind()) {
    INFO(configuration_text(spec));
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    write_ensemble(folder / "e.h5", record);
    const Hdf5Reader file(folder / "e.h5", "an ensemble file");
    std::vector<std::string> datasets = {"/count", "/layers",       "/block_keys",    "/x",
                                         "/z",     "/failed/layer", "/failed/replay", "/failed/sample"};
    for (const auto& [name, sums] : record.sums.quantities) {
      datasets.push_back("/" + name + "/sum");
      datasets.push_back("/" + name + "/sum_of_squares");
    }
    std::size_t found = 0;
    for (const std::string& dataset : datasets) {
      if (!file.has_dataset(dataset)) continue;
      INFO(dataset);
      ++found;
      CHECK_FALSE(file.text(dataset, "units").empty());
      CHECK_FALSE(file.text(dataset, "axes").empty());
    }
    const bool of_lags = spec.response.estimator == EstimatorName::fluctuation;
    CHECK(found + (of_lags ? 2 : 0) + 1 == datasets.size());  // a profile has no squares, and a lag lies nowhere
    if (!of_lags) CHECK(file.shape("/x") == Shape{2, 24});
  }
}

namespace {

// What is estimated is held against the processor time of the same ensemble, drawn by the same program on the same
// core.

using enum EstimatorName;

EnsembleSpec ensemble(Law law, double mu, LatticeSpec lattice, std::uint64_t samples, EstimatorName estimator = point) {
  EnsembleSpec spec;
  spec.sampler.law = law;
  spec.sampler.mu = mu;
  spec.lattice = lattice;
  spec.response.samples = samples;
  spec.response.blocks = 8;
  spec.response.estimator = estimator;
  return spec;
}

double real_seconds(const EnsembleSpec& spec) {
  const double start = processor_seconds();
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  REQUIRE_FALSE(record.sums.layers.empty());
  return processor_seconds() - start;
}

/// By which factor the forecast is off, upwards or downwards: the best of up to five, since a core that others
/// share runs the same work at half its speed for tenths of a second.
double off_by(const EnsembleSpec& spec, double seconds) {
  double best = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < 5 && !(best < 2); ++attempt) {
    const TimeEstimate time = estimate_time(spec, seconds);
    CHECK_FALSE(time.at_least);
    const double estimated = time.on_threads(spec.response.samples, 1), real = real_seconds(spec);
    CHECK(estimated > 0);
    best = std::min(best, std::exp(std::abs(std::log(estimated / real))));
  }
  return best;
}

TEST_CASE("the time of an ensemble is estimated within a factor of two, whatever the estimator and the friction",
          "[unsanitized]") {
  const LatticeSpec lattice{120, 60};
  CHECK(off_by(ensemble(Law::granusolve, 0.02, lattice, 512), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 1.5, lattice, 256), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 1.5, lattice, 96, paired), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 0.3, lattice, 256, multiplexed), 0.1) < 2);
  // Deeper than what is tried.
  CHECK(off_by(ensemble(Law::granusolve, 0.3, {64, 4000}, 64), 0.1) < 2);
  EnsembleSpec deep = ensemble(Law::granusolve, 0.05, {1632, 700}, 64, multiplexed);
  for (int layer = 0; layer < 100; ++layer) deep.layers.push_back(7 * layer);
  CHECK(off_by(deep, 0.1) < 2);
}

TEST_CASE("the time of diluted beads is estimated within seconds, from a pile that is smaller", "[unsanitized]") {
  const auto diluted = [](const LatticeSpec& lattice, std::uint64_t samples) {
    EnsembleSpec spec = ensemble(Law::granusolve, 0.3, lattice, samples, multiplexed);
    spec.response.blocks = min_blocks;
    spec.sampler.model.name = ModelName::diluted_beads;
    spec.sampler.model.diluted_beads.share = 0.08;
    return spec;
  };
  CHECK(off_by(diluted({18, 12}, 64), 0.3) < 2);
  const double start = processor_seconds();
  CHECK(estimate_time(diluted({48, 40}, 512), 0.3).per_sample > 10);
  CHECK(processor_seconds() - start < 3);
}

TEST_CASE("the time of the laws of tiny piles is estimated from piles that are given up early", "[unsanitized]") {
  CHECK(off_by(ensemble(Law::rejection, 0.3, {6, 6}, 8000), 0.1) < 2);
  CHECK(off_by(ensemble(Law::rejection, 0.3, {6, 12}, 256), 0.2) < 2);
  CHECK(off_by(ensemble(Law::eloy_clement, 0.3, {12, 12}, 512), 0.2) < 2);
}

TEST_CASE("the time of chains is estimated from their sweeps, stated or measured, and the pilot's", "[unsanitized]") {
  EnsembleSpec chains = ensemble(Law::polytope, 0.3, {16, 16}, 64);
  chains.sampler.burn_in = 300;
  chains.sampler.thinning = 40;
  CHECK(off_by(chains, 0.05) < 2);
  chains.response.estimator = multiplexed;
  chains.response.opposite = true;  // two chains for each pair
  CHECK(off_by(chains, 0.05) < 2);
  CHECK(estimate_time(chains, 0.05).once == 0);

  const EnsembleSpec measured = ensemble(Law::polytope, 0.3, {6, 6}, 64);
  const double enough = test::sanitized ? 5 : 0.2;  // seconds
  const TimeEstimate time = estimate_time(measured, enough);
  const std::vector<double> load(6, 1.0);
  CHECK(time.once > 0);
  CHECK(off_by(measured, enough) < 2.5);  // a pilot a fifth as long knows the time to less than a factor of two
}

TEST_CASE(
    "a pilot too short to see the slow waves says that it may take longer, and by the size of the pile how much") {
  const EnsembleSpec wide = ensemble(Law::polytope, 0.3, {32, 40}, 256);
  const double start = processor_seconds();
  const TimeEstimate time = estimate_time(wide, 0.05);
  CHECK(processor_seconds() - start < 2);
  CHECK(time.at_least);
  // From that pilot alone it would be some seconds.
  CHECK(time.on_threads(256, 1) > 60);
  CHECK(time.on_threads(256, 8) > time.once);
  CHECK(time.on_threads(256, 8) < time.on_threads(256, 1));
}

TEST_CASE("a law that completes nothing in the time given for the trial is estimated from below") {
  const EnsembleSpec unfinished = ensemble(Law::rejection, 1.0, {8, 16}, 256);
  const TimeEstimate time = estimate_time(unfinished, 0.1);
  CHECK(time.at_least);
  CHECK(time.per_sample > 0.01);  // of the tenth of a second the last trial took a good part, without one pile
}

}  // namespace

}  // namespace granuscope
