// The law of granusolve, its state, its repairs and its backtracks.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/naive_granusolve.h"
#include "kit/same_bytes.h"
#include "kit/sampling_statistics.h"
#include "model/audit.h"
#include "model/lattice.h"
#include "sampling/granusolve.h"
#include "sampling/granusolve_state.h"
#include "sampling/layer_kernels.h"
#include "sampling/sampler.h"
#include "sampling/simple_laws.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::RunningMean;
using test::same_bytes;

// Source of the expected numbers: naive_granusolve.h, the same law written a second time from its description, with
// blind redrawing, Bellman-Ford and bisection in the place of closed forms and filters.

struct LawCase {
  std::string name;
  double mu;
  int layers;
  std::vector<double> load;
  int times = 1;  ///< more piles where the rare rules are, and few others to slow the reference down
};

const std::vector<double> uneven6 = {0.2, 1.7, 0.4, 1.1, 0.3, 2.3}, uneven5 = {1.9, 0.3, 0.8, 0.2, 1.4};
const std::vector<double> point8 = {1, 1, 1, 1, 2, 1, 1, 1}, point5 = {1, 1, 2, 1, 1}, flat4 = {1, 1, 1, 1};

/// Two to five layers of four to eight columns; between them every rule is entered many times.
const std::vector<LawCase> law_cases = {
    {"two layers, pairs alone", 0.3, 2, point8},
    {"two layers, steep", 1.2, 2, uneven6},
    {"small friction, backtracks", 0.1, 5, uneven6, 8},
    {"backtracks on five columns", 0.3, 4, uneven5, 10},
    {"a point load", 0.3, 5, point8, 6},
    {"cone past the vertical", 0.7, 4, point8},
    {"arcs", 1.3, 4, point8},
    {"arcs that meet outside", 1.3, 3, uneven5},
    {"rings of four", 1.0, 4, flat4},
    {"rings of four, backtracks", 0.2, 5, {0.4, 1.6, 0.9, 1.1}, 8},
    {"backtracks in every pile", 0.3, 5, {0.1, 0.1, 0.1, 5, 0.1, 0.1}, 1},
    {"backtracks in every pile, eight columns", 0.45, 4, {0.1, 0.1, 0.1, 0.1, 3, 0.1, 0.1, 0.1}, 1},
    {"rings in every third pile", 1.5, 2, {1.6, 0.4, 0.2, 1.8}, 5},
    {"arcs in every other pile", 1.4, 3, {2, 0.1, 0.1, 2, 0.1, 0.1, 2, 0.1}, 4},
    {"a steep cone", 1.4, 3, uneven6},
};

/// Means over independent piles: first and second moments of every H_R and w, products of neighbours in a layer and of
/// a bead and its lower-right neighbour, and the thrust of every layer.
class Moments {
 public:
  explicit Moments(const Lattice& lattice) : lattice_(lattice) {}

  void add(const Pile& pile) {
    std::size_t at = 0;
    const auto put = [&](double value) {
      if (at == means_.size()) means_.emplace_back();
      means_[at++].add(value);
    };
    const auto weight = [&](std::size_t k) { return pile.V_R[k] + pile.V_L[k]; };
    for (int n = 0; n < lattice_.layers(); ++n) {
      double thrust = 0;
      for (int i = 0; i < lattice_.columns(); ++i) {
        const std::size_t here = lattice_.index(n, i), beside = lattice_.index(n, lattice_.next(i));
        const double H = pile.H_R[here], w = weight(here);
        thrust += H - pile.H_L[here];
        put(H);
        put(H * H);
        put(H * pile.H_R[beside]);
        if (n > 1) {  // above, w follows from the load
          put(w);
          put(w * w);
          put(w * weight(beside));
          put(H * w);
        }
        if (n + 1 < lattice_.layers()) put(H * pile.H_R[lattice_.index(n + 1, lattice_.lower_right(n, i))]);
      }
      put(thrust);
      put(thrust * thrust);
    }
  }
  const std::vector<RunningMean>& means() const { return means_; }

 private:
  Lattice lattice_;
  std::vector<RunningMean> means_;
};

struct LawComparison {
  double worst_sigmas = 0;
  double backtrack_sigmas = 0;  ///< of the number of backtracks per pile
  double number_sigmas = 0;     ///< of the numbers per pile that are drawn after the first of each bead
  /// Largest combined standard error, in units of the spread of the quantity itself.
  double worst_resolution = 0;
  std::size_t comparisons = 0;
  std::uint64_t given_up = 0;
  SamplerCounts counts;
};

LawComparison compare_laws(const LawCase& law_case, int piles_per_time, std::uint64_t seed) {
  const int piles = piles_per_time * law_case.times;
  const Lattice lattice({.columns = static_cast<int>(law_case.load.size()), .layers = law_case.layers});
  SamplerSpec spec;
  spec.mu = law_case.mu;
  spec.seed = seed;
  const auto sampler = make_sampler(spec, lattice);
  Pile pile(lattice);
  Moments program(lattice), naive(lattice);
  // The forces of such small piles hardly tell how high backtracks go; how many beads they solve again does.
  RunningMean program_backtracks, naive_backtracks, program_numbers, naive_numbers;
  LawComparison result;
  SamplerCounts before;
  for (int k = 0; k < 2 * piles; ++k) {
    // One sample of every eight: the others share the order of their layers and are not independent.
    if (sampler->draw(8 * static_cast<std::uint64_t>(k), law_case.load, pile)) throw std::runtime_error("stuck");
    program.add(pile);
    const SamplerCounts after = sampler->counts();
    program_backtracks.add(static_cast<double>(after.backtracks - before.backtracks));
    program_numbers.add(static_cast<double>(after.uniforms - before.uniforms) - static_cast<double>(lattice.beads()));
    before = after;
    if (k % 16 == 0) {
      const AuditResult result_of_audit = audit(pile);
      if (!(result_of_audit.max_balance_residual <= 1e-12 && result_of_audit.max_cone_violation <= 1e-12)) {
        throw std::runtime_error("audit failed");
      }
      assert_identities(pile);
    }
  }
  test::NaiveGranusolve reference(lattice, law_case.mu, seed + 1);
  for (int k = 0; k < piles; ++k) {
    if (reference.draw(law_case.load, pile)) {
      naive.add(pile);
      naive_backtracks.add(reference.backtracks());
      naive_numbers.add(reference.later_numbers());
    } else {
      ++result.given_up;
    }
  }
  result.comparisons = program.means().size() + 2;
  result.backtrack_sigmas = std::abs(test::sigmas(program_backtracks.estimate(), naive_backtracks.estimate()));
  result.number_sigmas = std::abs(test::sigmas(program_numbers.estimate(), naive_numbers.estimate()));
  for (std::size_t k = 0; k < program.means().size(); ++k) {
    const auto a = program.means()[k].estimate(), b = naive.means()[k].estimate();
    result.worst_sigmas = std::max(result.worst_sigmas, std::abs(test::sigmas(a, b)));
    result.worst_resolution =
        std::max(result.worst_resolution, std::hypot(a.error, b.error) / std::sqrt(naive.means()[k].variance()));
  }
  result.counts = sampler->counts();
  return result;
}

void compare_all(int piles, double resolution) {
  std::uint64_t pairs = 0, arcs = 0, rings = 0, backtracks = 0;
  constexpr std::uint64_t seed = 271828;
  for (const LawCase& law_case : law_cases) {
    const LawComparison result = compare_laws(law_case, piles, seed);
    CAPTURE(law_case.name, law_case.mu, seed, piles, result.comparisons, result.given_up, result.counts.pairs,
            result.counts.arcs, result.counts.rings, result.counts.backtracks);
    CHECK(result.worst_sigmas < test::sigma_bound(law_cases.size() * result.comparisons));
    CHECK(result.backtrack_sigmas < test::sigma_bound(law_cases.size() * result.comparisons));
    CHECK(result.number_sigmas < test::sigma_bound(law_cases.size() * result.comparisons));
    // Too few piles to see a shift of this share of a quantity's own spread would prove nothing.
    CHECK(result.worst_resolution < resolution);
    // A pile given up by blind redrawing is lost to the comparison: one in a thousand shifts no mean by a sigma here.
    CHECK(static_cast<double>(result.given_up) < 1e-3 * piles);
    pairs += result.counts.pairs, arcs += result.counts.arcs;
    rings += result.counts.rings, backtracks += result.counts.backtracks;
  }
  // Every rule was entered often enough to matter.
  constexpr std::uint64_t enough = test::sanitized ? 250 : 1000;
  CHECK(pairs >= enough);
  CHECK(arcs >= enough);
  CHECK(rings >= enough);
  CHECK(backtracks >= enough);
}

TEST_CASE("the sampled law is the described law: moments of small piles", "[unsanitized]") {
  compare_all(test::sanitized ? 1500 : 6000, test::sanitized ? 0.04 : 0.02);
}

TEST_CASE("the sampled law is the described law, to a fraction of a percent", "[long]") { compare_all(110'000, 0.004); }

// Source: the invariants in granusolve_state.h, broken by hand one at a time.

SamplerSpec with_friction(double mu) {
  SamplerSpec spec;
  spec.mu = mu;
  return spec;
}

constexpr int state_columns = 40, state_layers = 24;

/// A pile solved down to a layer, and what it is solved in.
struct Solved {
  explicit Solved(int down_to, double mu = 0.3, std::uint64_t sample = 0)
      : solver({.mu = mu, .seed = 3, .model = {}}, lattice) {
    solver.use(memory.arrays(pile));
    solver.begin_pile(sample, load);
    for (int layer = 0; layer <= down_to; ++layer) REQUIRE(solver.solve_layer(layer) == SolveResult::solved);
  }
  const GranusolveState& state() const { return solver.state(); }
  const GranusolveArrays& arrays() const { return state().arrays(); }

  Lattice lattice{{state_columns, state_layers}};
  std::vector<double> load = std::vector<double>(state_columns, 1.0);
  Pile pile{lattice};
  GranusolveMemory memory;
  GranusolveSolver solver;
};

/// The same a layer further, which has been drawn in bulk only.
struct Begun : Solved {
  explicit Begun(int layer)
      : Solved(layer - 1), changed_bits(1), begun(with_friction(0.3), lattice), draws(3, begun, work) {
    GranusolveArrays with_changed = arrays();
    with_changed.changed = changed_bits.data();
    begun.use(with_changed);
    begun.begin_pile(draws.key(), LayerOrder::random, load, draws.begin_pile(0, nullptr));
    draws.begin_layer(layer);
    begun.next_failing();
  }
  std::vector<std::uint64_t> changed_bits;
  GranusolveWork work;
  GranusolveState begun;
  GranusolveDraws draws;
};

void expect_broken(const GranusolveState& state) { CHECK_THROWS_AS(state.check(), std::logic_error); }

TEST_CASE("a pile holds its invariants after each layer, and a bead broken in the last two is seen") {
  for (const double mu : {0.05, 0.3, 1.3}) {
    Solved pile(0, mu);
    for (int layer = 1; layer < state_layers; ++layer) {
      REQUIRE(pile.solver.solve_layer(layer) == SolveResult::solved);
      CHECK_NOTHROW(pile.state().check());
    }
    for (const int layer : {state_layers - 2, state_layers - 1}) {
      const std::size_t bead = pile.state().at(layer, 17);
      CAPTURE(mu, layer);
      const auto broken_by = [&](auto& entry, auto value) {
        const auto kept = entry;
        entry = value;
        expect_broken(pile.state());
        entry = kept;
        CHECK_NOTHROW(pile.state().check());
      };
      const GranusolveArrays& arrays = pile.arrays();
      const double most = std::numeric_limits<double>::infinity();
      broken_by(arrays.V_R[bead], std::nextafter(arrays.V_R[bead], most));
      broken_by(arrays.V_L[bead], std::nextafter(arrays.V_L[bead], most));
      broken_by(arrays.H[bead], arrays.H[bead] + 1e-9);
      broken_by(arrays.H_L[bead], arrays.H_L[bead] + 1e-9);
      broken_by(arrays.H_R[bead], pile.state().interval_of(layer, 17).high + 1e-9);
      broken_by(arrays.H_R[bead], std::numeric_limits<double>::quiet_NaN());
      broken_by(arrays.unsolved[bead], below_backtrack);
      broken_by(arrays.rule[bead], static_cast<std::uint8_t>(GranusolveRule::backtrack));
    }
  }
}

TEST_CASE("a split that was changed without renewing the beads below is seen") {
  Solved pile(10);
  const Interval interval = pile.state().interval_of(9, 5);
  const std::size_t parent = pile.state().at(9, 5);
  const double middle = (interval.low + interval.high) / 2;
  REQUIRE(std::abs(pile.arrays().H_R[parent] - middle) > 1e-9);
  pile.arrays().H_R[parent] = middle;
  pile.arrays().H_L[parent] = pile.arrays().H[parent] - middle;
  expect_broken(pile.state());
  const int child = pile.lattice.lower_left(9, 5);
  CHECK_THROWS_AS(pile.state().check_run(10, {child, 1}), std::logic_error);
  CHECK_NOTHROW(pile.state().check_run(10, {(child + 5) % state_columns, 2}));
}

TEST_CASE("in the midst of a layer, a bead that does not fail is as good as solved, and what fails is noted") {
  Begun pile(12);
  const GranusolveState& state = pile.begun;
  REQUIRE(state.cursor() < state_columns);  // some bead fails
  CHECK_NOTHROW(state.check());
  const int failing = state.cursor_bead();
  state.arrays().failing[0] &= ~(std::uint64_t{1} << failing);
  expect_broken(state);
  state.arrays().failing[0] |= std::uint64_t{1} << failing;
  CHECK_NOTHROW(state.check());

  // One whose turn has not come: nobody has done anything for it, and it changes only together with failing.
  const RandomKey::Order order = state.order(12);
  const int bead = (order.first_bead - order.direction + state_columns) % state_columns;  // the last one
  REQUIRE(state.awaits_turn(12, bead));
  ++state.arrays().attempts[state.at(12, bead)];
  expect_broken(state);
  --state.arrays().attempts[state.at(12, bead)];
  ++state.arrays().backtracks[state.at(12, bead)];
  expect_broken(state);
  --state.arrays().backtracks[state.at(12, bead)];
  if ((state.arrays().failing[0] >> bead & 1) == 0) {
    pile.changed_bits[0] |= std::uint64_t{1} << bead;
    expect_broken(state);
  }
  pile.begun.forget_draw(bead);
  CHECK_NOTHROW(state.check());
}

TEST_CASE("what a backtrack has unsolved is pending until it is solved") {
  Solved solved(10);
  GranusolveState state = solved.state();
  CHECK_NOTHROW(state.check());
  state.unsolve(8, 3, 3);
  CHECK(state.topmost_pending() == 8);
  CHECK(state.pending(9).count == 4);
  CHECK(state.pending(10).count == 5);
  expect_broken(state);
  CHECK_THROWS_AS(state.check_run(9, state.pending(9)), std::logic_error);
  state.watch_pending();
  expect_broken(state);
  for (const int layer : {8, 9, 10}) state.clear_pending(layer);
  expect_broken(state);  // unsolved, and forgotten
}

TEST_CASE("a cursor at another bead than its own is seen") {
  Begun pile(12);
  GranusolveState& state = pile.begun;
  const int cursor = state.cursor(), bead = state.cursor_bead();
  REQUIRE(cursor < state_columns);
  state.move_cursor(12, cursor, bead == 0 ? 1 : bead - 1);
  expect_broken(state);
  state.move_cursor(12, state_columns + 1, -1);
  expect_broken(state);
  state.move_cursor(12, cursor, bead);
  CHECK_NOTHROW(state.check());
}

TEST_CASE("a solver sees a broken pile by itself, unless assertions are off") {
  Solved pile(10);
  pile.arrays().rule[pile.state().at(10, 7)] = static_cast<std::uint8_t>(GranusolveRule::backtrack);
  if (checks_granusolve_state) {
    CHECK_THROWS_AS(pile.solver.solve_layer(11), std::logic_error);
  } else {
    CHECK(pile.solver.solve_layer(11) == SolveResult::solved);
  }
}

// Source: backtracks that draw their numbers eight at a time are those that draw one after the other; equality is
// exact, of failures and counts too.

struct DrawnPile {
  std::vector<Pile> piles;
  std::vector<int> failed_in;  ///< layer, or -1
  SamplerCounts counts;
};

DrawnPile drawn_alone(const SamplerSpec& spec, const Lattice& lattice, const std::vector<double>& load) {
  DrawnPile drawn;
  const auto sampler = make_sampler(spec, lattice);
  for (std::uint64_t sample = 0; sample < 4; ++sample) {
    drawn.piles.emplace_back(lattice);
    const auto failure = sampler->draw(sample, load, drawn.piles.back());
    drawn.failed_in.push_back(failure ? failure->layer : -1);
  }
  drawn.counts = sampler->counts();
  return drawn;
}

/// Draws piles with single numbers and with eight at a time; gives how often they backtracked.
std::uint64_t check_backtracks(const SamplerSpec& spec, LatticeSpec lattice_spec, const std::vector<double>& load) {
  CAPTURE(spec.mu, spec.seed, spec.effort, name_of(spec.rules), lattice_spec.columns, lattice_spec.layers);
  const Lattice lattice(lattice_spec);
  const auto one_by_one = [&] {
    const PlainKernels plain;
    return drawn_alone(spec, lattice, load);
  };
  const DrawnPile expected = one_by_one(), drawn = drawn_alone(spec, lattice, load);
  CHECK(drawn.failed_in == expected.failed_in);
  for (std::size_t k = 0; k < drawn.piles.size(); ++k) {
    if (drawn.failed_in[k] >= 0) continue;
    CHECK(same_bytes(drawn.piles[k].V_R, expected.piles[k].V_R));
    CHECK(same_bytes(drawn.piles[k].V_L, expected.piles[k].V_L));
    CHECK(same_bytes(drawn.piles[k].H_R, expected.piles[k].H_R));
    CHECK(same_bytes(drawn.piles[k].H_L, expected.piles[k].H_L));
  }
  const SamplerCounts &a = drawn.counts, &b = expected.counts;
  CHECK(a.uniforms == b.uniforms);
  CHECK(a.backtracks == b.backtracks);
  CHECK(a.pairs == b.pairs);
  CHECK(a.arcs == b.arcs);
  CHECK(a.rings == b.rings);
  CHECK(a.repaired_by_pair == b.repaired_by_pair);
  CHECK(a.backtracked == b.backtracked);
  CHECK(a.rounded == b.rounded);
  return b.backtracks;
}

/// Piles of all kinds; `rounding`: friction of a few ulps under loads of several orders of magnitude, so that nearly
/// all that holds a bead is rounding.
std::uint64_t check_random_backtracks(std::mt19937_64& generator, int trial, bool rounding) {
  std::uniform_real_distribution<double> uniform;
  SamplerSpec spec;
  spec.mu = rounding ? std::pow(10.0, -16 + 3.5 * uniform(generator)) : 0.02 + 0.3 * uniform(generator);
  spec.seed = generator();
  spec.rules = trial % 5 == 0 ? RepairRules::no_arcs : trial % 5 == 1 ? RepairRules::no_pair : RepairRules::all;
  // In one trial of three some run out of it.
  spec.effort = trial % 3 == 0 ? 1 + 0.3 * uniform(generator) * uniform(generator) : 20;
  // Narrow ones: backtracks at the seam, and at the ends of a layer's order.
  const int columns = 4 + static_cast<int>(26 * uniform(generator));
  const int layers = 4 + static_cast<int>(46 * uniform(generator));
  std::vector<double> load(static_cast<std::size_t>(columns), 1.0);
  if (rounding || trial % 2 == 0) {
    const double orders = rounding ? 3 + 2 * uniform(generator) : 3;
    for (double& force : load) force = std::pow(10.0, orders * uniform(generator));
  }
  return check_backtracks(spec, {columns, layers}, load);
}

TEST_CASE("backtracks that draw eight numbers at a time are those that draw one by one, wherever they set out from") {
  for_each_instruction_set([] {
    std::mt19937_64 generator(23);
    std::uint64_t backtracks = 0;
    for (int trial = 0; trial < 600 / (test::sanitized ? 4 : 1); ++trial)
      backtracks += check_random_backtracks(generator, trial, trial % 3 == 1);
    CHECK(backtracks > 10'000 / (test::sanitized ? 4 : 1));
  });
}

TEST_CASE("backtracks of a wide pile that draw eight numbers at a time are those that draw one by one") {
  SamplerSpec spec;
  std::uint64_t backtracks = 0;
  for (const double mu : {0.05, 0.1, 0.2}) {
    spec.mu = mu;
    backtracks += check_backtracks(spec, {200, 150}, std::vector<double>(200, 1.0));
  }
  CHECK(backtracks > 300);
}

// Sources: each rule's counter is 0 where the rule is off; every pile is held to the audit. Without friction's help the
// frictionless pile is admissible wherever t- <= 0 <= t+ around the direction of a contact.

constexpr double residual_of_rounding = 1e-12;

SamplerSpec spec_with(RepairRules rules) {
  SamplerSpec spec;
  spec.mu = 0.3;
  spec.rules = rules;
  return spec;
}

TEST_CASE("without some of its rules granusolve repairs by the others, and its piles stay solutions") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  for (const RepairRules rules :
       {RepairRules::all, RepairRules::no_pair, RepairRules::no_arcs, RepairRules::backtrack_only}) {
    CAPTURE(name_of(rules));
    SamplerSpec spec = spec_with(rules);
    if (rules == RepairRules::backtrack_only) spec.mu = 0.05;  // at 0.3 it completes nothing: see below
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    for (std::uint64_t sample = 0; sample < 40; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, load, pile));
      const AuditResult result = audit(pile);
      CHECK(result.max_balance_residual < residual_of_rounding);
      CHECK(result.max_cone_violation < residual_of_rounding);
    }
    const bool pair = rules == RepairRules::all || rules == RepairRules::no_arcs;
    const bool arcs = rules == RepairRules::no_pair;
    CHECK((sampler->counts().repaired_by_pair > 0) == pair);
    if (arcs) CHECK(sampler->counts().repaired_by_arc > 0);
    if (rules == RepairRules::no_arcs || rules == RepairRules::backtrack_only) {
      CHECK(sampler->counts().repaired_by_arc + sampler->counts().repaired_by_ring == 0);
    }
    CHECK(repair_rules_named(name_of(rules)) == rules);
  }
}

TEST_CASE("piles side by side are those of one by one under any repair rules") {
  const Lattice lattice({12, 20});
  const std::vector<double> load(12, 1.0);
  for (const RepairRules rules : {RepairRules::no_pair, RepairRules::no_arcs}) {
    const auto together = make_sampler(spec_with(rules), lattice), alone = make_sampler(spec_with(rules), lattice);
    std::vector<std::uint64_t> samples;
    for (std::uint64_t k = 0; k < 8; ++k) samples.push_back(k);
    const std::vector<std::span<const double>> loads(8, load);
    std::vector<std::optional<SamplingFailure>> failures(8);
    together->draw_groups(samples, loads, failures);
    Pile pile(lattice);
    for (const std::uint64_t sample : samples) CHECK_FALSE(alone->draw(sample, load, pile));
    CHECK(together->counts().uniforms == alone->counts().uniforms);
  }
}

TEST_CASE("by backtracks alone nothing is completed at mu = 0.3: the effort runs out, by name") {
  const Lattice lattice({16, 40});
  const std::vector<double> load(16, 1.0);
  const auto sampler = make_sampler(spec_with(RepairRules::backtrack_only), lattice);
  Pile pile(lattice);
  CHECK(sampler->draw(0, load, pile).has_value());
}

TEST_CASE("repair rules are refused by name where they mean nothing") {
  CHECK_THROWS_AS(repair_rules_named("none"), InputError);
  SamplerSpec spec = spec_with(RepairRules::no_pair);
  spec.law = Law::rejection;
  CHECK_THROWS_AS(validate(spec), InputError);
}

TEST_CASE("at t- = 0 a half unloaded top has a solution: the frictionless pile") {
  const Lattice lattice({40, 60});
  std::vector<double> load(40, 1.0);
  std::fill(load.begin(), load.begin() + 20, 0.0);
  Pile pile(lattice);
  fill_frictionless(load, pile);
  pile.mu = tan30;
  REQUIRE(FrictionCone(tan30).t_minus() == 0);
  const AuditResult result = audit(pile);
  CHECK(result.max_balance_residual < residual_of_rounding);
  CHECK(result.max_cone_violation < residual_of_rounding);
}

}  // namespace

}  // namespace granuscope
