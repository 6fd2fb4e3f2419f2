#include "analysis/error_curve.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

namespace granuscope {

TEST_CASE("error curves: the scatter over repetitions of one, two, ... units, and a slope with its error") {
  EnsembleSpec spec;
  spec.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = 0.3;
  spec.epsilon = 0.5;
  spec.lattice = {256, 120};
  spec.blocks = 8 * repetition_blocks;
  spec.samples = 8 * 64;
  const FitSpec fit = error_curve_fit(spec.lattice);
  CHECK(fit.last_layer == 99);
  CHECK(fit.first_layer < fit.last_layer / 2);
  CHECK(fit.layer_step % 2 == 1);
  spec.layers = layers_to_record(fit, {});
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const ErrorCurve curve = measure_error_curve(spec, record, 2);
  REQUIRE(curve.points.size() == 2);
  CHECK(curve.points[0].samples == 64);
  CHECK(curve.points[0].repetitions == 8);
  CHECK(curve.points[1].samples == 128);
  CHECK(curve.points[1].repetitions == 4);
  CHECK(curve.samples == spec.samples);
  CHECK(curve.c.value == Approx(0.56).margin(0.02));
  CHECK(curve.points[0].scatter_c > 1e-5);
  CHECK(curve.points[0].scatter_c < 0.02);
  CHECK(curve.c.standard_error == Approx(curve.points[0].scatter_c / std::sqrt(8.0)));
  // Two sizes, known to 1/sqrt(14) and 1/sqrt(6): the slope is the quotient of differences.
  const double rise = std::log(curve.points[1].scatter_D / curve.points[0].scatter_D);
  CHECK(curve.slope_D.value == Approx(rise / std::log(2.0)));
  CHECK(curve.slope_D.standard_error == Approx(std::sqrt(1 / 14.0 + 1 / 6.0) / std::log(2.0)));
  CHECK(std::abs(curve.slope_D.value + 0.5) < 5 * curve.slope_D.standard_error);
}

TEST_CASE("error curves: shifts are held against opposite loads with the smallest epsilon") {
  ErrorCurve point, wide, narrow;
  point.c = {0.57, 1e-3, {}};
  point.D = {0.05, 3e-3, {}};
  wide.c = {0.56, 1e-3, {}};
  wide.D = {0.07, 1e-3, {}};
  wide.opposite = narrow.opposite = true;
  wide.epsilon = 0.25;
  narrow.c = {0.55, 1e-3, {}};
  narrow.D = {0.06, 4e-3, {}};
  narrow.epsilon = 0.1;
  std::vector<ErrorCurve> curves{point, wide, narrow};
  set_shifts(curves);
  CHECK(curves[0].shift_D.value == Approx(-0.01));
  CHECK(curves[0].shift_D.standard_error == Approx(5e-3));
  CHECK(curves[1].shift_c.value == Approx(0.01));
  CHECK_FALSE(curves[2].shift_c.known());
  CHECK_FALSE(curves[2].shift_c.reason.empty());
}

}  // namespace granuscope
