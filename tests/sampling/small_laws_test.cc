// Laws of small piles against enumeration, quadrature and second implementations.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <vector>

#include "kit/naive_rejection.h"
#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "ring_quadrature.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"
#include "two_layer_law.h"

namespace granuscope {
namespace {

using test::Estimated;
using test::RunningMean;

// Source of the expected numbers: two_layer_law.h, the law on 4 columns and 2 layers enumerated on a grid, extrapolated
// from two grids (the error of a grid falls with the square of the cell).

struct Setting {
  double mu;
  std::array<double, 4> load;
  double angle = 30;
};

constexpr int coarse_cells = test::sanitized ? 10 : 14, fine_cells = 2 * coarse_cells;
constexpr int piles_drawn = test::sanitized ? 40'000 : 300'000;

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
      {0.3, {1, 1, 1, 1}},         {1.0, {1, 1, 1, 1}},     {0.3, {1, 2, 1, 1}},     {0.6, {0.3, 1.8, 0.5, 1.4}},
      {0.8, {0.3, 1.8, 0.5, 1.4}}, {0.5, {1, 1, 1, 1}, 45}, {0.3, {1, 2, 1, 1}, 60}, {0.3, {1, 1, 1, 1}, 20},
  };
  for (const Setting& setting : settings) {
    const std::vector<double> load(setting.load.begin(), setting.load.end());
    const test::TwoLayerMoments on_fine =
        test::TwoLayerLaw(setting.mu, setting.load, fine_cells, setting.angle).moments();
    const std::vector<double> expected_coarse =
        listed(test::TwoLayerLaw(setting.mu, setting.load, coarse_cells, setting.angle).moments());
    const std::vector<double> expected_fine = listed(on_fine);

    const Lattice lattice({.columns = 4, .layers = 2, .angle = setting.angle});
    SamplerSpec spec;
    spec.mu = setting.mu;
    spec.seed = 2;
    const auto sampler = make_sampler(spec, lattice);
    std::vector<test::RunningMean> measured(14);
    Pile pile(lattice);
    for (int k = 0; k < piles_drawn; ++k) {
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

// Source of the expected numbers: ring_quadrature.h, the densities of the laws integrated over all splits of piles of
// four columns, on two grids; what the grids differ by at most, in
// units of a quantity's spread, is allowed as the error of the finer one.

struct LoadedPile {
  Law law;
  double lambda;
  double mu;
  int layers;
  std::array<double, 4> load;
  double angle = 30;
};

constexpr std::array<double, 4> equal = {1, 1, 1, 1}, uneven = {0.6, 1.5, 0.8, 1.1};

std::vector<LoadedPile> settings() {
  std::vector<LoadedPile> all;
  for (const int layers : {2, 3}) {
    for (const auto& [mu, load] : {std::pair{0.3, equal}, std::pair{0.7, uneven}}) {
      all.push_back({Law::rejection, 1, mu, layers, load});
      all.push_back({Law::eloy_clement, 1, mu, layers, load});
      for (const double lambda : {0.0, 0.5, 1.0}) all.push_back({Law::polytope, lambda, mu, layers, load});
    }
  }
  return all;
}

/// The means of what the quadrature gives, over groups of eight piles (one chain each).
std::vector<test::RunningMean> measure(const LoadedPile& setting, std::uint64_t piles) {
  const Lattice lattice({.columns = 4, .layers = setting.layers});
  SamplerSpec spec;
  spec.law = setting.law;
  spec.lambda = setting.lambda;
  spec.mu = setting.mu;
  spec.seed = 5;
  spec.effort = 1e6;
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(setting.load.begin(), setting.load.end());
  Pile pile(lattice);
  const std::size_t per_layer = test::SplitMoments::per_layer;
  std::vector<test::RunningMean> means(per_layer * static_cast<std::size_t>(setting.layers - 1));
  for (std::uint64_t group = 0; group < piles / 8; ++group) {
    std::vector<double> sums(means.size());
    for (std::uint64_t k = 0; k < 8; ++k) {
      if (sampler->draw(8 * group + k, load, pile)) throw std::runtime_error("stuck");
      for (std::size_t n = 0; n + 1 < static_cast<std::size_t>(setting.layers); ++n) {
        const double* const a = &pile.H_R[4 * n];
        for (std::size_t i = 0; i < 4; ++i) {
          sums[n * per_layer + i] += a[i] / 8;
          sums[n * per_layer + 4 + i] += a[i] * a[i] / 8;
          sums[n * per_layer + 8 + i] += a[i] * a[(i + 1) % 4] / 8;
          if (i < 2) sums[n * per_layer + 12 + i] += a[i] * a[i + 2] / 8;
        }
      }
    }
    for (std::size_t k = 0; k < means.size(); ++k) means[k].add(sums[k]);
  }
  return means;
}

std::vector<double> expected(const LoadedPile& setting, int cells) {
  // The top layer stands while the n above a failure are one: for failures_per_layer failures and the attempt before.
  const int kept =
      setting.law == Law::eloy_clement && setting.layers == 3 ? EloyClementSampler::failures_per_layer + 1 : 0;
  const auto moments = test::small_pile_moments(setting.mu, setting.load, setting.layers, setting.lambda, cells, kept);
  std::vector<double> all(moments.upper.begin(), moments.upper.end());
  if (setting.layers == 3) all.insert(all.end(), moments.lower.begin(), moments.lower.end());
  return all;
}

void compare(int cells, std::uint64_t independent, std::uint64_t chained, double resolution) {
  const auto all = settings();
  for (const LoadedPile& setting : all) {
    const int fine = setting.layers == 2 ? 4 * cells : cells, coarse = fine * 3 / 4;
    const auto on_coarse = expected(setting, coarse), on_fine = expected(setting, fine);
    const auto measured = measure(setting, setting.law == Law::polytope ? chained : independent);
    const double bound = test::sigma_bound(all.size() * measured.size());
    // Of single piles: means of eight scatter at least 1/sqrt 8 as much.
    const auto spread = [&](std::size_t k) { return std::sqrt(8 * measured[k].variance()); };
    double grid_share = 0;
    for (std::size_t k = 0; k < measured.size(); ++k) {
      grid_share = std::max(grid_share, std::abs(on_fine[k] - on_coarse[k]) / spread(k));
    }
    for (std::size_t k = 0; k < measured.size(); ++k) {
      const auto found = measured[k].estimate();
      const double grid_error = grid_share * spread(k);
      CAPTURE(name_of(setting.law), setting.lambda, setting.mu, setting.layers, k, found.value, found.error, on_fine[k],
              grid_error, spread(k));
      CHECK(std::abs(found.value - on_fine[k]) <= bound * found.error + grid_error);
      CHECK(bound * found.error + grid_error < resolution * spread(k));
    }
  }
}

TEST_CASE("two- and three-layer piles of every exact density follow its quadrature", "[unsanitized]") {
  compare(8, test::sanitized ? 4000 : 16'000, test::sanitized ? 1600 : 4000, test::sanitized ? 0.5 : 0.25);
}

TEST_CASE("two- and three-layer piles follow the quadrature, to percents", "[long]") {
  compare(12, 150'000, 40'000, 0.1);
}

// Source of the expected numbers: the law written a second time from its description, with another random engine. How
// often layers are drawn again is what tells how many of them each failure throws away.

struct PileSize {
  int columns, layers;
  double mu;
};

/// Layers of beads (V_R, V_L, H_R, H_L), drawn until the last one is complete.
class NaiveEloyClement {
 public:
  NaiveEloyClement(PileSize setting, unsigned seed)
      : setting_(setting), engine_(seed), pile_(static_cast<std::size_t>(setting.layers)) {
    const double phi = std::atan(setting.mu), thirty = std::acos(-1.0) / 6;
    low_ = std::tan(thirty - phi), high_ = std::tan(thirty + phi);
  }

  /// Draws a pile under an even load; how many attempts at a layer it took beyond the first of each.
  int draw() {
    std::vector<int> failures(pile_.size());
    std::size_t layer = 0;
    int attempts = 0;
    while (layer < pile_.size()) {
      ++attempts;
      if (complete(layer)) {
        failures[layer++] = 0;
        continue;
      }
      // One layer above for the first eight failures, two for the next eight, and so on.
      const int above = 1 + failures[layer]++ / EloyClementSampler::failures_per_layer;
      layer -= std::min<std::size_t>(layer, static_cast<std::size_t>(above));
    }
    return attempts - setting_.layers;
  }

  double thrust(std::size_t layer) const {
    double sum = 0;
    for (const Bead& bead : pile_[layer]) sum += bead.H_R - bead.H_L;
    return sum;
  }
  double weight_squares(std::size_t layer) const {
    double sum = 0;
    for (const Bead& bead : pile_[layer]) sum += std::pow(bead.V_R + bead.V_L, 2);
    return sum;
  }

 private:
  struct Bead {
    double V_R, V_L, H_R, H_L;
  };

  bool complete(std::size_t layer) {
    const auto columns = static_cast<std::size_t>(setting_.columns);
    std::vector<Bead> beads;
    for (std::size_t i = 0; i < columns; ++i) {
      double V_left = 0.5, V_right = 0.5, H = 0;
      if (layer > 0) {
        const std::vector<Bead>& above = pile_[layer - 1];
        // An odd layer lies half a bead to the right of an even one.
        const Bead& a = above[layer % 2 == 1 ? i : (i + columns - 1) % columns];
        const Bead& b = above[layer % 2 == 1 ? (i + 1) % columns : i];
        V_left = a.V_R, V_right = b.V_L, H = a.H_R + b.H_L;
      }
      const double V_R = V_right + std::sqrt(3.0) * H, V_L = V_left - std::sqrt(3.0) * H;
      const double from = std::max(low_ * V_R, H + low_ * V_L), to = std::min(high_ * V_R, H + high_ * V_L);
      if (V_R < 0 || V_L < 0 || from > to) return false;
      const double H_R = from + (to - from) * uniform_(engine_);
      beads.push_back({V_R, V_L, H_R, H - H_R});
    }
    pile_[layer] = beads;
    return true;
  }

  PileSize setting_;
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::vector<std::vector<Bead>> pile_;
  double low_ = 0, high_ = 0;
};

TEST_CASE("eloy-clement throws away as many layers as its description says, and draws its law") {
  const std::vector<PileSize> settings = {{6, 6, 0.3}, {5, 4, 0.45}, {4, 4, 0.6}};
  const int piles = 16'000 / (test::sanitized ? 8 : 1);
  for (const PileSize& setting : settings) {
    const Lattice lattice({.columns = setting.columns, .layers = setting.layers});
    SamplerSpec spec;
    spec.law = Law::eloy_clement;
    spec.mu = setting.mu;
    spec.seed = 12;
    spec.effort = 1e6;
    const auto sampler = make_sampler(spec, lattice);
    NaiveEloyClement naive(setting, 13);
    const auto layers = static_cast<std::size_t>(setting.layers);
    std::vector<RunningMean> found(1 + 2 * layers), expected(1 + 2 * layers);
    Pile pile(lattice);
    std::uint64_t redrawn_before = 0;
    for (int k = 0; k < piles; ++k) {
      if (sampler->draw(static_cast<std::uint64_t>(k),
                        std::vector<double>(static_cast<std::size_t>(setting.columns), 1.0), pile)) {
        throw std::runtime_error("stuck");
      }
      found[0].add(static_cast<double>(sampler->counts().redrawn_layers - redrawn_before));
      redrawn_before = sampler->counts().redrawn_layers;
      expected[0].add(naive.draw());
      for (std::size_t n = 0; n < layers; ++n) {
        double thrust = 0, squares = 0;
        for (int i = 0; i < setting.columns; ++i) {
          const std::size_t at = lattice.index(static_cast<int>(n), i);
          thrust += pile.H_R[at] - pile.H_L[at];
          squares += std::pow(pile.V_R[at] + pile.V_L[at], 2);
        }
        found[1 + 2 * n].add(thrust);
        found[2 + 2 * n].add(squares);
        expected[1 + 2 * n].add(naive.thrust(n));
        expected[2 + 2 * n].add(naive.weight_squares(n));
      }
    }
    const double bound = test::sigma_bound(settings.size() * found.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      if (!(expected[k].variance() > 1e-20)) continue;  // fixed by the load
      const auto one = found[k].estimate(), other = expected[k].estimate();
      CAPTURE(setting.columns, setting.layers, setting.mu, k, one.value, one.error, other.value, other.error);
      CHECK(std::abs(test::sigmas(one, other)) < bound);
      // Enough piles to see a twentieth of the spread, or an eighth of the redrawn layers.
      CHECK(bound * std::hypot(one.error, other.error) <
            (k == 0 ? other.value / 8 : std::sqrt(expected[k].variance()) / 10) * (test::sanitized ? 3 : 1));
    }
  }
}

// Source of the expected numbers: naive_rejection.h, the law written a second time, which draws its own piles of 6 x 6
// beads at mu = 0.3 under a uniform load.

constexpr std::size_t comparisons = 11;  ///< six thrust ratios, four variances, the acceptance

bool agree(Estimated measured, Estimated expected) {
  return std::abs(measured.value - expected.value) <=
         test::sigma_bound(comparisons) * std::hypot(measured.error, expected.error);
}

TEST_CASE("the rejection law meets a second implementation on 6 x 6 beads") {
  constexpr int accepted = 200'000 / test::share_of_samples;
  const Lattice lattice({.columns = 6, .layers = 6});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.seed = 3;
  CAPTURE(spec.seed, accepted);
  const auto expected = test::naive_rejection_moments(0.3, 6, 6, accepted, 5);
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(6, 1.0);
  Pile pile(lattice);
  std::array<RunningMean, 6> alpha, variance;
  for (std::uint64_t sample = 0; sample < accepted; ++sample) {
    if (sampler->draw(sample, load, pile)) throw std::runtime_error("no pile accepted");
    for (int n = 0; n < 6; ++n) {
      double thrust = 0, squares = 0;
      for (int i = 0; i < 6; ++i) {
        const std::size_t at = lattice.index(n, i);
        thrust += pile.H_R[at] - pile.H_L[at];
        squares += std::pow(pile.V_R[at] + pile.V_L[at] - 1, 2);
      }
      alpha[static_cast<std::size_t>(n)].add(std::sqrt(3.0) * thrust / 6);
      variance[static_cast<std::size_t>(n)].add(squares / 6);
    }
    if (sample % 100 == 0) {
      const AuditResult result = audit(pile);
      REQUIRE(result.max_balance_residual <= 1e-12);
      REQUIRE(result.max_cone_violation <= 1e-12);
      assert_identities(pile);
    }
  }
  for (std::size_t n = 0; n < 6; ++n) {
    const Estimated measured_alpha = alpha[n].estimate(), measured_variance = variance[n].estimate();
    const Estimated expected_alpha = expected.thrust_ratio[n].estimate();
    const Estimated expected_variance = expected.weight_variance[n].estimate();
    CAPTURE(n, measured_alpha.value, measured_alpha.error, measured_variance.value, measured_variance.error);
    CAPTURE(expected_alpha.value, expected_alpha.error, expected_variance.value, expected_variance.error);
    CHECK(agree(measured_alpha, expected_alpha));
    // Enough piles to tell neighbouring layers apart.
    CHECK(measured_alpha.error < (test::sanitized ? 4e-3 : 1e-3));
    if (n < 2) {
      // The load alone fixes the weights of the first two layers.
      CHECK(std::abs(measured_variance.value) < 1e-28);
    } else {
      CHECK(agree(measured_variance, expected_variance));
      CHECK(measured_variance.error < (test::sanitized ? 4e-3 : 1e-3));
    }
  }
  const auto tries = static_cast<double>(sampler->counts().tries);
  const double acceptance = accepted / tries;
  const double acceptance_error = std::sqrt(acceptance * (1 - acceptance) / tries);
  CAPTURE(acceptance, acceptance_error, expected.acceptance.value);
  CHECK(agree({acceptance, acceptance_error}, expected.acceptance));
  CHECK(acceptance_error < (test::sanitized ? 5e-4 : 1.5e-4));
}

// What is often expected of the exact law, and what the last layer alone looks like: beads below it would have to be
// solvable, too.
TEST_CASE("under the law rejection the thrust ratio settles below 1, and only the last layer comes near it") {
  constexpr int layers = 14, columns = 4, piles = test::sanitized ? 1000 : 8000;
  const Lattice lattice({.columns = columns, .layers = layers});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.seed = 4;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  std::array<RunningMean, layers> alpha;
  for (std::uint64_t sample = 0; sample < piles; ++sample) {
    if (sampler->draw(sample, std::vector<double>(columns, 1.0), pile)) throw std::runtime_error("no pile accepted");
    for (int n = 0; n < layers; ++n) {
      double thrust = 0;
      for (int i = 0; i < columns; ++i) thrust += pile.H_R[lattice.index(n, i)] - pile.H_L[lattice.index(n, i)];
      alpha[static_cast<std::size_t>(n)].add(std::sqrt(3.0) * thrust / columns);
    }
  }
  const double bound = test::sigma_bound(layers);
  const Estimated last = alpha.back().estimate();
  // From the third layer on, five above the bottom: at least 0.04 below 1, and below the last layer.
  for (std::size_t n = 3; n + 3 < layers; ++n) {
    const Estimated one = alpha[n].estimate();
    CAPTURE(n, one.value, one.error, last.value);
    CHECK(one.value + bound * one.error < (test::sanitized ? 1.0 : 0.97));
    CHECK(test::sigmas(last, one) > bound);
    CHECK(bound * one.error < (test::sanitized ? 0.05 : 0.02));
  }
  CHECK(std::abs(last.value - 1) < 0.03);
}

TEST_CASE("a pile that rejection cannot find within its tries is a named failure") {
  const Lattice lattice({.columns = 20, .layers = 20});
  SamplerSpec spec;
  spec.law = Law::rejection;
  spec.mu = 0.3;
  spec.max_tries = 50;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  const auto failure = sampler->draw(0, std::vector<double>(20, 1.0), pile);
  REQUIRE(failure.has_value());
  CHECK(failure->layer > 0);
  CHECK(failure->layer < 20);
  CHECK(sampler->counts().tries == 50);
}

// Source: without friction every half of a load runs straight down its lattice row (the paper's exact path: c = tan 30
// degrees, no width). The rows are followed here by x, not through the lattice's neighbours.

TEST_CASE("an overload splits into two halves that run straight down, exactly") {
  for (const Law law : {Law::granusolve, Law::rejection}) {
    for (const int columns : {4, 5, 40, 41}) {
      const double angle = columns > 5 ? 30 : 45, tangent = columns > 5 ? tan30 : 1;
      const Lattice lattice({.columns = columns, .layers = 60, .angle = angle});
      CHECK(59 * 0.5 * lattice.pitch() / (lattice.z(59) - lattice.z(0)) == Approx(tangent).epsilon(1e-14));  // c
      SamplerSpec spec;
      spec.law = law;
      spec.mu = 0;
      const auto sampler = make_sampler(spec, lattice);
      Pile pile(lattice);
      std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
      load[static_cast<std::size_t>(lattice.middle())] = 2;
      REQUIRE_FALSE(sampler->draw(0, load, pile).has_value());
      for (int n = 0; n < lattice.layers(); ++n) {
        for (int i = 0; i < columns; ++i) {
          // After n layers the halves stand at x = +n/2 and x = -n/2, wrapped around the ring.
          const auto meets = [&](double position) {
            const double distance = lattice.x(n, i) / lattice.pitch() - position;
            return std::abs(distance - columns * std::round(distance / columns)) < 0.25;
          };
          const std::size_t at = lattice.index(n, i);
          REQUIRE(pile.V_R[at] == (meets(0.5 * n) ? 1.0 : 0.5));
          REQUIRE(pile.V_L[at] == (meets(-0.5 * n) ? 1.0 : 0.5));
          REQUIRE(pile.H_R[at] == pile.V_R[at] * tangent);
          REQUIRE(pile.H_L[at] == -pile.V_L[at] * tangent);
        }
      }
      CHECK(pile.mu == 0);
      CHECK(pile.law == name_of(law));
      CHECK(pile.load == load);
      CHECK(audit(pile).max_balance_residual <= 1e-15);
      CHECK(audit(pile).max_cone_violation <= 1e-15);
      CHECK_NOTHROW(assert_identities(pile));
      CHECK(sampler->counts().uniforms == 0);
    }
  }
}

TEST_CASE("with next to no friction the sampled pile is the frictionless one up to the width of the cone") {
  // Over 10 layers the forces are sums of at most some 2^10 terms, each within mu of the contact's direction.
  constexpr double mu = 1e-9;
  const Lattice lattice({.columns = 12, .layers = 10});
  SamplerSpec spec;
  spec.mu = mu;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice), straight(lattice);
  std::vector<double> load(12, 1.0);
  load[6] = 2;
  REQUIRE_FALSE(sampler->draw(0, load, pile).has_value());
  fill_frictionless(load, straight);
  for (std::size_t at = 0; at < lattice.beads(); ++at) {
    REQUIRE(std::abs(pile.V_R[at] - straight.V_R[at]) < 1024 * mu);
    REQUIRE(std::abs(pile.H_L[at] - straight.H_L[at]) < 1024 * mu);
  }
  CHECK(audit(pile).max_cone_violation <= 1e-12);
}

// Source: the rule itself. What misses its band by up to 64 units in the last place of the forces summed is put onto
// the band's end; what misses it by more is a failure.

TEST_CASE("a bead may miss its band by 64 units in the last place and no more, and is put onto the band's end") {
  std::mt19937_64 engine(9);
  std::uniform_real_distribution<double> uniform(0.1, 2);
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  for (const double mu : {0.1, 0.3, 0.8, 1.3, 1.7}) {
    const FrictionCone cone(mu);
    for (int k = 0; k < 1000; ++k) {
      const double V_UL = uniform(engine), V_UR = uniform(engine);
      const Interval band = solvable_band(cone, V_UL, V_UR);
      for (const bool above : {false, true}) {
        const double end = above ? band.high : band.low;
        const double ulp = epsilon * (V_UL + V_UR + std::abs(end));
        for (const auto& [ulps, forgiven] : {std::pair{1.0, true}, {62.0, true}, {66.0, false}, {1000.0, false}}) {
          const Incoming in{V_UL, V_UR, above ? end + ulps * ulp : end - ulps * ulp};
          CAPTURE(mu, V_UL, V_UR, above, ulps);
          CHECK(misses_by_rounding(cone, in) == forgiven);
          CHECK(nearest_solvable(cone, in) == end);
        }
      }
      const double inside = band.low + (band.high - band.low) / 3;
      CHECK(nearest_solvable(cone, {V_UL, V_UR, inside}) == inside);
    }
  }
}

}  // namespace

}  // namespace granuscope
