// Source of the expected numbers: each pile drawn by itself and correlated with its loads straight from the definition.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <numbers>

#include "ensemble/ensemble_runner.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {
namespace {

EnsembleSpec small_ensemble(int columns) {
  EnsembleSpec spec;
  spec.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = 0.3;
  spec.sampler.seed = 7;
  spec.lattice = {.columns = columns, .layers = 30};
  spec.samples = 64;
  spec.blocks = 8;
  spec.epsilon = 0.4;
  return spec;
}

}  // namespace

TEST_CASE("multiplexed: block sums are the cross-correlations of separately drawn piles") {
  for (const int columns : {12, 13}) {
    EnsembleSpec spec = small_ensemble(columns);
    spec.layers = {5, 22};  // layer 0 comes along
    const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
    REQUIRE(record.sums.layers == std::vector<int>{0, 5, 22});
    const Lattice lattice(spec.lattice);
    const auto sampler = make_sampler(spec.sampler, lattice);
    const auto n = static_cast<std::size_t>(columns);
    const std::size_t block = 3;
    for (std::size_t l = 0; l < 3; ++l) {
      std::vector<double> correlation(n);
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
          }
        }
      }
      const double* const sums = &record.sums.quantities.at("correlation").sum[(block * 3 + l) * n];
      for (std::size_t m = 0; m <= n / 2; ++m) {
        double re = 0, im = 0;
        for (std::size_t d = 0; d < n; ++d) {
          const double angle = 2 * std::numbers::pi * static_cast<double>(m * d) / static_cast<double>(n);
          re += correlation[d] * std::cos(angle);
          im -= correlation[d] * std::sin(angle);
        }
        CHECK(sums[m == 0 ? 0 : 2 * m - 1] == Approx(re).margin(1e-11));
        if (m > 0 && 2 * m < n) CHECK(sums[2 * m] == Approx(im).margin(1e-11));
      }
    }
  }
}

TEST_CASE("multiplexed: any number of threads gives the same bytes") {
  EnsembleSpec spec = small_ensemble(20);
  spec.blocks = 9;
  spec.samples = 8 * 11 + 3;
  const EnsembleRecord one = run_ensemble(spec, 1, nullptr);
  for (const int threads : {2, 5}) {
    const EnsembleRecord many = run_ensemble(spec, threads, nullptr);
    for (const auto& [name, sums] : one.sums.quantities) {
      const std::vector<double>& other = many.sums.quantities.at(name).sum;
      REQUIRE(other.size() == sums.sum.size());
      CHECK(std::memcmp(other.data(), sums.sum.data(), other.size() * sizeof(double)) == 0);
    }
  }
  spec.sampler.seed = 8;
  CHECK(run_ensemble(spec, 1, nullptr).sums.quantities.at("correlation").sum !=
        one.sums.quantities.at("correlation").sum);
}

TEST_CASE("multiplexed: epsilon is part of the configuration and must leave every bead loaded") {
  EnsembleSpec spec = small_ensemble(12), other = spec;
  other.epsilon = 0.25;
  CHECK(configuration_text(spec) != configuration_text(other));
  for (const double epsilon : {0.0, -0.1, 1.0, std::nan("")}) {
    spec.epsilon = epsilon;
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

}  // namespace granuscope
