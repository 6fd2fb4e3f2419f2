// Source of the expected numbers: each pile drawn by itself and correlated with its loads straight from the definition.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "ensemble/ensemble_runner.h"
#include "ensemble/small_ensemble.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

EnsembleSpec small_ensemble(int columns) { return test::small_ensemble(multiplexed_response(0.4), columns); }

}  // namespace

TEST_CASE("multiplexed: block sums are the cross-correlations of separately drawn piles, of w and of H") {
  for (const int columns : {12, 13}) {
    EnsembleSpec spec = small_ensemble(columns);
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

TEST_CASE("multiplexed: any number of threads gives the same bytes") {
  EnsembleSpec spec = small_ensemble(20);
  spec.response.blocks = 9;
  spec.response.samples = 8 * 11 + 3;
  const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
  for (const int threads : {2, 5}) CHECK(test::same_bytes(run_ensemble(spec, threads, nullptr), one));
  spec.sampler.seed = 8;
  CHECK(run_ensemble(spec, 1, nullptr).sums.quantities.at("correlation").sum !=
        one.sums.quantities.at("correlation").sum);
}

TEST_CASE("multiplexed: epsilon is part of the configuration and must leave every bead loaded") {
  EnsembleSpec spec = small_ensemble(12), other = spec;
  other.response.epsilon = 0.25;
  CHECK(configuration_text(spec) != configuration_text(other));
  for (const double epsilon : {0.0, -0.1, 1.0, std::nan("")}) {
    spec.response.epsilon = epsilon;
    CHECK_THROWS_AS(validate(spec), InputError);
  }
  spec = small_ensemble(12);
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
  EnsembleSpec spec = small_ensemble(12);
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
    EnsembleSpec spec = small_ensemble(32);
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
  EnsembleSpec spec = small_ensemble(24), opposite = spec, run = spec;
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

TEST_CASE("estimators: each goes with every law, on any number of threads") {
  for (const Law law : all_laws) {
    for (const EstimatorName estimator : {EstimatorName::point, EstimatorName::paired, EstimatorName::multiplexed}) {
      for (const bool opposite : {false, true}) {
        if (opposite && estimator != EstimatorName::multiplexed) continue;
        EnsembleSpec spec = small_ensemble(6);
        spec.sampler.law = law;
        spec.sampler.burn_in = law == Law::polytope ? 20 : 0;
        spec.sampler.thinning = law == Law::polytope ? 4 : 0;
        spec.lattice.layers = 4;
        spec.response.estimator = estimator;
        spec.response.opposite = opposite;
        spec.response.epsilon = 0.25;
        CAPTURE(name_of(law), name_of(estimator), opposite);
        const EnsembleRecord one = run_ensemble(spec, 1, nullptr), two = run_ensemble(spec, 2, nullptr);
        CHECK(one.failed.empty());
        for (const auto& [name, sums] : one.sums.quantities) {
          CHECK(sums.sum == two.sums.quantities.at(name).sum);
          // The weight of the top layer is the load: its spectrum, the response there, is the same for every law.
          if (name == "correlation") CHECK(sums.sum[1] > 0);
        }
        CHECK(one.sums.quantities.at("thrust").sum.back() != 0);
      }
    }
  }
}

}  // namespace granuscope
