// Source: the invariants in granusolve_state.h, broken by hand one at a time.
#include "sampling/granusolve_state.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "sampling/granusolve.h"

namespace granuscope {
namespace {

SamplerSpec with_friction(double mu) {
  SamplerSpec spec;
  spec.mu = mu;
  return spec;
}

constexpr int columns = 40, layers = 24;

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

  Lattice lattice{{columns, layers}};
  std::vector<double> load = std::vector<double>(columns, 1.0);
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
    for (int layer = 1; layer < layers; ++layer) {
      REQUIRE(pile.solver.solve_layer(layer) == SolveResult::solved);
      CHECK_NOTHROW(pile.state().check());
    }
    for (const int layer : {layers - 2, layers - 1}) {
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
  CHECK_NOTHROW(pile.state().check_run(10, {(child + 5) % columns, 2}));
}

TEST_CASE("in the midst of a layer, a bead that does not fail is as good as solved, and what fails is noted") {
  Begun pile(12);
  const GranusolveState& state = pile.begun;
  REQUIRE(state.cursor() < columns);  // some bead fails
  CHECK_NOTHROW(state.check());
  const int failing = state.cursor_bead();
  state.arrays().failing[0] &= ~(std::uint64_t{1} << failing);
  expect_broken(state);
  state.arrays().failing[0] |= std::uint64_t{1} << failing;
  CHECK_NOTHROW(state.check());

  // One whose turn has not come: nobody has done anything for it, and it changes only together with failing.
  const RandomKey::Order order = state.order(12);
  const int bead = (order.first_bead - order.direction + columns) % columns;  // the last one
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
  REQUIRE(cursor < columns);
  state.move_cursor(12, cursor, bead == 0 ? 1 : bead - 1);
  expect_broken(state);
  state.move_cursor(12, columns + 1, -1);
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

}  // namespace
}  // namespace granuscope
