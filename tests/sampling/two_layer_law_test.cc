// Source of the expected numbers: two_layer_law.h, the law on 4 columns and 2 layers enumerated on a grid, extrapolated
// from two grids (the error of a grid falls with the square of the cell).
#include "two_layer_law.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

struct Setting {
  double mu;
  std::array<double, 4> load;
};

constexpr int coarse = test::sanitized ? 10 : 14, fine = 2 * coarse;
constexpr int piles = test::sanitized ? 40'000 : 300'000;

std::vector<double> listed(const test::TwoLayerMoments& moments) {
  std::vector<double> all;
  for (const auto& group : {moments.mean, moments.square, moments.with_next})
    all.insert(all.end(), group.begin(), group.end());
  all.insert(all.end(), moments.across.begin(), moments.across.end());
  return all;
}

/// The moments in the order of listed(), of one layer of four beads.
void add_moments(const double* H_R, std::vector<test::RunningMean>& measured) {
  for (std::size_t i = 0; i < 4; ++i) {
    measured[i].add(H_R[i]);
    measured[4 + i].add(H_R[i] * H_R[i]);
    measured[8 + i].add(H_R[i] * H_R[(i + 1) % 4]);
    if (i < 2) measured[12 + i].add(H_R[i] * H_R[i + 2]);
  }
}

TEST_CASE("pairs on four columns and two layers follow the enumerated law", "[unsanitized]") {
  const std::vector<Setting> settings = {
      {0.3, {1, 1, 1, 1}},         {1.0, {1, 1, 1, 1}},         {0.3, {1, 2, 1, 1}},
      {0.6, {0.3, 1.8, 0.5, 1.4}}, {0.8, {0.3, 1.8, 0.5, 1.4}},
  };
  for (const Setting& setting : settings) {
    const std::vector<double> load(setting.load.begin(), setting.load.end());
    const test::TwoLayerMoments on_fine = test::TwoLayerLaw(setting.mu, setting.load, fine).moments();
    const std::vector<double> expected_coarse = listed(test::TwoLayerLaw(setting.mu, setting.load, coarse).moments());
    const std::vector<double> expected_fine = listed(on_fine);

    const Lattice lattice({.columns = 4, .layers = 2});
    SamplerSpec spec;
    spec.mu = setting.mu;
    spec.seed = 2;
    const auto sampler = make_sampler(spec, lattice);
    std::vector<test::RunningMean> measured(14);
    Pile pile(lattice);
    for (int k = 0; k < piles; ++k) {
      if (sampler->draw(8 * static_cast<std::uint64_t>(k), load, pile)) throw std::runtime_error("stuck");
      add_moments(pile.H_R.data(), measured);
    }
    const auto& counts = sampler->counts();
    CAPTURE(setting.mu, spec.seed, counts.pairs, counts.rings, on_fine.lost);
    CHECK(counts.pairs >= 1000);
    CHECK(counts.arcs == 0);
    CHECK(counts.backtracks == 0);
    CHECK(counts.rings == 0);
    CHECK(on_fine.lost < 1e-12);
    const double bound = test::sigma_bound(settings.size() * measured.size());
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const auto found = measured[k].estimate();
      const double expected = (4 * expected_fine[k] - expected_coarse[k]) / 3;
      const double grid_error = std::abs(expected_fine[k] - expected_coarse[k]) / 3;
      CAPTURE(k, found.value, found.error, expected, grid_error);
      CHECK(std::abs(found.value - expected) <= bound * found.error + grid_error);
      // Neither grid nor too few piles may hide a shift of two percent of the quantity's spread.
      CHECK(bound * found.error + grid_error < 0.02 * std::sqrt(measured[k].variance()) * (test::sanitized ? 3 : 1));
    }
  }
}

/// The moments of the middle layer's splits in piles of three layers: for each state of the top layer as two layers
/// leave it, the middle layer's law once the lowest is solved. Valid where nothing backtracks: then the lowest layer
/// changes no split of the top one.
struct MiddleLayer {
  std::vector<double> moments;
  double lost = 0;  ///< probability of failures that the enumeration does not follow, or of states without a point
};

MiddleLayer middle_layer(const Setting& setting, int cells) {
  test::TwoLayerLaw upper(setting.mu, setting.load, cells);
  MiddleLayer result;
  result.lost = upper.moments().lost;
  double total = 0;
  for (const auto& [splits, share] : upper.states()) {
    test::TwoLayerLaw lower(setting.mu, upper.below(splits), cells);
    if (!lower.solvable()) continue;
    const test::TwoLayerMoments moments = lower.moments();
    result.lost += share * moments.lost;
    const std::vector<double> numbers = listed(moments);
    result.moments.resize(numbers.size());
    // What is lost counts as if it were distributed like the rest.
    for (std::size_t k = 0; k < numbers.size(); ++k) result.moments[k] += share * numbers[k];
    total += share * (1 - moments.lost);
  }
  for (double& one : result.moments) one /= total;
  result.lost += 1 - total;
  return result;
}

void compare_three_layers(const std::vector<Setting>& settings, int cells, int drawn, double resolution) {
  const Lattice lattice({.columns = 4, .layers = 3});
  for (const Setting& setting : settings) {
    const MiddleLayer on_fine = middle_layer(setting, cells), on_coarse = middle_layer(setting, cells / 2);
    SamplerSpec spec;
    spec.mu = setting.mu;
    spec.seed = 6;
    const auto sampler = make_sampler(spec, lattice);
    const std::vector<double> load(setting.load.begin(), setting.load.end());
    std::vector<test::RunningMean> measured(14);
    Pile pile(lattice);
    for (int k = 0; k < drawn; ++k) {
      if (sampler->draw(8 * static_cast<std::uint64_t>(k), load, pile)) throw std::runtime_error("stuck");
      add_moments(pile.H_R.data() + 4, measured);
    }
    const auto& counts = sampler->counts();
    // Rings and backtracks are not followed: they must be rarer than what is to be told.
    const double others = static_cast<double>(counts.rings + counts.backtracks) / drawn;
    const double bound = test::sigma_bound(settings.size() * measured.size());
    CAPTURE(setting.mu, spec.seed, counts.pairs, counts.rings, counts.backtracks, on_fine.lost);
    CHECK(counts.pairs >= 1000);
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const auto found = measured[k].estimate();
      const double spread = std::sqrt(measured[k].variance());
      // A pile that went another way may lie some spreads off.
      const double grid_error = std::abs(on_fine.moments[k] - on_coarse.moments[k]) / 3;
      const double expected = (4 * on_fine.moments[k] - on_coarse.moments[k]) / 3;
      const double allowed = bound * found.error + grid_error + 3 * others * spread;
      CAPTURE(k, found.value, found.error, expected, grid_error, spread);
      CHECK(std::abs(found.value - expected) <= allowed);
      CHECK(allowed < resolution * spread);
    }
  }
}

TEST_CASE("the middle one of three layers follows the enumerated law", "[unsanitized]") {
  compare_three_layers({{0.3, {1, 1, 1, 1}}}, test::sanitized ? 6 : 8, test::sanitized ? 20'000 : 100'000,
                       test::sanitized ? 0.2 : 0.1);
}

TEST_CASE("the middle one of three layers follows the enumerated law, on finer grids", "[long]") {
  compare_three_layers({{0.3, {1, 1, 1, 1}}, {0.3, {0.7, 1.4, 0.9, 1.2}}, {0.6, {1, 1.3, 0.8, 1.1}}}, 10, 400'000,
                       0.06);
}

}  // namespace
}  // namespace granuscope
