// Source of the expected numbers: trigonometry (tangents of 30 degrees -+ atan mu).
#include "model/lattice.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/error.h"

namespace granuscope {
namespace {

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

}  // namespace
}  // namespace granuscope
