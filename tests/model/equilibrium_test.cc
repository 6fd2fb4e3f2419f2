// Source: the balances of one bead written in normal and tangential components by angles, and the definition of the
// friction cone, both independent of the form the samplers use.
#include "model/equilibrium.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace granuscope {
namespace {

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

TEST_CASE("outgoing forces balance force and torque, whatever the split") {
  const unsigned seed = 20020417;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> force(0, 10), sideways(-10, 10);
  double worst = 0;
  for (int k = 0; k < 100'000; ++k) {
    const double V_UL = force(engine), V_UR = force(engine), H_UL = sideways(engine), H_UR = sideways(engine);
    const double H = H_UL + H_UR;
    const Outgoing out = balance({V_UL, V_UR, H});
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
    const FrictionCone cone(friction(engine));
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
    const FrictionCone cone(1.731 * unit(engine));
    // Half of the beads with forces over six orders of magnitude, one in ten with a contact that carries nothing.
    const auto force = [&] { return unit(engine) < 0.5 ? unit(engine) : std::pow(10, -6 * unit(engine)); };
    const double V_UL = unit(engine) < 0.1 ? 0 : force(), V_UR = unit(engine) < 0.1 ? 0 : force();
    const Interval band = solvable_band(cone, V_UL, V_UR);
    const double scale = V_UL + V_UR;
    // Rounding of V = V_U + sqrt(3) H times the steepest edge, t_plus.
    const double rounding = 32 * epsilon * scale * (1 + cone.t_plus());
    empty_bands += band.low > band.high + rounding;
    const double H = (1.5 * unit(engine) - 0.25) * (band.high - band.low) + band.low;
    const Outgoing out = balance({V_UL, V_UR, H});
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
  const Outgoing out = balance({0.5, 0.5, 0});
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
  const Outgoing straight = balance({1, 0, tan30});
  CHECK(straight.V_R == Approx(1).epsilon(1e-15));
  CHECK(std::abs(straight.V_L) < 4 * epsilon);
}

TEST_CASE("intervals intersect") {
  CHECK(intersection({0, 2}, {1, 3}).low == 1);
  CHECK(intersection({0, 2}, {1, 3}).high == 2);
  CHECK(intersection({0, 1}, {2, 3}).empty());
  CHECK_FALSE(intersection({0, 1}, {1, 3}).empty());
}

}  // namespace
}  // namespace granuscope
