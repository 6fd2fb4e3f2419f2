// Responses of piles under leaning loads. Their two peaks move with different speeds, c + s to the one side and c - s
// to the other; averaged over mirror images they stay two peaks of one width as long as s z is small beside W.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

Transport response_under(double angle, EstimatorName estimator, std::uint64_t samples) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 58;
  fit.last_layer = 148;
  EnsembleSpec spec;
  spec.response.estimator = estimator;
  spec.response.samples = samples;
  if (estimator == EstimatorName::multiplexed) {
    spec.response.opposite = true;
    spec.response.epsilon = 0.15;
  }
  spec.sampler.mu = 0.3;
  spec.sampler.load_angle = angle;
  spec.lattice = {400, estimator == EstimatorName::fluctuation ? 900 : 160};
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0).transport;
}

}  // namespace

TEST_CASE("under loads that lean by two degrees fluctuations, many loads and one find the same response", "[long]") {
  const Transport by_fluctuations = response_under(2, EstimatorName::fluctuation, 1024),
                  by_loads = response_under(2, EstimatorName::multiplexed, 2048),
                  by_one_load = response_under(2, EstimatorName::point, 8192);
  const auto distance = [](const Estimate& one, const Estimate& other) {
    return std::abs(one.value - other.value) / std::hypot(one.standard_error, other.standard_error);
  };
  REQUIRE(by_fluctuations.c.known());
  REQUIRE(by_loads.c.known());
  REQUIRE(by_one_load.c.known());
  CAPTURE(by_fluctuations.c.value, by_loads.c.value, by_one_load.c.value);
  CAPTURE(by_fluctuations.D.value, by_loads.D.value, by_one_load.D.value);
  CHECK(by_loads.c.standard_error < 0.0004);
  CHECK(by_fluctuations.c.standard_error < 0.0002);
  CHECK(by_loads.D.standard_error < 0.03 * by_loads.D.value);
  CHECK(by_fluctuations.D.standard_error < 0.01 * by_loads.D.value);
  CHECK(distance(by_fluctuations.c, by_loads.c) < 4);
  CHECK(distance(by_fluctuations.D, by_loads.D) < 4);
  // An overload of 1 is not small: c is some thousandths larger, as under upright loads.
  CHECK(std::abs(by_one_load.c.value - by_loads.c.value) < 0.005);
  CHECK(std::abs(by_one_load.D.value / by_loads.D.value - 1) < 0.2);
  CHECK(by_one_load.alpha_thrust.value == Approx(by_loads.alpha_thrust.value).margin(3e-4));
  // Leaning loads raise the thrust of saturated layers by kappa_hh h^2/2, kappa_hh = 0.696(26) (the study mode_coupling
  // of examples/spreading.toml).
  const Transport upright = response_under(0, EstimatorName::fluctuation, 1024);
  const double more = by_fluctuations.alpha_thrust.value - upright.alpha_thrust.value;
  const double error = std::hypot(by_fluctuations.alpha_thrust.standard_error, upright.alpha_thrust.standard_error);
  const double h = std::tan(2 * std::numbers::pi / 180);
  CAPTURE(more, error);
  CHECK(error < 1e-4);
  CHECK(std::abs(more - 0.696 * h * h / 2) < 4 * error);
}

TEST_CASE("under loads that lean by eight degrees the mirror images lie apart, and that is said", "[long]") {
  const Transport t = response_under(8, EstimatorName::fluctuation, 256);
  CHECK_FALSE(t.c.known());
  CHECK(t.c.reason.find("another shape") != std::string::npos);
  CHECK(t.alpha_thrust.known());
}
