// Source of the expected numbers: geometry of the triangular lattice (neighbours are half a bead apart in x), and the
// caption of the paper's Fig. 2 for the depths.
#include "model/lattice.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "support/error.h"

namespace granuscope {
namespace {

/// Horizontal distance from a to b around the ring, in (-columns/2, columns/2].
double step_between(const Lattice& lattice, int layer_a, int a, int layer_b, int b) {
  const double step = lattice.x(layer_b, b) - lattice.x(layer_a, a);
  return step - lattice.columns() * std::round(step / lattice.columns());
}

TEST_CASE("neighbours of a bead lie half a bead to its left and right, and know the bead in turn") {
  for (const int columns : {4, 5, 6, 7, 500}) {
    const Lattice lattice({.columns = columns, .layers = 4});
    for (int n = 0; n < 4; ++n) {
      for (int i = 0; i < columns; ++i) {
        INFO("columns " << columns << ", layer " << n << ", bead " << i);
        const int right = lattice.lower_right(n, i), left = lattice.lower_left(n, i);
        REQUIRE((right >= 0 && right < columns && left >= 0 && left < columns));
        REQUIRE(step_between(lattice, n, i, n + 1, right) == 0.5);
        REQUIRE(step_between(lattice, n, i, n + 1, left) == -0.5);
        REQUIRE(lattice.upper_left(n + 1, right) == i);
        REQUIRE(lattice.upper_right(n + 1, left) == i);
        REQUIRE(lattice.lower_right(n, lattice.upper_left(n + 1, i)) == i);
        REQUIRE(lattice.lower_left(n, lattice.upper_right(n + 1, i)) == i);
        REQUIRE(lattice.next(lattice.previous(i)) == i);
        REQUIRE(lattice.previous(lattice.next(i)) == i);
      }
    }
  }
}

TEST_CASE("at the seam the first and the last bead are neighbours") {
  const Lattice lattice({.columns = 6, .layers = 3});
  // Even layer: bead 0 stands at x = 0, its lower-left neighbour at -1/2, which is bead 5 (x = 5.5) of the layer below.
  CHECK(lattice.lower_left(0, 0) == 5);
  CHECK(lattice.lower_right(0, 5) == 5);
  // Odd layer: bead 5 stands at x = 5.5, its lower-right neighbour at 6, which is bead 0.
  CHECK(lattice.lower_right(1, 5) == 0);
  CHECK(lattice.lower_left(1, 0) == 0);
}

TEST_CASE("the depths are those of the paper's Fig. 2") {
  CHECK(Lattice::depth(0) == 0.5);
  CHECK(Lattice::depth(110) == Approx(95.763).margin(5e-4));
  CHECK(Lattice::depth(170) == Approx(147.724).margin(5e-4));
  // The caption prints 95.8 and 147.7.
  CHECK(std::abs(Lattice::depth(110) - 95.8) < 0.05);
  CHECK(std::abs(Lattice::depth(170) - 147.7) < 0.05);
}

TEST_CASE("x counts from the overloaded bead and wraps to [-columns/2, columns/2)") {
  for (const int columns : {4, 5, 6, 7, 500, 501}) {
    const Lattice lattice({.columns = columns, .layers = 2});
    CHECK(lattice.middle() == columns / 2);
    CHECK(lattice.x(0, lattice.middle()) == 0);
    for (int n = 0; n < 2; ++n) {
      std::set<double> seen;
      for (int i = 0; i < columns; ++i) {
        const double x = lattice.x(n, i);
        REQUIRE((x >= -0.5 * columns && x < 0.5 * columns));
        REQUIRE(x - std::floor(x) == (n == 0 ? 0 : 0.5));
        seen.insert(x);
      }
      REQUIRE(seen.size() == static_cast<std::size_t>(columns));
    }
  }
}

TEST_CASE("lattices that hold no pile are refused, and usable layers leave the bottom margin") {
  CHECK_THROWS_AS(Lattice({.columns = 3, .layers = 5}), InputError);
  CHECK_THROWS_AS(Lattice({.columns = -1, .layers = 5}), InputError);
  CHECK_THROWS_AS(Lattice({.columns = 4, .layers = 0}), InputError);
  CHECK(Lattice({.columns = 4, .layers = 1}).usable_layers() == 0);
  CHECK(Lattice({.columns = 4, .layers = 20}).usable_layers() == 0);
  CHECK(Lattice({.columns = 4, .layers = 200}).usable_layers() == 180);
  // Counted in size_t: a pile of 50 000 x 50 000 beads has more beads than an int counts.
  const Lattice large({.columns = 50'000, .layers = 50'000});
  CHECK(large.beads() == std::size_t{2'500'000'000});
  CHECK(large.index(49'999, 49'999) == std::size_t{2'499'999'999});
}

}  // namespace
}  // namespace granuscope
