#include "analysis/precision.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

namespace granuscope {

TEST_CASE("error curves: the scatter over repetitions of one, two, ... units, and a slope with its error",
          "[unsanitized]") {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.sampler.mu = 0.3;
  spec.response.epsilon = 0.5;
  spec.lattice = {256, 120};
  spec.response.blocks = 8 * repetition_blocks;
  spec.response.samples = 8 * 64;
  const FitSpec fit = error_curve_fit(spec.lattice);
  CHECK(fit.last_layer == 99);
  CHECK(fit.first_layer < fit.last_layer / 2);
  CHECK(fit.layer_step % 2 == 1);
  spec.layers = layers_to_record(fit, {});
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const ErrorCurve curve = measure_error_curve({spec, record}, fit, 2);
  REQUIRE(curve.points.size() == 2);
  CHECK(curve.points[0].samples == 64);
  CHECK(curve.points[0].repetitions == 8);
  CHECK(curve.points[1].samples == 128);
  CHECK(curve.points[1].repetitions == 4);
  CHECK(curve.samples == spec.response.samples);
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
  wide.spec.response.opposite = narrow.spec.response.opposite = true;
  wide.spec.response.epsilon = 0.25;
  narrow.c = {0.55, 1e-3, {}};
  narrow.D = {0.06, 4e-3, {}};
  narrow.spec.response.epsilon = 0.1;
  std::vector<ErrorCurve> curves{point, wide, narrow};
  set_shifts(curves);
  CHECK(curves[0].shift_D.value == Approx(-0.01));
  CHECK(curves[0].shift_D.standard_error == Approx(5e-3));
  CHECK(curves[1].shift_c.value == Approx(0.01));
  CHECK_FALSE(curves[2].shift_c.known());
  CHECK_FALSE(curves[2].shift_c.reason.empty());
}

TEST_CASE("error curves: errors of every estimator fall as the square root of the piles", "[long]") {
  // Sizes of one curve share their piles, those of different curves do not, so that the mean slope is known to a third
  // of what one slope is.
  double sum_c = 0, sum_D = 0, variance = 0;
  int curves = 0;
  std::uint64_t seed = 5150;
  struct Options {
    EstimatorName estimator;
    bool opposite;
    int sign_run;
    std::uint64_t samples;
    int repetitions;
  };
  for (const Options& options : {Options{EstimatorName::point, false, 1, 4096, 32},
                                 {EstimatorName::multiplexed, false, 1, 256, 64},
                                 {EstimatorName::multiplexed, true, 1, 256, 64},
                                 {EstimatorName::multiplexed, true, 2, 256, 64}}) {
    for (const double mu : {0.25, 0.3}) {
      EnsembleSpec spec;
      spec.response.estimator = options.estimator;
      spec.response.opposite = options.opposite;
      spec.response.sign_run = options.sign_run;
      spec.sampler.mu = mu;
      spec.sampler.seed = ++seed;
      spec.response.epsilon = 0.25;
      spec.lattice = {160, 80};
      spec.response.blocks = options.repetitions * repetition_blocks;
      spec.response.samples = static_cast<std::uint64_t>(options.repetitions) * options.samples;
      const FitSpec fit = error_curve_fit(spec.lattice);
      spec.layers = layers_to_record(fit, {});
      const ErrorCurve curve = measure_error_curve({spec, run_ensemble(spec, 2, nullptr)}, fit, 2);
      CAPTURE(mu, name_of(options.estimator), curve.points.size(), curve.slope_c.value, curve.slope_D.value);
      // A size of which one repetition has no fit is left out.
      if (curve.points.size() < 3) continue;
      CHECK(std::abs(curve.slope_c.value + 0.5) < 4.5 * curve.slope_c.standard_error);
      CHECK(std::abs(curve.slope_D.value + 0.5) < 4.5 * curve.slope_D.standard_error);
      sum_c += curve.slope_c.value;
      sum_D += curve.slope_D.value;
      variance += curve.slope_c.standard_error * curve.slope_c.standard_error;
      ++curves;
    }
  }
  REQUIRE(curves >= 6);
  const double allowed = 4.5 * std::sqrt(variance) / curves;
  CAPTURE(sum_c / curves, sum_D / curves, allowed);
  CHECK(allowed < 0.25);  // enough to tell -1/2 from a floor
  CHECK(std::abs(sum_c / curves + 0.5) < allowed);
  CHECK(std::abs(sum_D / curves + 0.5) < allowed);
}

}  // namespace granuscope
