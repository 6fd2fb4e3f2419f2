// Lattice, equilibrium, friction cone and audit of a pile.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <stdexcept>

#include "central_pile.h"
#include "model/audit.h"
#include "model/equilibrium.h"
#include "model/lattice.h"
#include "support/error.h"

namespace granuscope {
namespace {

using test::central_pile;
using test::uniform_frictionless_pile;

// Source of the expected numbers: geometry of the triangular lattice (neighbours are half a bead apart in x), and the
// caption of the paper's Fig. 2 for the depths.

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

// Source: the balances of one bead written in normal and tangential components by angles, and the definition of the
// friction cone, both independent of the form the samplers use.

constexpr double epsilon = std::numeric_limits<double>::epsilon();

#ifdef __SANITIZE_ADDRESS__
constexpr int random_beads = 200'000;
#else
constexpr int random_beads = 2'000'000;
#endif

/// Normal and tangential part of a force (V down, H right) along a contact whose direction leaves the vertical by
/// `angle` towards the right; the tangent is the direction turned anticlockwise, as seen with z down.
struct Resolved {
  double normal, tangential;
};
Resolved resolve(double V, double H, double angle) {
  return {V * std::cos(angle) + H * std::sin(angle), H * std::cos(angle) - V * std::sin(angle)};
}

constexpr double right = std::numbers::pi / 6, left = -std::numbers::pi / 6;
constexpr double some_angles[] = {20, 30, 45, 60};  // degrees

TEST_CASE("outgoing forces balance force and torque, whatever the split") {
  const unsigned seed = 20020417;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> force(0, 10), sideways(-10, 10);
  double worst = 0;
  for (int k = 0; k < 100'000; ++k) {
    const double V_UL = force(engine), V_UR = force(engine), H_UL = sideways(engine), H_UR = sideways(engine);
    const double H = H_UL + H_UR, angle = some_angles[k % 4], right = angle * std::numbers::pi / 180, left = -right;
    const Outgoing out = balance(FrictionCone(0, BeadGeometry(angle)), {V_UL, V_UR, H});
    const double H_R = sideways(engine), H_L = H - H_R;
    // The contact to the upper left has the direction of the one to the lower right.
    const Resolved UL = resolve(V_UL, H_UL, right), UR = resolve(V_UR, H_UR, left);
    const Resolved R = resolve(out.V_R, H_R, right), L = resolve(out.V_L, H_L, left);
    // Each contact acts on the rim with its tangential force; upper and lower rim turn the bead the same way, because
    // the force a bead receives from below is opposite and its arm is opposite, too.
    const double torque = UL.tangential + UR.tangential + R.tangential + L.tangential;
    const double vertical = V_UL + V_UR - out.V_R - out.V_L;
    worst = std::max({worst, std::abs(torque), std::abs(vertical), std::abs(H_UL + H_UR - H_R - H_L)});
  }
  CHECK(worst < 1e-13);  // forces up to 10, some ten roundings
}

TEST_CASE("the split interval is Coulomb's cone on both lower contacts") {
  const unsigned seed = 77;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> force(0, 1), sideways(-1, 1), friction(0, 1.7);
  int inside = 0, outside = 0, wrong = 0;
  for (int k = 0; k < random_beads / 4; ++k) {
    const BeadGeometry geometry(some_angles[k % 4]);
    const double right = geometry.angle * std::numbers::pi / 180, left = -right;
    const FrictionCone cone(std::min(1.0, geometry.cotangent / 1.733) * friction(engine), geometry);
    const double H = 0.5 * sideways(engine), H_R = sideways(engine);
    const Outgoing out{force(engine), force(engine)};
    const Interval interval = split_interval(cone, out, H);
    const Resolved R = resolve(out.V_R, H_R, right), L = resolve(out.V_L, H - H_R, left);
    const double margin =
        std::min(cone.mu() * R.normal - std::abs(R.tangential), cone.mu() * L.normal - std::abs(L.tangential));
    if (std::abs(margin) < 1e-12) continue;  // on an edge, by rounding on either side
    const bool allowed = margin > 0;
    (allowed ? inside : outside) += 1;
    wrong += allowed != (interval.low <= H_R && H_R <= interval.high);
  }
  CAPTURE(inside, outside);
  CHECK(wrong == 0);
  CHECK(inside > random_beads / 100);
  CHECK(outside > random_beads / 100);
}

TEST_CASE("a bead is solvable exactly where its H lies in the band, and the band is never empty") {
  const unsigned seed = 4242;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int solvable = 0, unsolvable = 0, wrong = 0, empty_bands = 0, negative = 0;
  for (int k = 0; k < random_beads; ++k) {
    const BeadGeometry geometry(some_angles[k % 4]);
    const FrictionCone cone(0.9994 * geometry.cotangent * unit(engine), geometry);
    // Half of the beads with forces over six orders of magnitude, one in ten with a contact that carries nothing.
    const auto force = [&] { return unit(engine) < 0.5 ? unit(engine) : std::pow(10, -6 * unit(engine)); };
    const double V_UL = unit(engine) < 0.1 ? 0 : force(), V_UR = unit(engine) < 0.1 ? 0 : force();
    const Interval band = solvable_band(cone, V_UL, V_UR);
    const double scale = V_UL + V_UR;
    // Rounding of V = V_U + sqrt(3) H times the steepest edge, t_plus.
    const double rounding = 32 * epsilon * scale * (1 + cone.t_plus());
    empty_bands += band.low > band.high + rounding;
    const double H = (1.5 * unit(engine) - 0.25) * (band.high - band.low) + band.low;
    const Outgoing out = balance(cone, {V_UL, V_UR, H});
    const Interval interval = split_interval(cone, out, H);
    if (!interval.empty()) negative += out.V_R < -rounding || out.V_L < -rounding;
    const double distance = std::min(H - band.low, band.high - H);
    if (std::abs(distance) <= rounding) continue;
    (distance > 0 ? solvable : unsolvable) += 1;
    wrong += (distance > 0) == (interval.high - interval.low < -rounding);
    wrong += (distance < 0) == (interval.high - interval.low > rounding);
  }
  CAPTURE(solvable, unsolvable);
  CHECK(wrong == 0);
  CHECK(empty_bands == 0);
  CHECK(negative == 0);
  CHECK(solvable > random_beads / 4);
  CHECK(unsolvable > random_beads / 10);
}

TEST_CASE("one bead by hand") {
  // Two vertical halves, no H: both contacts carry 1/2, and without friction H_R = tan(30 deg)/2.
  const Outgoing out = balance(FrictionCone(0), {0.5, 0.5, 0});
  CHECK(out.V_R == 0.5);
  CHECK(out.V_L == 0.5);
  const Interval frictionless = split_interval(FrictionCone(0), out, 0);
  CHECK(frictionless.low == tan30 * 0.5);
  CHECK(frictionless.high == tan30 * 0.5);
  // Friction 1/sqrt 3: contacts may stand anywhere between the vertical and 60 degrees.
  const Interval wide = split_interval(FrictionCone(tan30), out, 0);
  CHECK(std::abs(wide.low) < 4 * epsilon);
  CHECK(wide.high == Approx(sqrt3 / 2).epsilon(1e-15));
  // All the force on the upper-left contact, along it: it runs straight through to the lower right.
  const Outgoing straight = balance(FrictionCone(0), {1, 0, tan30});
  CHECK(straight.V_R == Approx(1).epsilon(1e-15));
  CHECK(std::abs(straight.V_L) < 4 * epsilon);
}

TEST_CASE("intervals intersect") {
  CHECK(intersection({0, 2}, {1, 3}).low == 1);
  CHECK(intersection({0, 2}, {1, 3}).high == 2);
  CHECK(intersection({0, 1}, {2, 3}).empty());
  CHECK_FALSE(intersection({0, 1}, {1, 3}).empty());
}

// Source of the expected numbers: trigonometry (tangents of 30 degrees -+ atan mu).

/// Eight units in the last place: two tangents and one arc tangent of the expected value.
constexpr double tangent_tolerance = 8 * std::numeric_limits<double>::epsilon();

TEST_CASE("the cone's edges are the tangents of 30 degrees minus and plus the angle of friction") {
  constexpr double thirty_degrees = std::numbers::pi / 6;
  for (const double mu : {0.0, 1e-9, 0.05, 0.1, 0.3, 0.6, 1.0, 1.3, 1.7}) {
    INFO("mu " << mu);
    const FrictionCone cone(mu);
    const double phi = std::atan(mu);
    CHECK(cone.mu() == mu);
    CHECK(std::abs(cone.t_minus() - std::tan(thirty_degrees - phi)) <= tangent_tolerance);
    // d tan = (1 + tan^2) d angle: towards the horizontal a rounded angle moves the tangent by more than its own ulp.
    const double t_plus = std::tan(thirty_degrees + phi);
    CHECK(std::abs(cone.t_plus() - t_plus) <= tangent_tolerance * (1 + t_plus * t_plus));
    CHECK(cone.k() == Approx(sqrt3 * (cone.t_minus() + cone.t_plus()) - 1).epsilon(1e-15));
    CHECK(cone.k() > 0);
  }
}

TEST_CASE("the geometry of 30 degrees is that of literal numbers, to the bit, and of others their sines and cosines") {
  const BeadGeometry usual(30), none;
  for (const double BeadGeometry::*number :
       {&BeadGeometry::tangent, &BeadGeometry::cotangent, &BeadGeometry::twice_sine, &BeadGeometry::twice_cosine}) {
    CHECK(usual.*number == none.*number);
  }
  CHECK((none.tangent == tan30 && none.cotangent == sqrt3 && none.twice_sine == 1 && none.twice_cosine == sqrt3));
  CHECK(BeadGeometry(45).tangent == 1);
  for (const double angle : some_angles) {
    INFO(angle);
    const double radians = angle * std::numbers::pi / 180;
    const BeadGeometry geometry(angle);
    CHECK(geometry.tangent == Approx(std::sin(radians) / std::cos(radians)).epsilon(1e-15));
    CHECK(geometry.tangent * geometry.cotangent == Approx(1).epsilon(1e-15));
    CHECK(geometry.twice_sine == Approx(2 * std::sin(radians)).epsilon(1e-15));
    CHECK(geometry.twice_cosine == Approx(2 * std::cos(radians)).epsilon(1e-15));
    const double share = 0.3 * geometry.cotangent, phi = std::atan(share);
    const FrictionCone cone(share, geometry);
    CHECK(cone.t_minus() == Approx(std::tan(radians - phi)).epsilon(1e-14));
    CHECK(cone.t_plus() == Approx(std::tan(radians + phi)).epsilon(1e-14));
    // As wide a cone at 30 degrees, whose edges reach no less far.
    const FrictionCone like(cone.mu_at_30());
    CHECK(like.t_plus() >= cone.t_plus() * tan30 / geometry.tangent - tangent_tolerance);
    CHECK(like.t_minus() <= cone.t_minus() * tan30 / geometry.tangent + tangent_tolerance);
    CHECK(FrictionCone(1e-6, geometry).mu_at_30() == Approx(1e-6 * sqrt3 / 2 / std::sin(2 * radians)).epsilon(1e-5));
    // Lattice and rows have the same depths.
    const Lattice lattice({.columns = 4, .layers = 9, .angle = angle});
    CHECK(RowGeometry{.spacing = lattice.spacing(), .pitch = lattice.pitch()}.depth(8) == lattice.z(8));
    CHECK(RowGeometry{.spacing = lattice.spacing(), .pitch = lattice.pitch()}.ray() ==
          Approx(geometry.tangent).epsilon(1e-15));
    CHECK_THROWS_AS(FrictionCone(geometry.cotangent, geometry), InputError);
  }
  CHECK(FrictionCone(0.3).mu_at_30() == 0.3);
  CHECK(Lattice({.columns = 4, .layers = 200}).z(110) == Lattice::depth(110));
  for (const double angle : {19.9, 60.1, std::nan("")}) CHECK_THROWS_AS(Lattice({4, 4, angle}), InputError);
}

TEST_CASE("special friction coefficients") {
  // tan 30 deg = 1/sqrt 3: no friction closes the cone onto the contact; mu = 1/sqrt 3 reaches the vertical.
  const FrictionCone none(0);
  CHECK(none.t_minus() == tan30);
  CHECK(none.t_plus() == tan30);
  CHECK(none.k() == Approx(1).epsilon(1e-15));
  CHECK(std::abs(FrictionCone(tan30).t_minus()) <= tangent_tolerance);
  CHECK(FrictionCone(tan30).t_plus() == Approx(sqrt3).epsilon(1e-15));  // tan 60 deg
  CHECK(FrictionCone(0.58).t_minus() < 0);
}

TEST_CASE("coefficients outside [0, sqrt 3) are refused") {
  for (const double mu : {-1e-300, -0.1, sqrt3, 2.0, std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    INFO("mu " << mu);
    CHECK_THROWS_AS(FrictionCone(mu), InputError);
  }
  CHECK_NOTHROW(FrictionCone(-0.0));
  CHECK_NOTHROW(FrictionCone(std::nextafter(sqrt3, 0.0)));
}

// Source of the expected numbers: algebra. A force changed by d breaks the balance of its bead by exactly d; the
// violation of a cone by a known force is written down beside each case.

double largest_force(const Pile& pile, int layer) {
  double largest = 0;
  for (int i = 0; i < pile.lattice.columns(); ++i) {
    const std::size_t at = pile.lattice.index(layer, i);
    largest = std::max({largest, std::hypot(pile.V_R[at], pile.H_R[at]), std::hypot(pile.V_L[at], pile.H_L[at])});
  }
  return largest;
}

TEST_CASE("a pile in balance passes the audit") {
  for (const double mu : {0.1, 0.5, 1.0, 1.6}) {
    for (const int columns : {4, 5, 12}) {
      INFO("mu " << mu << ", columns " << columns);
      const AuditResult result = audit(central_pile(Lattice({.columns = columns, .layers = 6}), mu, 5));
      CHECK(result.max_balance_residual <= 1e-14);
      CHECK(result.max_balance_residual > 0);  // real forces round
      CHECK(result.max_cone_violation <= 1e-15);
    }
  }
}

TEST_CASE("a torque alone that does not balance is found") {
  const Lattice lattice({.columns = 5, .layers = 6});
  const Pile sound = central_pile(lattice, 0.8, 11);
  // Nothing hangs below the last layer: taking from one of a bead's contacts what the other gets turns the bead only.
  const std::size_t bead = lattice.index(5, 2);
  for (const double shift : {1e-9, -1e-9}) {
    Pile turned = sound;
    turned.V_R[bead] += shift * largest_force(sound, 5);
    turned.V_L[bead] -= shift * largest_force(sound, 5);
    const AuditResult result = audit(turned);
    CHECK(result.max_balance_residual == Approx(1e-9).epsilon(0.01));
    CHECK(result.balance_layer == 5);
  }
}

TEST_CASE("one force wrong by a billionth is found, in any array, layer and bead") {
  const Lattice lattice({.columns = 5, .layers = 6});
  const Pile sound = central_pile(lattice, 0.8, 11);
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (int n = 0; n < lattice.layers(); ++n) {
      for (int i = 0; i < lattice.columns(); ++i) {
        for (const double sign : {1.0, -1.0}) {
          INFO("layer " << n << ", bead " << i);
          Pile broken = sound;
          (broken.*array)[lattice.index(n, i)] += sign * 1e-9 * largest_force(sound, n);
          const AuditResult result = audit(broken);
          REQUIRE(result.max_balance_residual >= 0.999e-9);
          REQUIRE(result.max_balance_residual < 1e-8);
          REQUIRE((result.balance_layer == n || result.balance_layer == n + 1));
        }
      }
    }
  }
}

TEST_CASE("a load that is not the one carried is found") {
  Pile pile = central_pile(Lattice({.columns = 6, .layers = 3}), 0.8, 3);
  pile.load[4] *= 1 + 1e-9;
  const AuditResult result = audit(pile);
  CHECK(result.max_balance_residual > 1e-10);
  CHECK(result.balance_layer == 0);
}

TEST_CASE("a pile without friction has neither residual nor violation") {
  Pile pile = uniform_frictionless_pile(Lattice({.columns = 6, .layers = 5}));
  const AuditResult result = audit(pile);
  // |T| of a contact along its direction is one rounding of V/2.
  CHECK(result.max_balance_residual <= 2 * std::numeric_limits<double>::epsilon());
  CHECK(result.max_cone_violation <= 2 * std::numeric_limits<double>::epsilon());
}

TEST_CASE("a cone is violated by the known amount") {
  const Lattice lattice({.columns = 6, .layers = 5});
  const double N = 1 / std::sqrt(3.0);  // of every contact: V = 1/2 along 30 degrees
  const std::size_t at = lattice.index(3, 2);
  for (const double mu : {0.0, 0.1, 0.4}) {
    for (const double shift : {1e-6, 0.3}) {
      Pile pile = uniform_frictionless_pile(lattice);
      pile.mu = mu;
      // Tangent of the right contact: (V, H) = (-1/2, sqrt(3)/2), of the left one (1/2, sqrt(3)/2).
      const double T = mu * N + shift;
      SECTION("right, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_R[at] -= T / 2, pile.H_R[at] += T * std::sqrt(3.0) / 2;
      }
      SECTION("left, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_L[at] += T / 2, pile.H_L[at] += T * std::sqrt(3.0) / 2;
      }
      SECTION("left, other way, mu " + std::to_string(mu) + " shift " + std::to_string(shift)) {
        pile.V_L[at] -= T / 2, pile.H_L[at] -= T * std::sqrt(3.0) / 2;
      }
      if (pile.V_R[at] == 0.5 && pile.V_L[at] == 0.5) continue;
      const AuditResult result = audit(pile);
      CHECK(result.max_cone_violation == Approx(shift / std::hypot(N, T)).epsilon(1e-9));
      CHECK(result.cone_layer == 3);
    }
  }
}

TEST_CASE("a contact that pulls is a violation even where |T| is small") {
  const Lattice lattice({.columns = 6, .layers = 5});
  Pile pile = uniform_frictionless_pile(lattice);
  pile.mu = 1.0;
  const std::size_t at = lattice.index(4, 0);
  pile.V_R[at] = -0.5, pile.H_R[at] = -0.5 / std::sqrt(3.0);
  // N = -1/sqrt 3, as large as any force: |T| - mu N = 1/sqrt 3, too.
  const AuditResult result = audit(pile);
  CHECK(result.max_cone_violation == Approx(1).epsilon(1e-14));
  CHECK(result.cone_layer == 4);
}

TEST_CASE("a force that is not a number is refused") {
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L, &Pile::load}) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Pile pile = uniform_frictionless_pile(Lattice({.columns = 4, .layers = 3}));
      (pile.*array).back() = value;
      CHECK_THROWS_AS(audit(pile), InputError);
    }
  }
  Pile pile = uniform_frictionless_pile(Lattice({.columns = 4, .layers = 3}));
  pile.mu = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(audit(pile), InputError);
}

TEST_CASE("residuals are relative to their own layer and do not depend on the unit of force") {
  Pile pile = central_pile(Lattice({.columns = 7, .layers = 6}), 0.9, 21);
  pile.H_R[pile.lattice.index(2, 3)] += 1e-7;
  const AuditResult result = audit(pile);
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L, &Pile::load}) {
    for (double& force : pile.*array) force = std::ldexp(force, 100);
  }
  const AuditResult scaled = audit(pile);
  CHECK(scaled.max_balance_residual == result.max_balance_residual);
  CHECK(scaled.max_cone_violation == result.max_cone_violation);
}

// Source: the balances of neighbouring beads, eliminated by hand. The sum of w is the sum of the loads; and two layers
// apart w_{n+1}(x) - w_{n-1}(x) = sqrt(3) [H_n(x - 1/2) - H_n(x + 1/2)].

TEST_CASE("the identities hold on piles in balance") {
  for (const double mu : {0.1, 0.5, 1.0, 1.6}) {
    for (const int columns : {4, 5, 12}) {
      INFO("mu " << mu << ", columns " << columns);
      const Pile pile = central_pile(Lattice({.columns = columns, .layers = 6}), mu, 9);
      const IdentityResiduals residuals = identity_residuals(pile);
      CHECK(residuals.weight_sum <= 1e-14);
      CHECK(residuals.wave_equation <= 1e-14);
      CHECK_NOTHROW(assert_identities(pile));
    }
  }
}

TEST_CASE("a corrupted vertical force breaks the sum of weights by its amount") {
  const Pile sound = uniform_frictionless_pile(Lattice({.columns = 5, .layers = 6}));
  for (auto array : {&Pile::V_R, &Pile::V_L}) {
    Pile broken = sound;
    (broken.*array)[sound.lattice.index(5, 4)] += 5e-9;  // of a total of 5
    CHECK(identity_residuals(broken).weight_sum == Approx(1e-9).epsilon(1e-5));
    CHECK_THROWS_AS(assert_identities(broken), std::logic_error);
  }
}

TEST_CASE("a corrupted horizontal force breaks the local wave equation by its amount") {
  const Pile sound = uniform_frictionless_pile(Lattice({.columns = 5, .layers = 6}));
  for (auto array : {&Pile::H_R, &Pile::H_L}) {
    for (int n = 1; n < 5; ++n) {
      Pile broken = sound;
      (broken.*array)[sound.lattice.index(n, 3)] += 1e-9;  // every w is 1
      CHECK(identity_residuals(broken).wave_equation == Approx(std::sqrt(3.0) * 1e-9).epsilon(1e-5));
      CHECK_THROWS_AS(assert_identities(broken), std::logic_error);
    }
  }
}

TEST_CASE("weight moved sideways keeps the sum and breaks the wave equation") {
  Pile pile = central_pile(Lattice({.columns = 8, .layers = 6}), 0.9, 2);
  pile.V_R[pile.lattice.index(3, 2)] += 1e-6;
  pile.V_R[pile.lattice.index(3, 3)] -= 1e-6;
  CHECK(identity_residuals(pile).weight_sum <= 1e-14);
  CHECK(identity_residuals(pile).wave_equation > 1e-7);
  CHECK_THROWS_AS(assert_identities(pile), std::logic_error);
}

TEST_CASE("a force that is not a number breaks the identities") {
  const Lattice lattice({.columns = 5, .layers = 6});
  for (auto array : {&Pile::V_R, &Pile::V_L, &Pile::H_R, &Pile::H_L}) {
    for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      Pile pile = uniform_frictionless_pile(lattice);
      (pile.*array)[lattice.index(3, 2)] = value;
      CHECK_THROWS_AS(assert_identities(pile), std::logic_error);
    }
  }
}

}  // namespace

}  // namespace granuscope
