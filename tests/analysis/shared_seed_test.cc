// Friction coefficients of one experiment share their random numbers. Exponents are fitted across them, so what that
// does to their errors must be known.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

MeasuredTransport measure(double mu, std::uint64_t seed) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = seed;
  spec.response.samples = 1024;
  spec.lattice = {120, 90};
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 29;
  fit.last_layer = 69;
  fit.min_identifiable_width = 0.1;
  spec.layers = layers_to_record(fit, {});
  return measure_transport({spec, run_ensemble(spec, 0, nullptr)}, fit, {}, 0);
}

double variance(const Replicated& number) { return std::pow(estimate(number).standard_error, 2); }

/// Of two numbers over their common blocks. One of 32 blocks is known to 0.18 or better.
double correlation(const Replicated& a, const Replicated& b) {
  const Replicated sum = transform([](double p, double q) { return p + q; }, a, b);
  return (variance(sum) - variance(a) - variance(b)) / (2 * std::sqrt(variance(a) * variance(b)));
}

}  // namespace

TEST_CASE("the blocks of one seed carry what friction coefficients share, and nothing else does", "[long]") {
  // Point loads at mu = 0.1 and 0.15. Deeper piles have 0.48(2) for D and 0.56(2) for c.
  constexpr int seeds = 24;
  double shared_D = 0, shared_c = 0, other_D = 0, other_c = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const MeasuredTransport low = measure(0.1, seed), high = measure(0.15, seed), other = measure(0.15, 1000 + seed);
    REQUIRE(low.transport.D.known());
    shared_D += correlation(low.D, high.D) / seeds;
    shared_c += correlation(low.c, high.c) / seeds;
    other_D += correlation(low.D, other.D) / seeds;
    other_c += correlation(low.c, other.c) / seeds;
  }
  const double error = 1 / std::sqrt(31.0 * seeds);
  CAPTURE(shared_D, shared_c, other_D, other_c, error);
  CHECK(shared_D > 0.25);
  CHECK(shared_c > 0.25);
  CHECK(std::abs(other_D) < 5 * error);
  CHECK(std::abs(other_c) < 5 * error);
}
