// Source of the expectation: the thrust of a mean pile is homogeneous of degree one in the loads and every column
// counts the same, so that the thrust of the linear response is the thrust ratio of the piles, in any law that both
// piles of a pair follow. A law that does not repair has such pairs; granusolve has not.
#include "analysis/scaling.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/mean_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;
using Catch::Matchers::Contains;

namespace {

EnsembleSpec pairs(double mu, double overload) {
  EnsembleSpec spec;
  spec.response.estimator = EstimatorName::paired;
  spec.sampler.mu = mu;
  spec.sampler.seed = 77;
  spec.lattice = {.columns = 80, .layers = 60};
  spec.response.overload = overload;
  spec.response.samples = 256;
  spec.response.blocks = 16;
  return spec;
}

/// Mean over the recorded layers from the tenth on.
Replicated mean_deep(const EnsembleRecord& record, const std::string& quantity) {
  std::vector<Replicated> layers;
  for (std::size_t row = 10; row < record.sums.layers.size(); ++row) {
    if (record.sums.layers[row] < 40) layers.push_back(block_mean(record.sums, quantity, row));
  }
  return mean_of(layers);
}

}  // namespace

TEST_CASE("pairs of granusolve: numbers that were kept change the law by as much under every overload",
          "[unsanitized]") {
  std::vector<Estimate> changes;
  for (const double overload : {0.25, 1.0, 4.0}) {
    const EnsembleRecord record = run_ensemble(pairs(0.3, overload), 0, nullptr);
    const Replicated response = mean_deep(record, "response_thrust"), piles = mean_deep(record, "thrust");
    changes.push_back(estimate(transform([&](double a, double b) { return overload * (a - b); }, response, piles)));
    INFO("overload " << overload << ": " << changes.back().value << " +- " << changes.back().standard_error);
    CHECK(changes.back().value < -10 * changes.back().standard_error);
    CHECK(changes.back().standard_error > 0);
    const std::string reason = reason_against_pairs(response, piles);
    CHECK_THAT(reason, Contains("another law"));
  }
  // Divided by the overload it is what stands beside the response. A larger overload reaches a little farther.
  for (const Estimate& change : changes) CHECK(change.value / changes[1].value == Approx(1).margin(0.35));
}

TEST_CASE("pairs of granusolve have no c and D, by name, and every depth says why") {
  EnsembleSpec spec = pairs(0.2, 1);
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 26;
  fit.last_layer = 38;
  spec.layers = layers_to_record(fit, {});
  const MeasuredEnsemble ensemble{spec, run_ensemble(spec, 0, nullptr)};
  const Transport t = measure_transport(ensemble, fit, {}, 0).transport;
  CHECK_FALSE(t.c.known());
  CHECK_FALSE(t.D.known());
  CHECK_THAT(t.c.reason, Contains("another law"));
  CHECK_THAT(t.D.reason, Contains("another law"));
  CHECK(t.c_thrust.known());  // of the first piles, which follow the law
  REQUIRE(t.depths.size() == 5);
  for (const DepthFit& depth : t.depths) {
    CHECK_FALSE(depth.identifiable);
    CHECK_THAT(depth.reason, Contains("another law"));
  }
}

TEST_CASE("pairs of one law are not refused: a chain run once more, and piles without friction", "[unsanitized]") {
  EnsembleSpec chain = pairs(0.3, 1);
  chain.sampler.law = Law::polytope;
  chain.sampler.burn_in = 200;
  chain.sampler.thinning = 100;
  chain.lattice = {.columns = 8, .layers = 30};
  const EnsembleRecord record = run_ensemble(chain, 0, nullptr);
  const Replicated response = mean_deep(record, "response_thrust"), piles = mean_deep(record, "thrust");
  CAPTURE(response.value, estimate(response).standard_error, piles.value);
  CHECK(reason_against_pairs(response, piles).empty());
  const EnsembleRecord exact = run_ensemble(pairs(0, 1), 0, nullptr);
  const Replicated straight = mean_deep(exact, "response_thrust");
  CHECK(straight.value == Approx(1).epsilon(1e-12));
  CHECK(reason_against_pairs(straight, mean_deep(exact, "thrust")).empty());
}

TEST_CASE("a thrust that is unknown is a reason, too") {
  const Replicated known{0.9, {0.9, 0.91, 0.89}}, unknown{std::nan(""), {0.9, 0.9, 0.9}};
  CHECK_THAT(reason_against_pairs(unknown, known), Contains("unknown"));
  CHECK(reason_against_pairs(known, known).empty());
}
