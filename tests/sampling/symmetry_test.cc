// Source of the expected numbers: symmetry. Mirroring x -> -x and shifting the pile by a column map the law onto
// itself, so that whatever changes sign, or sums to zero, under them has mean zero. The same statistics are shown to
// see a law that lacks the symmetry: layers always solved from bead 0 rightwards.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

using test::RunningMean;

struct Setting {
  int columns, layers;
  double mu;
  bool point_load;
  LayerOrder order = LayerOrder::random;
  int piles;
  bool telling = false;  ///< so many piles tell a fixed order from a random one
  Law law = Law::granusolve;
  double lambda = 1;  ///< polytope
};

/// One number per pile and layer, whose mean is zero by symmetry.
using Statistic = std::function<double(const Pile&, int layer)>;

/// Largest deviation from zero over layers and statistics, in standard errors of independent piles, and how many.
struct Deviation {
  double sigmas = 0;
  std::size_t comparisons = 0;
  double error = 0;  ///< largest standard error of a mean, in units of the statistic's own spread
};

Deviation deviation_from_zero(const Setting& setting, const std::vector<Statistic>& statistics) {
  const Lattice lattice({.columns = setting.columns, .layers = setting.layers});
  SamplerSpec spec;
  spec.mu = setting.mu;
  spec.seed = 1618;
  spec.order = setting.order;
  spec.law = setting.law;
  spec.lambda = setting.lambda;
  spec.effort = 1e6;
  const auto sampler = make_sampler(spec, lattice);
  std::vector<double> load(static_cast<std::size_t>(setting.columns), 1.0);
  if (setting.point_load) load[static_cast<std::size_t>(lattice.middle())] = 2;
  Pile pile(lattice);
  std::vector<RunningMean> means(2 * statistics.size() * static_cast<std::size_t>(setting.layers));
  for (int k = 0; k < setting.piles; ++k) {
    // One sample of every eight: the others share the order of their layers.
    if (sampler->draw(8 * static_cast<std::uint64_t>(k), load, pile)) throw std::runtime_error("stuck");
    std::size_t at = 0;
    for (const Statistic& statistic : statistics) {
      double sum = 0;
      for (int n = 0; n < setting.layers; ++n) {
        const double here = statistic(pile, n);
        sum += here;
        means[at++].add(here);
        means[at++].add(sum);  // a drift adds up from layer to layer
      }
    }
  }
  Deviation worst;
  for (const RunningMean& mean : means) {
    const auto estimate = mean.estimate();
    // Constant up to rounding (sums of some hundred forces of order one): an identity, not a statistic.
    if (estimate.error * std::sqrt(setting.piles) < 1e-10) continue;
    worst.sigmas = std::max(worst.sigmas, std::abs(test::sigmas(estimate, {0, 0})));
    worst.error = std::max(worst.error, estimate.error / std::sqrt(mean.variance()));
    ++worst.comparisons;
  }
  return worst;
}

double weight(const Pile& pile, std::size_t at) { return pile.V_R[at] + pile.V_L[at]; }

/// Sums over a layer that change sign under x -> -x.
const std::vector<Statistic> odd_statistics = {
    // The net horizontal force.
    [](const Pile& pile, int n) {
      double sum = 0;
      for (int i = 0; i < pile.lattice.columns(); ++i) {
        sum += pile.H_R[pile.lattice.index(n, i)] + pile.H_L[pile.lattice.index(n, i)];
      }
      return sum;
    },
    // Its cube weighs the tails.
    [](const Pile& pile, int n) {
      double sum = 0;
      for (int i = 0; i < pile.lattice.columns(); ++i) {
        const std::size_t at = pile.lattice.index(n, i);
        sum += std::pow(pile.H_R[at], 3) + std::pow(pile.H_L[at], 3);
      }
      return sum;
    },
    // The weight right of the middle less the weight left of it (without the bead opposite, its own image).
    [](const Pile& pile, int n) {
      double sum = 0;
      for (int i = 0; i < pile.lattice.columns(); ++i) {
        const double x = pile.lattice.x(n, i), edge = 0.5 * pile.lattice.columns();
        sum += x == 0 || x == -edge ? 0 : std::copysign(weight(pile, pile.lattice.index(n, i)), x);
      }
      return sum;
    },
    // Its first harmonic.
    [](const Pile& pile, int n) {
      double sum = 0;
      for (int i = 0; i < pile.lattice.columns(); ++i) {
        const double angle = 2 * std::numbers::pi * pile.lattice.x(n, i) / pile.lattice.columns();
        sum += std::sin(angle) * weight(pile, pile.lattice.index(n, i));
      }
      return sum;
    },
    // Neighbouring weights: a heavy bead with a light one to its right, less the other way round.
    [](const Pile& pile, int n) {
      double sum = 0;
      for (int i = 0; i < pile.lattice.columns(); ++i) {
        const double here = weight(pile, pile.lattice.index(n, i));
        const double right = weight(pile, pile.lattice.index(n, pile.lattice.next(i)));
        sum += here * here * right - here * right * right;
      }
      return sum;
    },
};

/// First harmonics along a layer: zero on average if all columns are equal.
std::vector<Statistic> harmonic_statistics() {
  std::vector<Statistic> statistics;
  for (const bool sine : {false, true}) {
    for (const bool of_weight : {false, true}) {
      statistics.emplace_back([sine, of_weight](const Pile& pile, int n) {
        double sum = 0;
        for (int i = 0; i < pile.lattice.columns(); ++i) {
          const double angle = 2 * std::numbers::pi * i / pile.lattice.columns();
          const std::size_t at = pile.lattice.index(n, i);
          sum +=
              (sine ? std::sin(angle) : std::cos(angle)) * (of_weight ? std::pow(weight(pile, at), 2) : pile.H_R[at]);
        }
        return sum;
      });
    }
  }
  return statistics;
}

/// The mean is zero to five sigma of the whole test, and a mean of `resolution` times the spread would have been seen.
void check_zero(const Deviation& found, std::size_t settings, double resolution) {
  const double bound = test::sigma_bound(found.comparisons * settings);
  CHECK(found.comparisons >= 10);
  CHECK(found.sigmas < bound);
  CHECK(bound * found.error < resolution);
}

/// Ten thousand piles and more where they are small; a fifth of them when every access is checked.
int fewer_if_sanitized(int piles) { return test::sanitized ? piles / 2 : piles; }

/// The statistics are zero where layers are solved in a random order, and tell a fixed one.
void check_symmetry(const std::vector<Setting>& settings, const std::vector<Statistic>& statistics) {
  for (Setting setting : settings) {
    setting.piles = fewer_if_sanitized(setting.piles);
    CAPTURE(setting.columns, setting.layers, setting.mu, setting.point_load, setting.piles);
    const Deviation fair = deviation_from_zero(setting, statistics);
    check_zero(fair, settings.size(), 0.1);
    if (!setting.telling) continue;
    setting.order = LayerOrder::fixed;
    const Deviation fixed = deviation_from_zero(setting, statistics);
    CHECK(fixed.sigmas > (test::sanitized ? 6 : 10));
  }
}

TEST_CASE("left and right are equal, and the test would see it if layers were always solved rightwards",
          "[unsanitized]") {
  const std::vector<Setting> settings = {
      {.columns = 48, .layers = 40, .mu = 0.8, .point_load = true, .piles = 10'000, .telling = true},
      {.columns = 24, .layers = 20, .mu = 0.4, .point_load = true, .piles = 10'000, .telling = false},
      {.columns = 16, .layers = 12, .mu = 1.3, .point_load = true, .piles = 20'000, .telling = true},
      {.columns = 5, .layers = 4, .mu = 1.3, .point_load = false, .piles = 20'000, .telling = true},
      {.columns = 6, .layers = 4, .mu = 1.5, .point_load = true, .piles = 50'000, .telling = true},
      {.columns = 4, .layers = 3, .mu = 1.7, .point_load = true, .piles = 40'000, .telling = true},
      {.columns = 4, .layers = 3, .mu = 1.4, .point_load = false, .piles = 40'000, .telling = false},
  };
  check_symmetry(settings, odd_statistics);
}

TEST_CASE("all columns are equal, and the test would see it if layers always began at bead 0", "[unsanitized]") {
  const std::vector<Setting> settings = {
      {.columns = 24, .layers = 20, .mu = 0.4, .point_load = false, .piles = 10'000, .telling = false},
      {.columns = 12, .layers = 8, .mu = 1.3, .point_load = false, .piles = 10'000, .telling = true},
      {.columns = 5, .layers = 4, .mu = 1.3, .point_load = false, .piles = 20'000, .telling = true},
      {.columns = 6, .layers = 4, .mu = 1.5, .point_load = false, .piles = 20'000, .telling = true},
      {.columns = 4, .layers = 3, .mu = 1.7, .point_load = false, .piles = 50'000, .telling = true},
  };
  check_symmetry(settings, harmonic_statistics());
}

/// Moments of every split and of products of two in a layer; `mirrored`: of the image x -> -x of the pile.
std::vector<double> moments_of(const Pile& pile, bool mirrored) {
  const int columns = pile.lattice.columns();
  std::vector<double> all, splits(static_cast<std::size_t>(columns));
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    for (int i = 0; i < columns; ++i) {
      // A bead at x = i, or i + 1/2, has its image at -i, or -i - 1/2.
      const std::size_t at = pile.lattice.index(n, mirrored ? (2 * columns - i - n % 2) % columns : i);
      splits[static_cast<std::size_t>(i)] = mirrored ? -pile.H_L[at] : pile.H_R[at];
    }
    for (std::size_t i = 0; i < splits.size(); ++i) {
      all.push_back(splits[i]);
      for (std::size_t k = i; k < splits.size(); ++k) all.push_back(splits[i] * splits[k]);
    }
  }
  return all;
}

/// The law under a load against the mirror image of the law under that load's image.
TEST_CASE("a pile under a load and the image of one under the image of the load are of one law") {
  const std::vector<double> load = {1.6, 0.4, 0.2, 1.8}, image = {1.6, 1.8, 0.2, 0.4};
  constexpr int piles = 800'000 / test::share_of_samples;
  const Lattice lattice({.columns = 4, .layers = 2});
  SamplerSpec spec;
  spec.mu = 1.5;
  spec.seed = 31;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  std::vector<RunningMean> plain, mirrored;
  const auto add = [](const std::vector<double>& numbers, std::vector<RunningMean>& means) {
    means.resize(numbers.size());
    for (std::size_t j = 0; j < numbers.size(); ++j) means[j].add(numbers[j]);
  };
  for (std::uint64_t k = 0; k < piles; ++k) {
    if (sampler->draw(16 * k, load, pile)) throw std::runtime_error("stuck");
    add(moments_of(pile, false), plain);
    if (sampler->draw(16 * k + 8, image, pile)) throw std::runtime_error("stuck");
    add(moments_of(pile, true), mirrored);
  }
  CHECK(sampler->counts().rings > piles / 10);  // the rule whose symmetry hangs on the parent drawn first
  for (std::size_t j = 0; j < plain.size(); ++j) {
    const auto one = plain[j].estimate(), other = mirrored[j].estimate();
    CAPTURE(j, one.value, one.error, other.value, other.error);
    CHECK(std::abs(test::sigmas(one, other)) < test::sigma_bound(plain.size()));
    CHECK(std::hypot(one.error, other.error) < 0.002 * std::sqrt(test::share_of_samples * plain[j].variance()));
  }
}

/// Of two layers in which arcs have repaired something: sum over beads of u^3 v - u v^3, u and v being the numbers of
/// neighbours in the top layer less 1/2. No horizontal force enters that layer, so that numbers are turned round with
/// the pile, and the sum changes its sign.
RunningMean sides_of_arcs(LayerOrder order, std::uint64_t piles) {
  constexpr std::size_t columns = 16;
  const Lattice lattice({.columns = columns, .layers = 2});
  SamplerSpec spec;
  spec.mu = 0.9;
  spec.seed = 37;
  spec.order = order;
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(columns, 1.0);
  Pile pile(lattice);
  std::vector<double> numbers;
  RunningMean mean;
  for (std::uint64_t k = 0; k < piles; ++k) {
    const std::uint64_t arcs = sampler->counts().arcs;
    if (sampler->draw(8 * k, load, pile)) throw std::runtime_error("stuck");
    if (sampler->counts().arcs == arcs) continue;
    read_split_uniforms(pile, numbers);
    double sum = 0;
    for (std::size_t i = 0; i < columns; ++i) {
      const double u = numbers[i] - 0.5, v = numbers[(i + 1) % columns] - 0.5;
      sum += u * u * u * v - u * v * v * v;
    }
    mean.add(sum);
  }
  return mean;
}

// Parents along an arc are drawn one after the other, the first from all that the others leave it and the last from
// what is left: from the right as often as from the left.
TEST_CASE("arcs have no side, and the test would see it if they were always drawn from the right") {
  constexpr std::uint64_t piles = test::sanitized ? 50'000 : 200'000;
  const RunningMean fair = sides_of_arcs(LayerOrder::random, piles), fixed = sides_of_arcs(LayerOrder::fixed, piles);
  const auto sigmas = [](const RunningMean& mean) { return std::abs(test::sigmas(mean.estimate(), {0, 0})); };
  CAPTURE(fair.count(), sigmas(fair), fixed.count(), sigmas(fixed));
  CHECK(fair.count() > piles / 20);  // one pile in fifteen
  CHECK(sigmas(fair) < test::sigma_bound(1));
  CHECK(sigmas(fixed) > (test::sanitized ? 6 : 12));
}

/// Under a heavy bead, of piles with backtracks: u - v and u^2 v - u v^2, u and v being the numbers less 1/2 of the
/// beads at the right and at the left of it. They change their signs with left and right, as those of arcs do.
std::array<RunningMean, 2> sides_of_backtracks(LayerOrder order, std::uint64_t piles) {
  constexpr std::size_t columns = 8, heavy = 4;
  const Lattice lattice({.columns = columns, .layers = 3});
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.seed = 41;
  spec.order = order;
  const auto sampler = make_sampler(spec, lattice);
  std::vector<double> load(columns, 1.0), numbers;
  load[heavy] = 10;
  Pile pile(lattice);
  std::array<RunningMean, 2> means;
  for (std::uint64_t k = 0; k < piles; ++k) {
    const std::uint64_t backtracks = sampler->counts().backtracks;
    if (sampler->draw(8 * k, load, pile)) throw std::runtime_error("stuck");
    if (sampler->counts().backtracks == backtracks) continue;
    read_split_uniforms(pile, numbers);
    const double u = numbers[heavy + 1] - 0.5, v = numbers[heavy - 1] - 0.5;
    means[0].add(u - v);
    means[1].add(u * u * v - u * v * v);
  }
  return means;
}

// What a backtrack has unsolved is solved again in the direction of its layer, and repaired in it.
TEST_CASE("backtracks have no side, and the test would see it if layers were always solved rightwards") {
  constexpr std::uint64_t piles = test::sanitized ? 50'000 : 500'000;
  const auto fair = sides_of_backtracks(LayerOrder::random, piles),
             fixed = sides_of_backtracks(LayerOrder::fixed, piles);
  const auto worst = [](const std::array<RunningMean, 2>& means) {
    double sigmas = 0;
    for (const RunningMean& one : means) sigmas = std::max(sigmas, std::abs(test::sigmas(one.estimate(), {0, 0})));
    return sigmas;
  };
  CAPTURE(fair[0].count(), worst(fair), worst(fixed));
  CHECK(fair[0].count() > piles / 5);
  CHECK(worst(fair) < test::sigma_bound(2));
  if (!test::sanitized) CHECK(worst(fixed) > test::sigma_bound(2));  // fewer piles do not tell
}

// The other laws have no order that could be fixed.
void check_other_laws(int piles, int chained, double resolution) {
  std::vector<Setting> settings;
  for (const bool point_load : {true, false}) {
    settings.push_back(
        {.columns = 6, .layers = 5, .mu = 0.3, .point_load = point_load, .piles = piles, .law = Law::rejection});
    settings.push_back(
        {.columns = 6, .layers = 5, .mu = 0.3, .point_load = point_load, .piles = piles, .law = Law::eloy_clement});
    settings.push_back(
        {.columns = 5, .layers = 4, .mu = 0.6, .point_load = point_load, .piles = chained, .law = Law::eloy_clement});
    for (const double lambda : {0.0, 1.0}) {
      settings.push_back({.columns = 5,
                          .layers = 4,
                          .mu = 0.4,
                          .point_load = point_load,
                          .piles = chained,
                          .law = Law::polytope,
                          .lambda = lambda});
    }
  }
  for (const Setting& setting : settings) {
    CAPTURE(name_of(setting.law), setting.lambda, setting.columns, setting.layers, setting.mu, setting.point_load);
    check_zero(deviation_from_zero(setting, setting.point_load ? odd_statistics : harmonic_statistics()),
               settings.size(), resolution);
  }
}

TEST_CASE("left and right, and all columns, are equal under every law", "[unsanitized]") {
  check_other_laws(test::sanitized ? 2000 : 8000, test::sanitized ? 400 : 800, test::sanitized ? 0.4 : 0.25);
}

TEST_CASE("left and right, and all columns, are equal under every law, to a small part of any spread", "[long]") {
  check_other_laws(80'000, 20'000, 0.06);
}

}  // namespace
}  // namespace granuscope
