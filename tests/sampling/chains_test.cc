// The chains of the law polytope: their plan, their moves and what they draw.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "kit/naive_rejection.h"
#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/equilibrium.h"
#include "model/lattice.h"
#include "model/pile.h"
#include "sampling/polytope.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using test::RunningMean;

// Sources: autocorrelations and powers known in closed form; the law rejection, which polytope must meet at lambda = 1;
// rejection piles reweighted by the product of their lengths, which is the flat measure; and for 6 x 6 beads
// naive_rejection.h, the law rejection written a second time.

/// Thrust, mean square and mean cube of the weights, and neighbours' product, of every layer.
std::vector<double> numbers_of(const Pile& pile) {
  std::vector<double> all;
  const Lattice& lattice = pile.lattice;
  for (int n = 0; n < lattice.layers(); ++n) {
    double thrust = 0, squares = 0, cubes = 0, neighbours = 0;
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t at = lattice.index(n, i), beside = lattice.index(n, lattice.next(i));
      const double w = pile.V_R[at] + pile.V_L[at], v = pile.V_R[beside] + pile.V_L[beside];
      thrust += pile.H_R[at] - pile.H_L[at];
      squares += w * w, cubes += w * w * w, neighbours += w * v;
    }
    all.insert(all.end(), {thrust, squares, cubes, neighbours});
  }
  return all;
}

double product_of_lengths(const Pile& pile) {
  const FrictionCone cone(pile.mu);
  double product = 1;
  for (std::size_t k = 0; k < pile.lattice.beads(); ++k) {
    const Interval interval = split_interval(cone, {pile.V_R[k], pile.V_L[k]}, pile.H_R[k] + pile.H_L[k]);
    product *= interval.high - interval.low;
  }
  return product;
}

struct Size {
  int columns, layers;
  double mu;
  double angle = 30;
};

SamplerSpec chain_spec(Law law, double mu, double lambda = 1) {
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.lambda = lambda;
  spec.seed = 11;
  return spec;
}

/// Means over groups of eight: groups are independent under every law.
std::vector<RunningMean> measure(const Size& size, const SamplerSpec& spec, std::uint64_t groups) {
  const Lattice lattice({.columns = size.columns, .layers = size.layers, .angle = size.angle});
  const auto sampler = make_sampler(spec, lattice);
  const std::vector<double> load(static_cast<std::size_t>(size.columns), 1.0);
  Pile pile(lattice);
  std::vector<RunningMean> means;
  for (std::uint64_t group = 0; group < groups; ++group) {
    std::vector<double> sums;
    for (std::uint64_t k = 0; k < 8; ++k) {
      if (sampler->draw(8 * group + k, load, pile)) throw std::runtime_error("stuck");
      const auto numbers = numbers_of(pile);
      sums.resize(numbers.size());
      for (std::size_t j = 0; j < numbers.size(); ++j) sums[j] += numbers[j] / 8;
    }
    means.resize(sums.size());
    for (std::size_t j = 0; j < sums.size(); ++j) means[j].add(sums[j]);
    if (group % 64 == 0) {
      assert_identities(pile);
      REQUIRE(audit(pile).max_balance_residual <= 1e-12);
      REQUIRE(audit(pile).max_cone_violation <= 1e-12);
    }
  }
  return means;
}

const std::vector<Size> sizes = {{4, 3, 0.8}, {6, 6, 0.3}, {5, 5, 0.15}, {4, 2, 1.3}};

void compare_with_rejection(std::uint64_t groups, double resolution) {
  for (const Size& size : sizes) {
    const auto exact = measure(size, chain_spec(Law::rejection, size.mu), 2 * groups);
    const auto chain = measure(size, chain_spec(Law::polytope, size.mu), groups);
    std::size_t comparisons = 0;
    for (std::size_t j = 0; j < exact.size(); ++j) comparisons += exact[j].variance() > 1e-20 ? 1 : 0;
    CHECK(comparisons >= 2);  // two layers have no more than their thrusts
    for (std::size_t j = 0; j < exact.size(); ++j) {
      if (!(exact[j].variance() > 1e-20)) continue;  // fixed by the load
      const auto a = exact[j].estimate(), b = chain[j].estimate();
      CAPTURE(size.columns, size.layers, size.mu, j, a.value, a.error, b.value, b.error);
      CHECK(std::abs(test::sigmas(a, b)) < test::sigma_bound(sizes.size() * comparisons));
      CHECK(std::hypot(a.error, b.error) < resolution * std::sqrt(8 * exact[j].variance()));
    }
  }
}

TEST_CASE("the chain at lambda = 1 draws the law rejection", "[unsanitized]") {
  compare_with_rejection(test::sanitized ? 100 : 160, test::sanitized ? 0.12 : 0.06);
}

TEST_CASE("the chain at lambda = 1 draws the law rejection, to a percent", "[long]") {
  compare_with_rejection(3000, 0.015);
}

// The flat measure from piles of another density: weights prod(length), means as ratios, errors of ratios.
TEST_CASE("the chain at lambda = 0 draws the flat measure: rejection piles reweighted by their lengths") {
  const std::vector<Size> small = {{4, 2, 0.3}, {4, 3, 0.3}, {5, 3, 0.4}};
  for (const Size& size : small) {
    const Lattice lattice({.columns = size.columns, .layers = size.layers});
    const auto sampler = make_sampler(chain_spec(Law::rejection, size.mu), lattice);
    const std::vector<double> load(static_cast<std::size_t>(size.columns), 1.0);
    Pile pile(lattice);
    const int piles = test::sanitized ? 10'000 : 50'000;
    std::vector<std::vector<double>> rows;
    std::vector<double> weights;
    double total = 0, total_squares = 0;
    for (int k = 0; k < piles; ++k) {
      if (sampler->draw(static_cast<std::uint64_t>(k), load, pile)) throw std::runtime_error("stuck");
      weights.push_back(product_of_lengths(pile));
      rows.push_back(numbers_of(pile));
      total += weights.back(), total_squares += weights.back() * weights.back();
    }
    // As many equally weighted piles; too few would tell nothing.
    CHECK(total * total / total_squares > 1000);
    const auto chain = measure(size, chain_spec(Law::polytope, size.mu, 0), test::sanitized ? 200 : 800);
    for (std::size_t j = 0; j < chain.size(); ++j) {
      if (!(chain[j].variance() > 1e-20)) continue;
      double mean = 0, error = 0;
      for (std::size_t k = 0; k < weights.size(); ++k) mean += weights[k] * rows[k][j] / total;
      for (std::size_t k = 0; k < weights.size(); ++k) error += std::pow(weights[k] * (rows[k][j] - mean) / total, 2);
      const test::Estimated exact{mean, std::sqrt(error)}, found = chain[j].estimate();
      CAPTURE(size.columns, size.layers, size.mu, j, exact.value, exact.error, found.value, found.error);
      CHECK(std::abs(test::sigmas(exact, found)) < test::sigma_bound(small.size() * chain.size()));
      CHECK(std::hypot(exact.error, found.error) < 0.1 * std::sqrt(8 * chain[j].variance()));
    }
  }
}

TEST_CASE("the chain at lambda = 1 meets a second implementation of the law rejection on 6 x 6 beads",
          "[unsanitized]") {
  const double angle = GENERATE(30.0, 45.0), cot = 1 / std::tan(angle * std::numbers::pi / 180);
  CAPTURE(angle);
  const auto expected = test::naive_rejection_moments(0.3, 6, 6, 200'000 / test::share_of_samples, 7, angle);
  const auto means = measure({6, 6, 0.3, angle}, chain_spec(Law::polytope, 0.3), test::sanitized ? 100 : 200);
  for (std::size_t n = 0; n < 6; ++n) {
    const auto thrust = means[4 * n].estimate(), squares = means[4 * n + 1].estimate();
    const test::Estimated alpha = {cot * thrust.value / 6, cot * thrust.error / 6};
    const test::Estimated variance = {squares.value / 6 - 1, squares.error / 6};
    const auto expected_alpha = expected.thrust_ratio[n].estimate();
    const auto expected_variance = expected.weight_variance[n].estimate();
    CAPTURE(n, alpha.value, alpha.error, expected_alpha.value, variance.value, variance.error, expected_variance.value);
    CHECK(std::abs(test::sigmas(alpha, expected_alpha)) <= test::sigma_bound(10));
    CHECK(alpha.error < (test::sanitized ? 12e-3 : 6e-3));
    if (n < 2) continue;
    CHECK(std::abs(test::sigmas(variance, expected_variance)) <= test::sigma_bound(10));
    CHECK(variance.error < (test::sanitized ? 15e-3 : 8e-3));
  }
}

/// Independent chains number `first` and after from one kind of start, each after that many sweeps in all.
std::vector<RunningMean> after_sweeps(const Size& size, double lambda, int first, int chains, std::uint64_t sweeps,
                                      const std::function<Pile(int chain)>& start) {
  std::vector<RunningMean> means;
  for (int number = first; number < first + chains; ++number) {
    PolytopeChain chain(FrictionCone(size.mu), Lattice({.columns = size.columns, .layers = size.layers}), 0);
    chain.set(start(number));
    const RandomKey key(23, static_cast<std::uint64_t>(number));
    for (std::uint32_t sweep = 1; sweep <= sweeps; ++sweep) {
      if (sweep == flat_sweeps + 1) chain.set_lambda(lambda);
      chain.sweep([&](int layer, int bead) { return key.chain_move(layer, bead, sweep); });
    }
    const std::vector<double> numbers = numbers_of(chain.pile());
    means.resize(numbers.size());
    for (std::size_t j = 0; j < numbers.size(); ++j) means[j].add(numbers[j]);
  }
  return means;
}

// Three starts from both sides of the law: weights that scatter more than under it (granusolve) and not at all, with
// the least thrust that the cones allow and with the most. Different chains have different keys, so that nothing makes
// them meet but the law.
TEST_CASE("chains from unlike starts have forgotten them after the burn-in, and the test would see if they had not",
          "[unsanitized]") {
  const Size size{6, 6, 0.3};
  const Lattice lattice({.columns = size.columns, .layers = size.layers});
  const FrictionCone cone(size.mu);
  const std::vector<double> load(static_cast<std::size_t>(size.columns), 1.0);
  const auto granusolve = make_sampler(chain_spec(Law::granusolve, size.mu), lattice);
  /// Every contact carries half a load vertically and the same part of its cone sideways.
  const auto even = [&](double tangent) {
    Pile pile(lattice);
    pile.mu = size.mu;
    pile.load = load;
    for (std::size_t k = 0; k < lattice.beads(); ++k) {
      pile.V_R[k] = pile.V_L[k] = 0.5;
      pile.H_R[k] = 0.5 * tangent;
      pile.H_L[k] = -pile.H_R[k];
    }
    return pile;
  };
  const std::vector<std::function<Pile(int)>> starts = {
      [&](int number) {
        Pile pile(lattice);
        if (granusolve->draw(8 * static_cast<std::uint64_t>(number), load, pile)) throw std::runtime_error("stuck");
        return pile;
      },
      [&](int) { return even(cone.t_minus()); }, [&](int) { return even(cone.t_plus()); }};
  const int chains = test::sanitized ? 120 : 400;
  for (const double lambda : {0.0, 1.0}) {
    const ChainPlan plan = plan_chain(chain_spec(Law::polytope, size.mu, lambda), lattice, load);
    const auto worst_sigmas = [&](std::uint64_t sweeps, double& error, std::size_t& comparisons) {
      std::vector<std::vector<RunningMean>> measured;
      for (std::size_t s = 0; s < starts.size(); ++s) {
        measured.push_back(after_sweeps(size, lambda, static_cast<int>(s) * chains, chains, sweeps, starts[s]));
      }
      double worst = 0;
      comparisons = 0;
      for (std::size_t j = 0; j < measured[0].size(); ++j) {
        for (std::size_t s = 1; s < starts.size(); ++s) {
          const auto &one = measured[0][j], &other = measured[s][j];
          if (!(one.variance() > 1e-20) || !(other.variance() > 1e-20)) continue;
          worst = std::max(worst, std::abs(test::sigmas(one.estimate(), other.estimate())));
          error = std::max(error, std::hypot(one.estimate().error, other.estimate().error) / std::sqrt(one.variance()));
          ++comparisons;
        }
      }
      return worst;
    };
    double error = 0, error_early = 0;
    std::size_t comparisons = 0, comparisons_early = 0;
    const double early = worst_sigmas(2, error_early, comparisons_early);
    const double after = worst_sigmas(flat_sweeps + plan.burn_in, error, comparisons);
    CAPTURE(lambda, plan.burn_in, plan.autocorrelation_time, early, after, error, comparisons);
    CHECK(comparisons > 20);
    CHECK(after < test::sigma_bound(2 * comparisons));
    CHECK(error < (test::sanitized ? 0.2 : 0.1));
    CHECK(early > test::sigma_bound(2 * comparisons_early));
  }
}

TEST_CASE("moves keep every balance, cone and identity without any repair") {
  constexpr std::uint32_t sweeps = test::sanitized ? 400 : 2000;
  const Lattice lattice({.columns = 7, .layers = 9});
  for (const double mu : {0.1, 0.5773502691896258, 1.2}) {
    for (const double lambda : {0.0, 0.4, 1.0}) {
      const auto start = make_sampler(chain_spec(Law::granusolve, mu), lattice);
      Pile pile(lattice);
      REQUIRE_FALSE(start->draw(0, std::vector<double>(7, 1.0), pile).has_value());
      PolytopeChain chain(FrictionCone(mu), lattice, lambda);
      chain.set(pile);
      const RandomKey key(4, 2);
      for (std::uint32_t sweep = 1; sweep <= sweeps; ++sweep) {
        chain.sweep([&](int layer, int bead) { return key.chain_move(layer, bead, sweep); });
      }
      CAPTURE(mu, lambda, chain.moves(), chain.accepted_moves());
      CHECK(chain.moves() == sweeps * (7 + 1) * 9);
      CHECK(chain.accepted_moves() > chain.moves() / 4);
      for (const bool stored : {false, true}) {
        if (stored) chain.store(pile);
        const AuditResult result = audit(stored ? pile : chain.pile());
        CHECK(result.max_balance_residual <= 1e-12);
        CHECK(result.max_cone_violation <= 1e-12);
        assert_identities(stored ? pile : chain.pile());
      }
    }
  }
}

TEST_CASE("the autocorrelation time of a series that forgets by a factor each step is known") {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  for (const double memory : {0.0, 0.5, 0.9, 0.98}) {
    std::vector<double> series;
    series.reserve(100'000);
    double x = 0;
    for (int k = 0; k < 100'000; ++k) series.push_back(x = memory * x + normal(engine));
    const double expected = (1 + memory) / (1 - memory);
    // Windows of three times `expected`: relative error sqrt(2 (2 windows + 1)/100 000).
    const double error = expected * std::sqrt(2 * (6 * expected + 1) / 100'000);
    CAPTURE(memory, expected, error);
    CHECK(std::abs(autocorrelation_time(series, 1) - expected) < test::sigma_bound(4) * error + 0.01 * expected);
    CHECK(error < 0.12 * expected);
    CHECK(autocorrelation_time(series, 1e12) == 1);  // less than rounding in numbers of that size
  }
  CHECK(autocorrelation_time(std::vector<double>(100, 3.0), 3) == 1);
}

TEST_CASE("a power without libm is the power") {
  std::mt19937_64 engine(8);
  std::uniform_real_distribution<double> exponent(0, 1), log_base(-300, 300);
  for (int k = 0; k < 10'000; ++k) {
    const double base = std::pow(10.0, log_base(engine)), y = exponent(engine);
    CHECK(portable_power(base, y) == Approx(std::pow(base, y)).epsilon(1e-12));
  }
  CHECK(portable_power(0.3, 1) == 0.3);
  CHECK(portable_power(0.3, 0) == 1);
  CHECK(portable_power(INFINITY, 0.5) == INFINITY);
}

/// The thrust of every layer, and the excess of the weight on either of two halves of it.
std::vector<double> slow_numbers(const Pile& pile) {
  std::vector<double> all;
  const int columns = pile.lattice.columns();
  for (int n = 0; n < pile.lattice.layers(); ++n) {
    double thrust = 0;
    std::array<double, 2> halves{};
    for (int i = 0; i < columns; ++i) {
      const std::size_t at = pile.lattice.index(n, i);
      const double weight = pile.V_R[at] + pile.V_L[at];
      thrust += pile.H_R[at] - pile.H_L[at];
      for (int k = 0; k < 2; ++k) {
        halves[static_cast<std::size_t>(k)] +=
            (i + columns - k * columns / 4) % columns < columns / 2 ? weight : -weight;
      }
    }
    all.insert(all.end(), {thrust, halves[0], halves[1]});
  }
  return all;
}

/// Sweeps that weigh as much as one independent pile, of the slowest of these numbers, from how means over independent
/// chains scatter: n (variance of means over n sweeps)/(variance of the number). No correlation is looked at.
test::Estimated time_from_independent_chains(const SamplerSpec& spec, const Lattice& lattice, int chains,
                                             std::uint64_t burn_in, std::uint64_t sweeps) {
  const std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  const auto granusolve = make_sampler(start_of_chain(spec), lattice);
  Pile pile(lattice);
  std::vector<RunningMean> means, singles;
  for (int number = 0; number < chains; ++number) {
    if (granusolve->draw(8 * static_cast<std::uint64_t>(number), load, pile)) throw std::runtime_error("stuck");
    PolytopeChain chain(FrictionCone(spec.mu), lattice, 0);
    chain.set(pile);
    const RandomKey key(29, static_cast<std::uint64_t>(number));
    std::vector<double> sums;
    for (std::uint32_t sweep = 1; sweep <= burn_in + sweeps; ++sweep) {
      if (sweep == flat_sweeps + 1) chain.set_lambda(spec.lambda);
      chain.sweep([&](int layer, int bead) { return key.chain_move(layer, bead, sweep); });
      if (sweep <= burn_in) continue;
      const std::vector<double> numbers = slow_numbers(chain.pile());
      sums.resize(numbers.size()), singles.resize(numbers.size()), means.resize(numbers.size());
      for (std::size_t j = 0; j < numbers.size(); ++j) {
        sums[j] += numbers[j];
        singles[j].add(numbers[j]);
      }
    }
    for (std::size_t j = 0; j < sums.size(); ++j) means[j].add(sums[j] / static_cast<double>(sweeps));
  }
  double longest = 0;
  for (std::size_t j = 0; j < means.size(); ++j) {
    if (!(singles[j].variance() > 1e-20)) continue;
    longest = std::max(longest, static_cast<double>(sweeps) * means[j].variance() / singles[j].variance());
  }
  return {longest, longest * std::sqrt(2.0 / (chains - 1))};
}

// A pilot reports the longest of several noisy times, each known to about a third, so that its mean lies above the time
// of the slowest number; never as far as by half, nor below. A time taken for half or twice of what it is would show.
TEST_CASE("the time that pilots measure is the one by which means over independent chains scatter", "[unsanitized]") {
  const Lattice lattice({.columns = 4, .layers = 4});
  const std::vector<double> load(4, 1.0);
  for (const double lambda : {0.0, 1.0}) {
    if (test::sanitized && lambda == 1) continue;  // seven times as slow a chain
    SamplerSpec spec = chain_spec(Law::polytope, 0.3, lambda);
    RunningMean pilots;
    constexpr int seeds = 100;
    for (int seed = 1; seed <= seeds; ++seed) {
      spec.seed = static_cast<std::uint64_t>(seed);
      pilots.add(plan_chain(spec, lattice, load).autocorrelation_time);
    }
    const test::Estimated measured = pilots.estimate();
    const auto whole = [&](double times) { return static_cast<std::uint64_t>(times * measured.value); };
    const test::Estimated expected = time_from_independent_chains(spec, lattice, 400, whole(burn_in_times), whole(20));
    CAPTURE(lambda, measured.value, measured.error, std::sqrt(pilots.variance()), expected.value, expected.error);
    constexpr double highest = 1.5;
    const double bound = test::sigma_bound(4);
    CHECK(measured.value - expected.value > -bound * std::hypot(measured.error, expected.error));
    CHECK(measured.value - highest * expected.value < bound * std::hypot(measured.error, highest * expected.error));
    // Half the time would be told from the whole.
    CHECK(bound * std::hypot(measured.error, expected.error) < expected.value / 2);
  }
}

// The pilot keeps every second sweep, then every fourth and so on; a slow number looks the same in all of them. The
// pilot is run once more and every sweep of it is kept.
TEST_CASE("a pilot that keeps ever fewer of its sweeps measures the time that all of them have") {
  struct Pilot {
    int columns, layers;
    double mu, lambda;
  };
  std::uint64_t longest = 0;
  for (const Pilot& pilot : {Pilot{4, 4, 0.3, 0}, {4, 4, 0.3, 1}, {6, 6, 0.3, 0}, {6, 6, 0.3, 1}}) {
    if (test::sanitized && pilot.columns > 4 && pilot.lambda == 1) continue;
    const Lattice lattice({.columns = pilot.columns, .layers = pilot.layers});
    const std::vector<double> load(static_cast<std::size_t>(pilot.columns), 1.0);
    const SamplerSpec spec = chain_spec(Law::polytope, pilot.mu, pilot.lambda);
    const ChainPlan plan = plan_chain(spec, lattice, load);
    longest = std::max(longest, plan.pilot_sweeps);
    Pile pile(lattice);
    REQUIRE_FALSE(make_sampler(chain_spec(Law::granusolve, pilot.mu), lattice)->draw(0, load, pile));
    PolytopeChain chain(FrictionCone(pilot.mu), lattice, 0);
    chain.set(pile);
    const RandomKey key(spec.seed, 0);
    std::vector<std::vector<double>> series;
    for (std::uint32_t sweep = 1; sweep <= plan.pilot_sweeps; ++sweep) {
      if (sweep == flat_sweeps + 1) chain.set_lambda(pilot.lambda);
      chain.sweep([&](int layer, int bead) { return key.pilot_move(layer, bead, sweep); });
      if (4 * sweep <= plan.pilot_sweeps) continue;  // burn-in
      const std::vector<double> numbers = slow_numbers(chain.pile());
      series.resize(numbers.size());
      for (std::size_t j = 0; j < numbers.size(); ++j) series[j].push_back(numbers[j]);
    }
    double expected = 1;
    for (const auto& one : series) expected = std::max(expected, autocorrelation_time(one, 1));
    CAPTURE(pilot.columns, pilot.layers, pilot.mu, pilot.lambda, plan.pilot_sweeps, plan.autocorrelation_time);
    CHECK(plan.autocorrelation_time == Approx(expected).epsilon(0.1));
  }
  CHECK(longest >= (test::sanitized ? 2 : 8) * 8192);  // kept are 8192 sweeps at most
}

// The law's own description (polytope.h), written down once more.
TEST_CASE("samples are the piles of one chain for each eight, after the burn-in and every thinning sweeps") {
  const Lattice lattice({.columns = 5, .layers = 5});
  const std::vector<double> load = {1, 2, 1, 1, 0.5};
  for (const double lambda : {0.0, 1.0}) {
    SamplerSpec spec = chain_spec(Law::polytope, 0.4, lambda);
    spec.burn_in = 21;
    spec.thinning = 6;
    const auto sampler = make_sampler(spec, lattice),
               granusolve = make_sampler(chain_spec(Law::granusolve, 0.4), lattice);
    for (const std::uint64_t first : {0U, 8U, 64U}) {
      Pile pile(lattice), expected(lattice);
      REQUIRE_FALSE(granusolve->draw(first, load, expected));
      PolytopeChain chain(FrictionCone(0.4), lattice, 0);
      chain.set(expected);
      const RandomKey key(spec.seed, first);
      std::uint32_t sweep = 0;
      const auto run = [&](std::uint64_t sweeps) {
        for (const std::uint64_t end = sweep + sweeps; sweep < end;) {
          ++sweep;
          chain.sweep([&](int layer, int bead) { return key.chain_move(layer, bead, sweep); });
        }
      };
      run(flat_sweeps);
      chain.set_lambda(lambda);
      run(spec.burn_in);
      for (std::uint64_t sample = first; sample < first + 8; ++sample) {
        if (sample > first) run(spec.thinning);
        chain.store(expected);
        REQUIRE_FALSE(sampler->draw(sample, load, pile));
        CAPTURE(lambda, sample);
        CHECK(pile.H_R == expected.H_R);
        CHECK(pile.V_L == expected.V_L);
      }
    }
  }
}

TEST_CASE("burn-in and thinning follow what the pilot measures; a pile too large is refused at once") {
  const Lattice lattice({.columns = 6, .layers = 6});
  const std::vector<double> load(6, 1.0);
  SamplerSpec spec = chain_spec(Law::polytope, 0.3);
  const ChainPlan plan = plan_chain(spec, lattice, load);
  CHECK(static_cast<double>(plan.pilot_sweeps) > 100 * plan.autocorrelation_time);
  CHECK(static_cast<double>(plan.burn_in) >= burn_in_times * plan.autocorrelation_time);
  CHECK(static_cast<double>(plan.thinning) >= thinning_times * plan.autocorrelation_time);
  spec.thinning = 17;
  CHECK(with_measured_chain(spec, lattice, load).thinning == 17);
  CHECK(with_measured_chain(spec, lattice, load).burn_in > 17);
  CHECK_THROWS_AS(plan_chain(spec, Lattice({.columns = 100, .layers = 41}), std::vector<double>(100, 1.0)), InputError);
}

// Source: the moves as polytope.h describes them, made once more on whole piles: every cone of every contact
// bounds a move, and the density is the product over all beads.

class PlainChain {
 public:
  PlainChain(const Pile& pile, double lambda) : cone_(pile.mu), pile_(pile), lambda_(lambda) {}

  void null_move(int layer, int bead, UniformPair u) {
    const Lattice& lattice = pile_.lattice;
    Pile change(lattice);
    const auto add = [&](std::vector<double>& forces, int down, int column, double by) {
      if (layer + down < lattice.layers()) forces[lattice.index(layer + down, column)] += by;
    };
    const double root = std::sqrt(3.0);
    const int l = lattice.lower_left(layer, bead), r = lattice.lower_right(layer, bead);
    const int ll = lattice.lower_left(layer + 1, l), lr = lattice.lower_right(layer + 1, l),
              rr = lattice.lower_right(layer + 1, r);
    const int llr = lattice.lower_right(layer + 2, ll), lrr = lattice.lower_right(layer + 2, lr);
    for (const auto& [down, column, by] : {std::tuple{0, bead, 1.0}, {1, l, -1.0}, {2, lr, -1.0}, {3, llr, 1.0}}) {
      add(change.H_R, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{0, bead, -1.0}, {1, r, 1.0}, {2, lr, 1.0}, {3, lrr, -1.0}}) {
      add(change.H_L, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{1, r, root}, {1, l, -root}, {2, lr, -root}, {2, ll, root}}) {
      add(change.V_R, down, column, by);
    }
    for (const auto& [down, column, by] : {std::tuple{1, r, -root}, {1, l, root}, {2, rr, root}, {2, lr, -root}}) {
      add(change.V_L, down, column, by);
    }
    move(change, u, lambda_);
  }

  void ring_move(int layer, double u) {
    Pile change(pile_.lattice);
    for (int i = 0; i < pile_.lattice.columns(); ++i) {
      change.H_R[pile_.lattice.index(layer, i)] = 1;
      change.H_L[pile_.lattice.index(layer, i)] = -1;
    }
    move(change, {u, 0}, 0);
  }

  const Pile& pile() const { return pile_; }
  std::uint64_t accepted() const { return accepted_; }

 private:
  void move(const Pile& change, UniformPair u, double lambda) {
    double low = -std::numeric_limits<double>::infinity(), high = -low;
    // a + b t >= 0
    const auto bound = [&](double a, double b) {
      if (b > 1e-12) low = std::max(low, -a / b);
      if (b < -1e-12) high = std::min(high, -a / b);
    };
    const auto keep_in_cone = [&](double V, double h, double dV, double dh) {
      bound(h - cone_.t_minus() * V, dh - cone_.t_minus() * dV);
      bound(cone_.t_plus() * V - h, cone_.t_plus() * dV - dh);
    };
    for (std::size_t k = 0; k < pile_.V_R.size(); ++k) {
      keep_in_cone(pile_.V_R[k], pile_.H_R[k], change.V_R[k], change.H_R[k]);
      keep_in_cone(pile_.V_L[k], -pile_.H_L[k], change.V_L[k], -change.H_L[k]);
    }
    if (!(low < high)) return;
    const double t = low + u.first * (high - low);
    Pile moved = pile_;
    for (auto forces : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
      for (std::size_t k = 0; k < pile_.V_R.size(); ++k) (moved.*forces)[k] += t * (change.*forces)[k];
    }
    double ratio = 1;
    for (std::size_t k = 0; k < pile_.V_R.size(); ++k) ratio *= length(pile_, k) / length(moved, k);
    if (u.second >= std::pow(ratio, lambda)) return;
    ++accepted_;
    pile_ = moved;
  }

  double length(const Pile& pile, std::size_t k) const {
    const Interval interval = split_interval(cone_, {pile.V_R[k], pile.V_L[k]}, pile.H_R[k] + pile.H_L[k]);
    return interval.high - interval.low;
  }

  FrictionCone cone_;
  Pile pile_;
  double lambda_;
  std::uint64_t accepted_ = 0;
};

double largest_difference(const Pile& a, const Pile& b) {
  double largest = 0;
  for (auto forces : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (std::size_t k = 0; k < a.V_R.size(); ++k) {
      largest = std::max(largest, std::abs((a.*forces)[k] - (b.*forces)[k]));
    }
  }
  return largest;
}

TEST_CASE("every move of the chain is the one described, of length, acceptance and pile") {
  const std::vector<double> load = {1, 1.4, 0.7, 1, 1.2};
  for (const LatticeSpec size : {LatticeSpec{5, 6}, {5, 3}, {5, 1}}) {
    for (const double mu : {0.1, 0.3, 0.8, 1.4}) {
      for (const double lambda : {0.0, 0.5, 1.0}) {
        const Lattice lattice(size);
        SamplerSpec spec;
        spec.mu = mu;
        spec.seed = 12;
        Pile start(lattice);
        REQUIRE_FALSE(make_sampler(spec, lattice)->draw(0, load, start));
        PolytopeChain chain(FrictionCone(mu), lattice, lambda);
        chain.set(start);
        PlainChain plain(start, lambda);
        const RandomKey key(12, 3);
        for (std::uint32_t sweep = 1; sweep <= 30; ++sweep) {
          const auto uniforms = [&](int layer, int bead) { return key.chain_move(layer, bead, sweep); };
          chain.sweep(uniforms);
          for (int n = 0; n < size.layers; ++n) {
            for (int i = 0; i < size.columns; ++i) plain.null_move(n, i, uniforms(n, i));
            plain.ring_move(n, uniforms(n, size.columns).first);
          }
          CAPTURE(size.layers, mu, lambda, sweep);
          REQUIRE(chain.accepted_moves() == plain.accepted());
          REQUIRE(largest_difference(chain.pile(), plain.pile()) < 1e-10);
        }
        // The density decides where it is not flat, and does not where it is.
        const bool all_accepted = chain.accepted_moves() == chain.moves();
        CHECK(all_accepted == (lambda == 0 || size.layers == 1));
      }
    }
  }
}

TEST_CASE("a chain is measured once in a program, and another one anew", "[unsanitized]") {
  const Lattice lattice({.columns = 6, .layers = 7});
  std::vector<double> load(6, 1.0);
  SamplerSpec spec;
  spec.law = Law::polytope;
  spec.mu = 0.3;
  spec.seed = 4711;  // asked for by no other test
  const auto seconds = [&] {
    const double start = processor_seconds();
    const SamplerSpec measured = with_measured_chain(spec, lattice, load);
    const double took = processor_seconds() - start;
    const ChainPlan plan = plan_chain(spec, lattice, load);
    CHECK(measured.burn_in == plan.burn_in);
    CHECK(measured.thinning == plan.thinning);
    return took;
  };
  const double first = seconds(), again = seconds();
  CHECK(again < 0.1 * first);
  // Whatever it depends on makes it another one.
  spec.seed += std::uint64_t{1} << 40;
  CHECK(seconds() > again);
  spec.lambda = 0.5;
  CHECK(seconds() > again);
  load[2] = 1.5;
  CHECK(seconds() > again);
}

TEST_CASE("that a chain cannot be measured is said again in the same words") {
  const Lattice lattice({.columns = 4, .layers = 12});
  // Loads so uneven that the pile a chain starts from runs out of its effort.
  const std::vector<double> load = {1, 1, 1e300, 1};
  SamplerSpec spec;
  spec.law = Law::polytope;
  spec.mu = 0.1;
  std::vector<std::string> words;
  for (int k = 0; k < 2; ++k) {
    try {
      (void)with_measured_chain(spec, lattice, load);
    } catch (const InputError& refused) {
      words.emplace_back(refused.what());
    }
  }
  REQUIRE(words.size() == 2);
  CHECK(words[0] == words[1]);
  CHECK_THAT(words[0], Catch::Contains("none could be completed under this load"));
}

}  // namespace

}  // namespace granuscope
