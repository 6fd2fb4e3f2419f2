// What must be equal: left and right, columns, positions along a shift, and edges without load.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::RunningMean;

// Source of the expected numbers: symmetry. Mirroring x -> -x and shifting the pile by a column map the law onto
// itself, so that whatever changes sign, or sums to zero, under them has mean zero. The same statistics are shown to
// see a law that lacks the symmetry: layers always solved from bead 0 rightwards.

struct SymmetricSetting {
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

Deviation deviation_from_zero(const SymmetricSetting& setting, const std::vector<Statistic>& statistics) {
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
void check_symmetry(const std::vector<SymmetricSetting>& settings, const std::vector<Statistic>& statistics) {
  for (SymmetricSetting setting : settings) {
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
  const std::vector<SymmetricSetting> settings = {
      {.columns = 48, .layers = 40, .mu = 0.8, .point_load = true, .piles = 4500, .telling = true},
      {.columns = 24, .layers = 20, .mu = 0.4, .point_load = true, .piles = 4500, .telling = false},
      {.columns = 16, .layers = 12, .mu = 1.3, .point_load = true, .piles = 20'000, .telling = true},
      {.columns = 5, .layers = 4, .mu = 1.3, .point_load = false, .piles = 20'000, .telling = true},
      {.columns = 6, .layers = 4, .mu = 1.5, .point_load = true, .piles = 50'000, .telling = true},
      {.columns = 4, .layers = 3, .mu = 1.7, .point_load = true, .piles = 40'000, .telling = true},
      {.columns = 4, .layers = 3, .mu = 1.4, .point_load = false, .piles = 40'000, .telling = false},
  };
  check_symmetry(settings, odd_statistics);
}

TEST_CASE("all columns are equal, and the test would see it if layers always began at bead 0", "[unsanitized]") {
  const std::vector<SymmetricSetting> settings = {
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
  std::vector<SymmetricSetting> settings;
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
  for (const SymmetricSetting& setting : settings) {
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

// Source of the expected numbers: the densities themselves. Along a shift of one layer's horizontal forces no length
// changes, so that under every density prod length^-lambda a pile lies uniformly between the two ends that the cones
// set to the shift. Under the flat measure the same holds along every null move. Ends are found here contact by
// contact.

/// A direction in the space of piles: what a unit step adds to every force.
struct Direction {
  explicit Direction(std::size_t beads) : V_R(beads), V_L(beads), H_R(beads), H_L(beads) {}
  std::vector<double> V_R, V_L, H_R, H_L;
};

Direction layer_shift(const Lattice& lattice, int layer) {
  Direction to(lattice.beads());
  for (int i = 0; i < lattice.columns(); ++i) {
    to.H_R[lattice.index(layer, i)] = 1;
    to.H_L[lattice.index(layer, i)] = -1;
  }
  return to;
}

/// One bead's split, and below it what keeps every other split's share of the balances: solved layer by layer.
Direction null_direction(const Lattice& lattice, int layer, int bead) {
  Direction to(lattice.beads());
  const std::size_t o = lattice.index(layer, bead);
  to.H_R[o] = 1, to.H_L[o] = -1;
  const double root = std::sqrt(3.0);
  const int below = lattice.layers() - 1 - layer;
  const int l = lattice.lower_left(layer, bead), r = lattice.lower_right(layer, bead);
  if (below >= 1) {
    const std::size_t L = lattice.index(layer + 1, l), R = lattice.index(layer + 1, r);
    to.H_R[L] = -1, to.V_R[L] = -root, to.V_L[L] = root;
    to.H_L[R] = 1, to.V_R[R] = root, to.V_L[R] = -root;
  }
  if (below >= 2) {
    const std::size_t ll = lattice.index(layer + 2, lattice.lower_left(layer + 1, l));
    const std::size_t lr = lattice.index(layer + 2, lattice.lower_right(layer + 1, l));
    const std::size_t rr = lattice.index(layer + 2, lattice.lower_right(layer + 1, r));
    to.V_R[ll] = root;
    to.H_R[lr] = -1, to.H_L[lr] = 1, to.V_R[lr] = -root, to.V_L[lr] = -root;
    to.V_L[rr] = root;
  }
  if (below >= 3) {
    const int lr = lattice.lower_right(layer + 1, l);
    to.H_R[lattice.index(layer + 3, lattice.lower_left(layer + 2, lr))] = 1;
    to.H_L[lattice.index(layer + 3, lattice.lower_right(layer + 2, lr))] = -1;
  }
  return to;
}

/// Where between the ends of that direction the pile lies, in [0, 1].
double position_along(const Pile& pile, const Direction& to) {
  const FrictionCone cone(pile.mu);
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  // slack + t * growth >= 0
  const auto keep = [&](double slack, double growth) {
    if (growth > 0) low = std::max(low, -slack / growth);
    if (growth < 0) high = std::min(high, -slack / growth);
  };
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    keep(pile.H_R[k] - cone.t_minus() * pile.V_R[k], to.H_R[k] - cone.t_minus() * to.V_R[k]);
    keep(cone.t_plus() * pile.V_R[k] - pile.H_R[k], cone.t_plus() * to.V_R[k] - to.H_R[k]);
    keep(-pile.H_L[k] - cone.t_minus() * pile.V_L[k], -to.H_L[k] - cone.t_minus() * to.V_L[k]);
    keep(cone.t_plus() * pile.V_L[k] + pile.H_L[k], cone.t_plus() * to.V_L[k] + to.H_L[k]);
  }
  return -low / (high - low);
}

/// Mean, square and first harmonic of a position less their values if it is uniform, over groups of eight piles and
/// over the directions of each set.
void check_uniform(Law law, double lambda, const Lattice& lattice, const std::vector<std::vector<Direction>>& sets,
                   std::uint64_t groups, double resolution) {
  SamplerSpec spec;
  spec.law = law;
  spec.lambda = lambda;
  spec.mu = 0.3;
  spec.seed = 17;
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  Pile pile(lattice);
  std::vector<RunningMean> means(3 * sets.size());
  for (std::uint64_t g = 0; g < groups; ++g) {
    std::vector<double> sums(means.size());
    for (std::uint64_t k = 0; k < 8; ++k) {
      if (sampler->draw(8 * g + k, load, pile)) throw std::runtime_error("stuck");
      for (std::size_t d = 0; d < sets.size(); ++d) {
        const double share = 1 / (8.0 * static_cast<double>(sets[d].size()));
        for (const Direction& direction : sets[d]) {
          const double u = position_along(pile, direction);
          sums[3 * d] += (u - 0.5) * share;
          sums[3 * d + 1] += (u * u - 1.0 / 3) * share;
          sums[3 * d + 2] += std::cos(2 * std::numbers::pi * u) * share;
        }
      }
    }
    for (std::size_t j = 0; j < sums.size(); ++j) means[j].add(sums[j]);
  }
  for (std::size_t j = 0; j < means.size(); ++j) {
    const auto found = means[j].estimate();
    CAPTURE(name_of(law), lambda, j, found.value, found.error);
    CHECK(std::abs(found.value) < test::sigma_bound(means.size()) * found.error);
    CHECK(found.error < resolution * (test::sanitized ? 4 : 1));
  }
}

TEST_CASE("a pile lies uniformly along the shift of a layer, under the exact law and every chain", "[unsanitized]") {
  const Lattice lattice({.columns = 5, .layers = 5});
  std::vector<std::vector<Direction>> shifts;
  for (int n = 0; n < lattice.layers(); ++n) shifts.push_back({layer_shift(lattice, n)});
  check_uniform(Law::rejection, 1, lattice, shifts, 2700 / test::share_of_samples, 0.005);
  for (const double lambda : {0.0, 0.5, 1.0}) {
    check_uniform(Law::polytope, lambda, lattice, shifts, 700 / test::share_of_samples, 0.01);
  }
}

TEST_CASE("under the flat measure a pile lies uniformly along every null move") {
  const Lattice lattice({.columns = 5, .layers = 5});
  std::vector<std::vector<Direction>> moves(static_cast<std::size_t>(lattice.layers()));
  for (int n = 0; n < lattice.layers(); ++n) {
    for (int i = 0; i < lattice.columns(); ++i) {
      moves[static_cast<std::size_t>(n)].push_back(null_direction(lattice, n, i));
    }
  }
  check_uniform(Law::polytope, 0, lattice, moves, 4000 / test::share_of_samples, 0.003);
}

// Source: Coulomb's cone and the balances, written again here, and difference constraints decided by shortest paths.
// Once the top layer's splits are drawn, everything that the splits a_j of the next layer must fulfil so that the layer
// below is solvable has the form a_j - a_k <= b: the shortest paths between all pairs tell whether there is a solution,
// and between which numbers each a_j may lie.

constexpr std::size_t columns = 6;
constexpr std::array<double, columns> half_loaded = {0, 0, 0, 1, 1, 1};
/// Sums of a few forces of order one round by less; what is left of a range of that width is one value.
constexpr double rounding = 1e-12;

struct Range {
  double low, high;
};

struct Received {
  double V_UL, V_UR, H;
};

class Cone {
 public:
  explicit Cone(double mu)
      : flat_((1 / std::sqrt(3.0) - mu) / (1 + mu / std::sqrt(3.0))),
        steep_((1 / std::sqrt(3.0) + mu) / (1 - mu / std::sqrt(3.0))) {}

  Range split(const Received& in) const {
    const double V_R = right(in), V_L = left(in);
    return {std::max(flat_ * V_R, flat_ * V_L + in.H), std::min(steep_ * V_R, steep_ * V_L + in.H)};
  }
  /// H with which a bead is solvable.
  Range band(double V_UL, double V_UR) const {
    const double k = std::sqrt(3.0) * (flat_ + steep_) - 1;
    return {std::max(-V_UR / std::sqrt(3.0), (flat_ * V_UL - steep_ * V_UR) / k),
            std::min(V_UL / std::sqrt(3.0), (steep_ * V_UL - flat_ * V_UR) / k)};
  }
  static double right(const Received& in) { return in.V_UR + std::sqrt(3.0) * in.H; }
  static double left(const Received& in) { return in.V_UL - std::sqrt(3.0) * in.H; }

 private:
  double flat_, steep_;
};

using Layer = std::array<Received, columns>;

/// What the beads between the splits a_j and a_{j+1} receive.
Layer below(const Layer& layer, const std::array<double, columns>& a) {
  Layer next;
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t k = (j + 1) % columns;
    next[j] = {Cone::right(layer[j]), Cone::left(layer[k]), a[j] + layer[k].H - a[k]};
  }
  return next;
}

Layer top_layer() {
  Layer top;
  for (std::size_t j = 0; j < columns; ++j) top[j] = {half_loaded[j] / 2, half_loaded[j] / 2, 0};
  return top;
}

/// Between which numbers each split of a layer may lie if the layer below is to be solvable, or nothing.
std::optional<std::array<Range, columns>> ranges_of(const Cone& cone, const Layer& layer) {
  constexpr std::size_t zero = columns, nodes = columns + 1;
  std::array<std::array<double, nodes>, nodes> most{};  // most[i][j]: the least known bound of x_j - x_i
  for (auto& row : most) row.fill(INFINITY);
  for (std::size_t i = 0; i < nodes; ++i) most[i][i] = 0;
  const auto bound = [&](std::size_t from, std::size_t to, double by) {
    most[from][to] = std::min(most[from][to], by);
  };
  for (std::size_t j = 0; j < columns; ++j) {
    const std::size_t k = (j + 1) % columns;
    const Range own = cone.split(layer[j]), H = cone.band(Cone::right(layer[j]), Cone::left(layer[k]));
    bound(zero, j, own.high);
    bound(j, zero, -own.low);
    bound(k, j, H.high - layer[k].H);
    bound(j, k, layer[k].H - H.low);
  }
  for (std::size_t via = 0; via < nodes; ++via) {
    for (std::size_t i = 0; i < nodes; ++i) {
      for (std::size_t j = 0; j < nodes; ++j) bound(i, j, most[i][via] + most[via][j]);
    }
  }
  std::array<Range, columns> ranges{};
  for (std::size_t i = 0; i < nodes; ++i) {
    if (most[i][i] < -rounding) return std::nullopt;
    if (i < columns) ranges[i] = {-most[i][zero], most[zero][i]};
  }
  return ranges;
}

/// A top layer drawn until the layer below it is solvable.
Layer random_second_layer(const Cone& cone, std::mt19937_64& engine) {
  const Layer top = top_layer();
  const auto allowed = ranges_of(cone, top);
  REQUIRE(allowed.has_value());
  for (;;) {
    std::array<double, columns> a{};
    for (std::size_t j = 0; j < columns; ++j) {
      a[j] = std::uniform_real_distribution<double>(0, 1)(engine);
      a[j] = (*allowed)[j].low + a[j] * ((*allowed)[j].high - (*allowed)[j].low);
    }
    const Layer second = below(top, a);
    if (std::all_of(second.begin(), second.end(), [&](const Received& in) {
          const Range band = cone.band(in.V_UL, in.V_UR);
          return in.H >= band.low - rounding && in.H <= band.high + rounding;
        }))
      return second;
  }
}

TEST_CASE("beside unloaded beads: no solution below 1/sqrt 3, single values at it, ranges above it") {
  constexpr unsigned seed = 17;
  constexpr int top_layers = 200;
  CAPTURE(seed);
  for (const double mu : {0.3, 0.57, 1 / std::sqrt(3.0), 0.6, 1.0}) {
    const Cone cone(mu);
    std::mt19937_64 engine(seed);
    int solvable = 0, with_single_value = 0;
    for (int k = 0; k < top_layers; ++k) {
      const Layer second = random_second_layer(cone, engine);
      const auto ranges = ranges_of(cone, second);
      if (!ranges) continue;
      ++solvable;
      // A bead that receives something, and yet has no choice although its own interval leaves it one.
      for (std::size_t j = 0; j < columns; ++j) {
        const Range own = cone.split(second[j]);
        if (own.high - own.low > 1e-3 && (*ranges)[j].high - (*ranges)[j].low < rounding) {
          ++with_single_value;
          break;
        }
      }
    }
    CAPTURE(mu, solvable, with_single_value);
    if (mu < 0.571) CHECK(solvable == 0);
    if (mu > 0.571) CHECK(solvable > top_layers / 2);
    CHECK(with_single_value == (mu > 0.571 && mu < 0.59 ? solvable : 0));
  }
}

TEST_CASE("the frictionless pile solves a half-loaded top at any friction, but a law needs more than single piles") {
  const Lattice lattice({.columns = columns, .layers = 30});
  const std::vector<double> load(half_loaded.begin(), half_loaded.end());
  for (const double mu : {0.3, std::nextafter(tan30, 0.0), tan30, std::nextafter(tan30, 1.0), 1.0}) {
    Pile pile(lattice);
    pile.load = load;
    fill_frictionless(load, pile);
    pile.mu = mu;
    CAPTURE(mu);
    CHECK(audit(pile).max_balance_residual <= rounding);
    CHECK(audit(pile).max_cone_violation <= rounding);
    SamplerSpec spec;
    spec.mu = mu;
    const auto sampler = make_sampler(spec, lattice);
    if (mu < tan30) {
      CHECK_THROWS_AS(sampler->draw(0, load, pile), InputError);
    } else if (!sampler->draw(0, load, pile)) {
      CHECK(audit(pile).max_balance_residual <= 1e-10);
      CHECK(audit(pile).max_cone_violation <= 1e-10);
    } else {
      CHECK(mu == tan30);  // stuck, by name
    }
  }
}

}  // namespace

}  // namespace granuscope
