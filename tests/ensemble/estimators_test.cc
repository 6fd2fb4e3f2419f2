// What each estimator sums up.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "ensemble/small_ensemble.h"
#include "kit/naive_granusolve.h"
#include "kit/sampling_statistics.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {

// Source of the expected numbers: each pile drawn by itself and correlated with its loads straight from the definition.

namespace {

EnsembleSpec small_response(int columns) { return test::small_ensemble(multiplexed_response(0.4), columns); }

}  // namespace

TEST_CASE("multiplexed: block sums are the cross-correlations of separately drawn piles, of w and of H") {
  for (const int columns : {12, 13}) {
    EnsembleSpec spec = small_response(columns);
    spec.layers = {5, 22};  // layer 0 comes along
    spec.record_H = true;
    const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
    REQUIRE(record.sums.layers == std::vector<int>{0, 5, 22});
    const Lattice lattice(spec.lattice);
    const auto sampler = make_sampler(spec.sampler, lattice);
    const auto n = static_cast<std::size_t>(columns);
    const std::size_t block = 3;
    for (std::size_t l = 0; l < 3; ++l) {
      std::vector<double> correlation(n), correlation_H(n);
      for (std::uint64_t sample = 24; sample < 32; ++sample) {
        std::vector<double> signs(n), load(n);
        for (std::size_t i = 0; i < n; ++i) {
          signs[i] = RandomKey(7, sample).load_bit(static_cast<int>(i)) ? 1 : -1;
          load[i] = 1 + 0.4 * signs[i];
        }
        Pile pile(lattice);
        REQUIRE_FALSE(sampler->draw(sample, load, pile).has_value());
        for (std::size_t d = 0; d < n; ++d) {
          for (std::size_t j = 0; j < n; ++j) {
            const std::size_t at = lattice.index(record.sums.layers[l], static_cast<int>((j + d) % n));
            correlation[d] += signs[j] * (pile.V_R[at] + pile.V_L[at] - 1) / (0.4 * static_cast<double>(n));
            correlation_H[d] += signs[j] * (pile.H_R[at] + pile.H_L[at]) / (0.4 * static_cast<double>(n));
          }
        }
      }
      const auto check = [&](const char* quantity, const std::vector<double>& by_distance) {
        const double* const sums = &record.sums.quantities.at(quantity).sum[(block * 3 + l) * n];
        for (std::size_t m = 0; m <= n / 2; ++m) {
          double re = 0, im = 0;
          for (std::size_t d = 0; d < n; ++d) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(m * d) / static_cast<double>(n);
            re += by_distance[d] * std::cos(angle);
            im -= by_distance[d] * std::sin(angle);
          }
          CHECK(sums[m == 0 ? 0 : 2 * m - 1] == Approx(re).margin(1e-11));
          if (m > 0 && 2 * m < n) CHECK(sums[2 * m] == Approx(im).margin(1e-11));
        }
      };
      check("correlation", correlation);
      check("correlation_H", correlation_H);
    }
  }
}

TEST_CASE("multiplexed: epsilon is part of the configuration and must leave every bead loaded") {
  EnsembleSpec spec = small_response(12), other = spec;
  other.response.epsilon = 0.25;
  CHECK(configuration_text(spec) != configuration_text(other));
  for (const double epsilon : {0.0, -0.1, 1.0, std::nan("")}) {
    spec.response.epsilon = epsilon;
    CHECK_THROWS_AS(validate(spec), InputError);
  }
  spec = small_response(12);
  spec.load = Load::uniform;
  CHECK_THROWS_AS(validate(spec), InputError);
}

TEST_CASE("multiplexed: the signs of the loads are fair and independent") {
  // Five sigma of each mean of `samples` signs and products of signs.
  constexpr int samples = 4000, columns = 300;
  const double bound = 5 / std::sqrt(static_cast<double>(samples));
  for (const int distance : {0, 1, 2, 31, 32, 128, 150}) {
    for (int i = 0; i + distance < columns; i += 37) {
      double sum = 0;
      for (std::uint64_t sample = 0; sample < samples; ++sample) {
        const RandomKey key(5, sample);
        const double a = key.load_bit(i) ? 1 : -1, b = key.load_bit(i + distance) ? 1 : -1;
        sum += distance == 0 ? a : a * b;
      }
      CHECK(std::abs(sum / samples) < bound);
    }
  }
  double across = 0;
  for (std::uint64_t sample = 0; sample < samples; ++sample) {
    across += (RandomKey(5, sample).load_bit(3) == RandomKey(5, sample + 1).load_bit(3)) ? 1 : -1;
  }
  CHECK(std::abs(across / samples) < bound);
}

TEST_CASE("multiplexed: opposite loads of one key give half the difference of two separately drawn piles") {
  EnsembleSpec spec = small_response(12);
  spec.response.opposite = true;
  spec.layers = {0, 7, 22};
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  constexpr std::size_t n = 12, block = 2;
  for (std::size_t l = 0; l < 3; ++l) {
    double re = 0, thrust = 0;
    constexpr std::size_t m = 3;
    for (std::uint64_t sample = 16; sample < 24; ++sample) {
      std::vector<double> signs(n), up(n), down(n);
      for (std::size_t i = 0; i < n; ++i) {
        signs[i] = RandomKey(7, sample).load_bit(static_cast<int>(i)) ? 1 : -1;
        up[i] = 1 + 0.4 * signs[i];
        down[i] = 1 - 0.4 * signs[i];
      }
      Pile with(lattice), against(lattice);
      REQUIRE_FALSE(sampler->draw(sample, up, with).has_value());
      REQUIRE_FALSE(sampler->draw(sample, down, against).has_value());
      const auto n_layer = record.sums.layers[l];
      for (std::size_t d = 0; d < n; ++d) {
        for (std::size_t j = 0; j < n; ++j) {
          const std::size_t at = lattice.index(n_layer, static_cast<int>((j + d) % n));
          const double half = (with.V_R[at] + with.V_L[at] - against.V_R[at] - against.V_L[at]) / 2;
          re += signs[j] * half / (0.4 * n) * std::cos(2 * std::numbers::pi * static_cast<double>(m * d) / n);
        }
      }
      for (const Pile* pile : {&with, &against}) {
        double sum = 0, load = 0;
        for (std::size_t i = 0; i < n; ++i) {
          const std::size_t at = lattice.index(n_layer, static_cast<int>(i));
          sum += pile->H_R[at] - pile->H_L[at];
          load += pile->load[i];
        }
        thrust += std::sqrt(3.0) * sum / load / 2;
      }
    }
    CHECK(record.sums.quantities.at("correlation").sum[(block * 3 + l) * n + 2 * m - 1] == Approx(re).margin(1e-11));
    CHECK(record.sums.quantities.at("thrust").sum[block * 3 + l] == Approx(thrust).margin(1e-11));
  }
  // Both piles are counted as work.
  CHECK(record.counts.beads == 2 * spec.response.samples * lattice.beads());
}

TEST_CASE("multiplexed: opposite loads cancel most of the noise of small variations at small friction") {
  // The scatter of eight numbers of four waves over 32 blocks of 8 samples: their ratio is known to a fifth.
  const auto scatter = [](bool opposite) {
    EnsembleSpec spec = small_response(32);
    spec.sampler.mu = 0.1;
    spec.response.epsilon = 0.1;
    spec.response.opposite = opposite;
    spec.response.samples = 256;
    spec.response.blocks = 32;
    spec.layers = {0, 24};
    const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
    double variance = 0;
    for (const std::size_t mode : {5U, 6U, 9U, 10U, 13U, 14U, 17U, 18U}) {
      double sum = 0, squares = 0;
      for (std::size_t b = 0; b < 32; ++b) {
        const double one = record.sums.quantities.at("correlation").sum[(2 * b + 1) * 32 + mode];
        sum += one;
        squares += one * one;
      }
      variance += squares / 32 - sum * sum / (32.0 * 32);
    }
    return variance;
  };
  CHECK(scatter(false) > 2 * scatter(true));
}

TEST_CASE("multiplexed: its options are part of the configuration and must leave something to measure") {
  EnsembleSpec spec = small_response(24), opposite = spec, run = spec;
  opposite.response.opposite = true;
  run.response.sign_run = 3;
  CHECK(configuration_text(spec) != configuration_text(opposite));
  CHECK(configuration_text(spec) != configuration_text(run));
  CHECK(configuration_text(opposite) != configuration_text(run));
  CHECK_NOTHROW(validate(run));
  for (const int beads : {-1, 0, 4, 24}) {
    run.response.sign_run = beads;
    CHECK_THROWS_AS(validate(run), InputError);
  }
  opposite.response.estimator = EstimatorName::point;
  CHECK_THROWS_AS(validate(opposite), InputError);
  spec.response.estimator = EstimatorName::paired;
  spec.response.sign_run = 2;
  CHECK_THROWS_AS(validate(spec), InputError);
}

TEST_CASE("every estimator, under every law and of every model, gives the same bytes on any number of threads") {
  std::vector<EnsembleSpec> specs;
  std::vector<ResponseSpec> responses(5);
  responses[4].coupled = true;
  responses[1].estimator = EstimatorName::paired;
  responses[2] = responses[3] = multiplexed_response(0.25);
  responses[3].opposite = true;
  for (const ResponseSpec& response : responses) {
    for (const Law law : all_laws) {
      for (const double mu : {0.0, 0.3, 1.0}) {
        if (mu != 0.3 && law != Law::granusolve) continue;
        if (law == Law::polytope && response.coupled) continue;  // refused
        specs.push_back(test::small_ensemble(response, 6));
        specs.back().lattice.layers = 4;
        specs.back().sampler.law = law;
        specs.back().sampler.mu = mu;
        specs.back().sampler.burn_in = law == Law::polytope ? 20 : 0;
        specs.back().sampler.thinning = law == Law::polytope ? 4 : 0;
      }
    }
    specs.push_back(test::small_ensemble(response, 24));  // wide and deep enough that groups repair and backtrack
    if (response.estimator == EstimatorName::paired) continue;
    for (const ModelName model : {ModelName::q_model, ModelName::three_leg, ModelName::stochastic_osl}) {
      specs.push_back(test::small_ensemble(response, 24));
      specs.back().sampler.model.name = model;
      specs.back().sampler.model.three_leg.law = MiddleLaw::positive;
    }
  }
  for (EnsembleSpec& spec : specs) {
    spec.response.blocks = 9;
    spec.response.samples = 8 * 11 + 3;  // unlike blocks, and a group that is not full
    INFO(configuration_text(spec));
    const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
    for (const int threads : {2, 5}) CHECK(test::same_bytes(run_ensemble(spec, threads, nullptr), one));
    CHECK(one.failed.empty());
    CHECK(one.sums.rows == rows_of(spec.sampler.model));
    CHECK(one.sums.quantities.contains("middle") == (spec.sampler.model.name == ModelName::three_leg));
    // The weight of the top layer is the load: its spectrum, the response there, is the same for every law.
    if (one.sums.quantities.contains("correlation")) CHECK(one.sums.quantities.at("correlation").sum[1] > 0);
    if (spec.sampler.model.has_contacts()) CHECK(one.sums.quantities.at("thrust").sum.back() != 0);
    // Another seed is another ensemble.
    spec.sampler.seed += 1;
    const EnsembleRecord other = run_ensemble(spec, 1, nullptr);
    bool differs = spec.sampler.mu == 0;  // without friction every pile is the same
    for (const auto& [name, sums] : one.sums.quantities) differs |= sums.sum != other.sums.quantities.at(name).sum;
    CHECK(differs);
  }
}

// Source of the expected numbers: each pair of piles drawn by itself and summed straight from the definitions.

namespace {

EnsembleSpec small_response() {
  return test::small_ensemble({.estimator = EstimatorName::paired, .overload = 0.5}, 24);
}

}  // namespace

TEST_CASE("paired: block sums are those of separately drawn pairs") {
  const EnsembleSpec spec = small_response();
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  std::vector<double> load(24, 1.0), overloaded = load;
  overloaded[12] += 0.5;
  Pile before(lattice), after(lattice);
  std::vector<unsigned char> redrawn;
  const std::size_t block = 3, layer = 22;
  std::vector<double> response(24);
  double share = 0, below = 0, thrust = 0, response_thrust = 0;
  for (std::uint64_t sample = 24; sample < 32; ++sample) {
    REQUIRE_FALSE(sampler->draw(sample, load, before).has_value());
    REQUIRE_FALSE(sampler->draw_again(sample, overloaded, before, after).has_value());
    find_redrawn(before, after, redrawn);
    double H = 0, H_after = 0;
    int redrawn_here = 0;
    for (std::size_t i = 0; i < 24; ++i) {
      const std::size_t at = layer * 24 + i;
      response[i] += (after.V_R[at] + after.V_L[at] - before.V_R[at] - before.V_L[at]) / 0.5;
      redrawn_here += redrawn[at];
      H += before.H_R[at] - before.H_L[at];
      H_after += after.H_R[at] - after.H_L[at];
    }
    share += redrawn_here / 24.0;
    below += redrawn_here / 24.0;  // z = 19.6: the whole ring of 24 lies within |x| <= z
    thrust += sqrt3 * H / 24;
    response_thrust += sqrt3 * (H_after - H) / 0.5;
  }
  const std::size_t row = block * 30 + layer;
  CHECK(record.sums.count[block] == 8);
  CHECK(record.sums.quantities.at("redrawn").sum[row] == Approx(share).epsilon(1e-13));
  CHECK(record.sums.quantities.at("redrawn_below_overload").sum[row] == Approx(below).epsilon(1e-13));
  CHECK(record.sums.quantities.at("thrust").sum[row] == Approx(thrust).epsilon(1e-13));
  CHECK(record.sums.quantities.at("response_thrust").sum[row] == Approx(response_thrust).epsilon(1e-11));
  CHECK(share > 0);
  double sum = 0;
  for (std::size_t i = 0; i < 24; ++i) {
    CHECK(record.sums.quantities.at("response").sum[row * 24 + i] == Approx(response[i]).margin(1e-11));
    sum += record.sums.quantities.at("response").sum[row * 24 + i];
  }
  CHECK(sum == Approx(8).epsilon(1e-11));  // the overload arrives whole in every layer, in every sample
}

TEST_CASE("paired: near the top the response is that of the geometry") {
  // Layer 0 carries the overload itself; in layer 1 the two beads below share it, whatever the splits.
  const EnsembleSpec spec = small_response();
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const std::vector<double>& sum = record.sums.quantities.at("response").sum;
  for (std::size_t b = 0; b < 8; ++b) {
    for (std::size_t i = 0; i < 24; ++i) {
      CHECK(sum[b * 30 * 24 + i] == Approx(i == 12 ? 8 : 0).margin(1e-12));
      CHECK(sum[(b * 30 + 1) * 24 + i] == Approx(i == 11 || i == 12 ? 4 : 0).margin(1e-12));
    }
  }
}

TEST_CASE("paired: without friction nothing is redrawn") {
  EnsembleSpec spec = small_response();
  spec.sampler.mu = 0;
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  for (const double share : record.sums.quantities.at("redrawn").sum) CHECK(share == 0);
}

TEST_CASE("ensembles of different estimators, overloads and epsilons are told apart") {
  EnsembleSpec point = small_response(), paired = point, stronger = point;
  point.response.estimator = EstimatorName::point;
  stronger.response.overload = 1;
  CHECK(configuration_text(point) != configuration_text(paired));
  CHECK(configuration_text(stronger) != configuration_text(paired));
  CHECK(estimator_named("paired") == EstimatorName::paired);
  CHECK(name_of(EstimatorName::multiplexed) == "multiplexed");
}

namespace {

std::vector<double> signs_of(std::uint64_t sample, int run, std::size_t columns) {
  std::vector<double> signs(columns);
  draw_signs(9, sample, run, signs);
  return signs;
}

}  // namespace

TEST_CASE("signs of the loads: runs of one bead are the fair bits of the key") {
  const std::vector<double> signs = signs_of(4, 1, 77);
  for (std::size_t i = 0; i < signs.size(); ++i) {
    CHECK(signs[i] == (RandomKey(9, 4).load_bit(static_cast<int>(i)) ? 1 : -1));
  }
}

TEST_CASE("signs of the loads: runs have the length asked for or one bead more, and every sample its own") {
  for (const int run : {2, 3, 7}) {
    const auto shortest = static_cast<std::size_t>(run);
    std::set<std::vector<double>> seen;
    double sum = 0;
    constexpr std::size_t columns = 120;
    constexpr std::uint64_t samples = 400;
    for (std::uint64_t sample = 0; sample < samples; ++sample) {
      const std::vector<double> signs = signs_of(sample, run, columns);
      seen.insert(signs);
      std::size_t since = 0;
      for (std::size_t i = 0; i < columns; ++i) {
        REQUIRE(std::abs(signs[i]) == 1);
        sum += signs[i];
        ++since;
        if (i + 1 < columns && signs[i + 1] == signs[i]) continue;
        // Neighbouring runs may share their sign: a stretch is a sum of lengths `run` and `run` + 1.
        const std::size_t runs = since / shortest;
        if (i + 1 < columns) CHECK((runs >= 1 && since <= runs * (shortest + 1)));
        since = 0;
      }
    }
    CHECK(seen.size() == samples);
    // Five sigma; the mean of a sample has the variance of its number of runs.
    CHECK(std::abs(sum / (columns * samples)) < 5 * std::sqrt((run + 1.0) / (columns * samples)));
  }
}

TEST_CASE("signs of the loads: runs move power to long waves and leave none without") {
  constexpr std::size_t columns = 96;
  constexpr std::uint64_t samples = 3000;
  const RealSpectrum fourier(columns);
  for (const int run : {2, 3}) {
    std::vector<double> power(columns / 2 + 1);
    for (std::uint64_t sample = 0; sample < samples; ++sample) {
      std::vector<double> signs = signs_of(sample, run, columns);
      fourier.transform(signs);
      for (std::size_t m = 1; 2 * m < columns; ++m) {
        power[m] += (signs[2 * m - 1] * signs[2 * m - 1] + signs[2 * m] * signs[2 * m]) / (columns * samples);
      }
    }
    // One fair sign a bead has the power 1 at every wave. Runs of L and L + 1 beads have
    //   sum of sin^2(k L/2)/sin^2(k/2) over both lengths / (2 L + 1),
    // apart from the last run of the ring, which is cut off.
    for (std::size_t m = 2; 2 * m < columns; m += 5) {
      const double half_k = M_PI * static_cast<double>(m) / columns, sine = std::sin(half_k);
      const double expected =
          (std::pow(std::sin(half_k * run) / sine, 2) + std::pow(std::sin(half_k * (run + 1)) / sine, 2)) /
          (2 * run + 1);
      CHECK(power[m] == Approx(expected).epsilon(0.1 + 5 / std::sqrt(double(samples))).margin(0.02));
      CHECK(power[m] > 0.05);
    }
    CHECK(power[2] > 0.9 * (run + 0.5));
  }
}

// The response of beads that have a weight of their own. Source of the expected numbers: weight is conserved, and
// without friction rays go straight.

namespace {

EnsembleSpec heavy_ensemble(const ResponseSpec& response, double mu, double bead_weight) {
  EnsembleSpec spec = test::small_ensemble(response, 24);
  spec.sampler.mu = mu;
  spec.sampler.bead_weight = bead_weight;
  return spec;
}

}  // namespace

TEST_CASE("the response of heavy beads has the weight of the load, whatever they weigh, on any number of threads") {
  for (const ResponseSpec& response :
       {ResponseSpec{.overload = 1}, multiplexed_response(0.2), multiplexed_response(0.2, true)}) {
    const EnsembleSpec spec = heavy_ensemble(response, 0.3, 0.7);
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    CHECK(test::same_bytes(record, run_ensemble(spec, 2, nullptr)));
    const bool point = response.estimator == EstimatorName::point;
    const std::vector<double>& sum = record.sums.quantities.at(point ? "weight" : "correlation").sum;
    const std::size_t rows = record.sums.layers.size(), columns = 24;
    REQUIRE(sum.size() == 8 * rows * columns);
    for (std::size_t block = 0; block < 8; ++block) {
      const double* const of_block = &sum[block * rows * columns];
      for (std::size_t row = 0; row < rows; ++row) {
        double total = 0;
        for (std::size_t i = 0; i < columns; ++i) total += of_block[row * columns + i];
        // Under the point load the sum of the weights, else mode 0 of every layer, which is that of the loads.
        if (point) CHECK(total / static_cast<double>(record.sums.count[block]) == Approx(25).epsilon(1e-12));
        if (!point) CHECK(of_block[row * columns] == Approx(of_block[0]).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("without friction the response is that of beads without weight, and forces are as even as they are heavy") {
  const EnsembleRecord heavy = run_ensemble(heavy_ensemble(multiplexed_response(0.2), 0, 3), 1, nullptr);
  const EnsembleRecord light = run_ensemble(heavy_ensemble(multiplexed_response(0.2), 0, 0), 1, nullptr);
  const auto of = [](const EnsembleRecord& record, const char* name) { return record.sums.quantities.at(name).sum; };
  const std::vector<double> a = of(heavy, "correlation"), b = of(light, "correlation");
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).margin(1e-9));
  const std::vector<double> thrust = of(heavy, "thrust"), one = of(heavy, "weight_variance"),
                            other = of(light, "weight_variance");
  const std::size_t rows = heavy.sums.layers.size();
  for (std::size_t i = 0; i < thrust.size(); ++i) {
    CHECK(thrust[i] == Approx(8).epsilon(1e-12));  // 8 piles a block, of thrust ratio 1
    const double mean = 1 + 3 * (heavy.sums.layers[i % rows] + 1);
    CHECK(one[i] * mean * mean == Approx(other[i]));
  }
}

TEST_CASE("an ensemble of heavy beads says so, and the estimator fluctuation refuses them by name") {
  const EnsembleSpec heavy = heavy_ensemble(ResponseSpec{.overload = 1}, 0.3, 0.25);
  CHECK(configuration_text(heavy).find("\nbead_weight=0.25\n") != std::string::npos);
  CHECK(configuration_text(heavy_ensemble(ResponseSpec{.overload = 1}, 0.3, 0)).find("bead_weight") ==
        std::string::npos);
  CHECK(replay_command(heavy, 3).find(" --bead-weight 0.25 ") != std::string::npos);
  const Problem found = find_problem(heavy_ensemble({.estimator = EstimatorName::fluctuation}, 0.3, 0.25));
  REQUIRE(found.has_value());
  CHECK(found->key == "estimator");
  CHECK(found->message.find("weight 0.25") != std::string::npos);
}

// Source: an ensemble of a model depends on its configuration alone, and its rows lie where the model says.

namespace {

EnsembleSpec ensemble_of(ModelName name, const ResponseSpec& response) {
  EnsembleSpec spec = test::small_ensemble(response, 24);
  spec.sampler.model.name = name;
  spec.sampler.model.three_leg.law = MiddleLaw::positive;
  return spec;
}

}  // namespace

TEST_CASE("the linear response of a linear model does not depend on how it is loaded") {
  // Both loads of an opposite pair see the same noise, so that their mean is the pile under the uniform load.
  EnsembleSpec spec = ensemble_of(ModelName::q_model, multiplexed_response(0.2, true));
  spec.layers = {0, 29};
  const EnsembleRecord small = run_ensemble(spec, 1, nullptr);
  spec.response.epsilon = 0.8;
  const EnsembleRecord large = run_ensemble(spec, 1, nullptr);
  const auto &a = small.sums.quantities.at("correlation").sum, &b = large.sums.quantities.at("correlation").sum;
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == Approx(b[i]).margin(1e-9));
}

TEST_CASE("estimators that make no sense with a model refuse it by name, and beads keep their configuration") {
  for (const auto& [model, estimator] : {std::pair{ModelName::three_leg, EstimatorName::paired},
                                         {ModelName::diluted_beads, EstimatorName::paired},
                                         {ModelName::diluted_beads, EstimatorName::fluctuation}}) {
    EnsembleSpec spec = ensemble_of(model, {.estimator = estimator});
    const Problem found = find_problem(spec);
    REQUIRE(found.has_value());
    CHECK(found->key == "estimator");
    CHECK(found->message.find(name_of(model)) != std::string::npos);
  }
  const std::string again = replay_command(ensemble_of(ModelName::diluted_beads, multiplexed_response(0.2)), 3);
  CHECK(again.find("granuscope sample --model diluted-beads --opened-share 0.05 --least-slack 0.02 --mu 0.3 ") == 0);
  const EnsembleSpec beads = test::small_ensemble(ResponseSpec{.overload = 1}, 24);
  CHECK(configuration_text(beads).find("model") == std::string::npos);
  CHECK(configuration_text(ensemble_of(ModelName::q_model, ResponseSpec{.overload = 1})).find("model=q-model\n") !=
        std::string::npos);
  EnsembleSpec cells = ensemble_of(ModelName::stochastic_osl, ResponseSpec{.overload = 1});
  cells.sampler.model.stochastic_osl.cell_columns = 5;
  CHECK_THROWS_AS(run_ensemble(cells, 1, nullptr), InputError);
}

namespace {

// Source of the expected numbers: naive_granusolve.h, the law written a second time from its description, which draws
// its own piles of 500 x 200 beads under a uniform load. c_thrust = tan 30 deg sqrt(alpha), alpha averaged over layers
// 58 to 179.

constexpr int first_layer = 58, last_layer = 179;

/// c_thrust from an ensemble, with its error from the spread over blocks.
test::Estimated thrust_speed(double mu, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = 5;
  spec.lattice = {.columns = 500, .layers = 200};
  spec.load = Load::uniform;
  spec.response.samples = samples;
  spec.response.blocks = 8;
  spec.layers.resize(last_layer - first_layer + 1);
  std::iota(spec.layers.begin(), spec.layers.end(), first_layer);
  spec.record_profiles = false;
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const std::vector<double>& sum = record.sums.quantities.at("thrust").sum;
  std::vector<double> speeds;
  for (std::size_t block = 0; block < 8; ++block) {
    const auto from = sum.begin() + static_cast<std::ptrdiff_t>(block * 122);
    const double total = std::accumulate(from, from + 122, 0.0);
    speeds.push_back(std::sqrt(total / (122.0 * static_cast<double>(record.sums.count[block])) / 3));
  }
  const double mean = std::accumulate(speeds.begin(), speeds.end(), 0.0) / 8;
  double squares = 0;
  for (const double speed : speeds) squares += (speed - mean) * (speed - mean);
  return {mean, std::sqrt(squares / (8 * 7))};
}

/// The same from the second implementation.
test::Estimated naive_thrust_speed(double mu, std::uint64_t samples) {
  const Lattice lattice({.columns = 500, .layers = 200});
  const std::vector<double> load(500, 1.0);
  test::NaiveGranusolve law(lattice, mu, 12);
  Pile pile(lattice);
  test::RunningMean alpha;
  for (std::uint64_t sample = 0; sample < samples; ++sample) {
    REQUIRE(law.draw(load, pile));
    double sum = 0;
    for (std::size_t at = lattice.index(first_layer, 0); at < lattice.index(last_layer + 1, 0); ++at)
      sum += pile.H_R[at] - pile.H_L[at];
    alpha.add(std::sqrt(3.0) * sum / (500 * (last_layer - first_layer + 1)));
  }
  const double speed = std::sqrt(alpha.estimate().value / 3);
  return {speed, std::sqrt(alpha.variance() / static_cast<double>(samples)) / (6 * speed)};
}

void compare(std::uint64_t samples, std::uint64_t naive_samples) {
  for (const double mu : {0.1, 0.2, 0.3}) {
    const test::Estimated c = thrust_speed(mu, samples), expected = naive_thrust_speed(mu, naive_samples);
    CAPTURE(mu, samples, c.value, c.error, expected.value, expected.error);
    CHECK(std::abs(test::sigmas(c, expected)) <= 5);
    // So precise that a change of the law by a percent of c0 - c at mu = 0.3 could not hide behind the error.
    CHECK(c.error < 2e-4);
    CHECK(c.error > 0);
    CHECK(expected.error < 2e-4);
  }
}

TEST_CASE("c_thrust is that of a second implementation", "[unsanitized]") { compare(64, test::sanitized ? 16 : 32); }

TEST_CASE("c_thrust is that of a second implementation, with small errors", "[long]") { compare(1024, 128); }

}  // namespace

}  // namespace granuscope
