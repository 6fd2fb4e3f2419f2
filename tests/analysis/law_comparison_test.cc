// Sources: independent piles are worth as many as they are; a chain stopped after each sweep is worth fewer. The top
// layer's variance of the weights under a uniform load is 0, and rejection on 6 x 6 beads has known values elsewhere
// (tests/sampling/rejection_test.cc): here only the bookkeeping is held.
#include "analysis/law_comparison.h"
#include "analysis/transport.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/effective_samples.h"
#include "ensemble/ensemble_runner.h"

using namespace granuscope;

namespace {

EnsembleSpec piles_of(Law law) {
  EnsembleSpec spec;
  spec.sampler.law = law;
  spec.sampler.mu = 0.3;
  spec.lattice = {6, 6};
  spec.load = Load::uniform;
  spec.record_profiles = false;
  spec.response.samples = 2048;
  spec.response.blocks = 32;
  return spec;
}

}  // namespace

TEST_CASE("Independent piles count in full, those of a chain hardly left to run count less") {
  const auto independent = effective_samples(run_ensemble(piles_of(Law::granusolve), 1, nullptr).sums);
  REQUIRE(independent.known());
  CAPTURE(independent.value, independent.standard_error);
  CHECK(std::abs(independent.value - 2048) < 5 * independent.standard_error);
  EnsembleSpec spec = piles_of(Law::polytope);
  spec.sampler.burn_in = 50;
  spec.sampler.thinning = 1;
  const auto chained = effective_samples(run_ensemble(spec, 1, nullptr).sums);
  REQUIRE(chained.known());
  CAPTURE(chained.value, chained.standard_error);
  CHECK(chained.value + 5 * chained.standard_error < 2048);
}

TEST_CASE("The comparison of laws keeps each law's name, size, work and its means over the middle third") {
  EnsembleSpec spec = piles_of(Law::granusolve);
  spec.response.samples = 512;
  spec.sampler.rules = MendingRules::no_pair;
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  const LawOnPiles measured = measure_law({spec, record});
  CHECK(configuration_text(measured.spec) == configuration_text(spec));
  CHECK(measured.samples == 512);
  CHECK(measured.failed == 0);
  CHECK(measured.pair_per_bead == 0);
  CHECK(measured.arc_per_bead > 0);
  CHECK(measured.draws_per_bead > 1);
  REQUIRE(measured.depths.size() == 6);
  CHECK(measured.depths.front().weight_variance.value == Approx(0).margin(1e-12));
  CHECK(measured.first_layer == 2);
  CHECK(measured.last_layer == 3);
  CHECK(measured.alpha_thrust.value ==
        Approx((measured.depths[2].thrust_ratio.value + measured.depths[3].thrust_ratio.value) / 2));
  CHECK(measured.c_thrust.value == Approx(std::sqrt(measured.alpha_thrust.value / 3)));
  CHECK(measured.weight_variance.value ==
        Approx((measured.depths[2].weight_variance.value + measured.depths[3].weight_variance.value) / 2));
}

TEST_CASE("What a chain ran for is kept with its piles, for one law and for main results") {
  EnsembleSpec spec = piles_of(Law::polytope);
  spec.response.samples = 256;
  spec.sampler.burn_in = 50;
  spec.sampler.thinning = 3;
  const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
  const LawOnPiles measured = measure_law({spec, record});
  CHECK(measured.burn_in == 50);
  CHECK(measured.thinning == 3);
  const LawOnPiles without_chain = measure_law({piles_of(Law::granusolve), record});
  CHECK(std::isnan(without_chain.burn_in));

  spec.load = Load::point;
  spec.record_profiles = true;
  spec.lattice = {16, 28};
  FitSpec fit = law_response_fit(spec.lattice);
  spec.layers = layers_to_record(fit, {});
  MeasuredEnsemble ensemble{spec, run_ensemble(spec, 2, nullptr)};
  const Transport main_result = measure_transport(ensemble, fit, {}, 1).transport;
  CHECK(main_result.chained);
  CHECK(main_result.burn_in == 50);
  CHECK(main_result.thinning == 3);
  CHECK(main_result.effective_samples.known());
  ensemble.record.counts.chains = 0;
  CHECK_FALSE(measure_transport(ensemble, fit, {}, 1).transport.chained);
}

// Source: c and D of multiplexed_response_test.cc at this friction (0.558 and 0.082 over deep layers, numbers on
// record); near the top the slopes differ from those by a few percent and some tens of percent.
TEST_CASE("The response under a law has its slopes over the layers between the top and the bottom margin") {
  EnsembleSpec spec = piles_of(Law::granusolve);
  spec.load = Load::point;
  spec.response.estimator = EstimatorName::multiplexed;
  spec.response.epsilon = 0.5;
  spec.record_profiles = true;
  spec.lattice = {24, 27};
  spec.layers = layers_to_record(law_response_fit(spec.lattice), {});
  const LawResponse response = measure_law_response({spec, run_ensemble(spec, 2, nullptr)}, 1);
  CHECK(configuration_text(response.spec) == configuration_text(spec));
  CHECK(response.first_layer == 4);
  CHECK(response.last_layer == 6);
  REQUIRE(response.c.known());
  CAPTURE(response.c.value, response.c.standard_error, response.D.value, response.D.standard_error);
  CHECK(std::abs(response.c.value - 0.558) < 0.02 + 5 * response.c.standard_error);
  CHECK(response.c.standard_error < 0.006);
  CHECK(std::abs(response.D.value - 0.082) < 0.03 + 5 * response.D.standard_error);
  CHECK(response.D.standard_error < 0.015);
}
