// Source of the expected numbers: every pile drawn by itself and summed in the order of its number, straight from the
// definitions of the quantities; equality is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "ensemble/small_ensemble.h"
#include "kit/same_bytes.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using test::same_bytes;

EnsembleSpec small_ensemble() {
  EnsembleSpec spec = test::small_ensemble(point_response(1), 10);
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

TEST_CASE("any number of threads gives the same bytes") {
  for (const double mu : {0.0, 0.1, 1.0}) {
    EnsembleSpec spec = small_ensemble();
    spec.sampler.mu = mu;
    spec.response.blocks = 9;
    const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
    for (const int threads : {2, 3, 7, 0}) {
      INFO("threads " << threads << ", mu " << mu);
      CHECK(same_bytes(one, run_ensemble(spec, threads, nullptr)));
    }
    spec.sampler.seed = 8;
    if (mu > 0) CHECK_FALSE(same_bytes(one, run_ensemble(spec, 1, nullptr)));
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

}  // namespace
}  // namespace granuscope
