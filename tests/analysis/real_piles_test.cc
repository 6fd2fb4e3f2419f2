#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/scaling.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "model/lattice.h"

using namespace granuscope;

namespace {

/// 500 x 200 beads, overload 1 on a uniform load of 1, 3461 samples, slopes over layers 58 to 179; one standard error.
/// Numbers on record: the independent implementation that printed them (two throw-away codes in agreement) is not in
/// the repository. c_thrust is computed anew by a second implementation in tests/ensemble/thrust_test.cc.
struct IndependentResult {
  double mu;
  double c, c_error;
  double D, D_error;
  double c_thrust;  ///< to all printed digits
};
constexpr IndependentResult independent[] = {{0.1, 0.5748, 0.0002, 0.0048, 0.0003, 0.5748},
                                             {0.2, 0.5690, 0.0006, 0.0257, 0.0012, 0.5674},
                                             {0.3, 0.5600, 0.0010, 0.078, 0.005, 0.5560}};
constexpr double half_unit = 0.5e-4;  ///< of the last printed digit of c_thrust
constexpr std::uint64_t seed = 4711;

MeasuredTransport measure(double mu, const FitSpec& fit) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = seed;
  spec.response.samples = 3456;
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0);
}

}  // namespace

TEST_CASE("c, D, c_thrust and beta of real piles agree with an independent implementation", "[long]") {
  const FitSpec fit;
  std::vector<MeasuredTransport> results;
  for (const IndependentResult& expected : independent) {
    results.push_back(measure(expected.mu, fit));
    const Transport& t = results.back().transport;
    CAPTURE(seed, expected.mu, t.c.value, t.c.standard_error, t.D.value, t.D.standard_error, t.c_thrust.value);
    REQUIRE(t.c.known());
    CHECK(t.failed.empty());
    CHECK(std::abs(t.c.value - expected.c) <= 3 * std::hypot(t.c.standard_error, expected.c_error));
    CHECK(std::abs(t.D.value - expected.D) <= 3 * std::hypot(t.D.standard_error, expected.D_error));
    CHECK(std::abs(t.c_thrust.value - expected.c_thrust) <= 3 * t.c_thrust.standard_error + half_unit);
    // The comparison must be able to tell: errors no larger than those of the other code.
    CHECK(t.c.standard_error <= 1.5 * expected.c_error);
    CHECK(t.D.standard_error <= 1.5 * expected.D_error);
  }
  results.push_back(measure(0.15, fit));
  const ScalingFit beta = fit_scaling(results, {0.1, 0.3}).beta;
  CAPTURE(beta.exponent.value, beta.exponent.standard_error);
  CHECK(beta.points == 4);
  CHECK(beta.exponent.standard_error <= 0.15);
  // The paper's 2.5 and the independent implementation's 2.5, to half a unit of the last digit.
  CHECK(std::abs(beta.exponent.value - 2.5) <= 3 * std::hypot(beta.exponent.standard_error, 0.05));
}
