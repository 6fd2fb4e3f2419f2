// Source: independent piles are worth as many as they are; a chain stopped after each sweep is worth fewer.
#include "analysis/jackknife.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "kit/small_piles.h"

using namespace granuscope;
using test::chained_piles;
using test::piles_of;

TEST_CASE("Independent piles count in full, those of a chain hardly left to run count less") {
  const auto independent = effective_samples(run_ensemble(piles_of(Law::granusolve), 1, nullptr).sums);
  REQUIRE(independent.known());
  CAPTURE(independent.value, independent.standard_error);
  CHECK(std::abs(independent.value - 2048) < 5 * independent.standard_error);
  const auto chained = effective_samples(run_ensemble(chained_piles(1, 2048), 1, nullptr).sums);
  REQUIRE(chained.known());
  CAPTURE(chained.value, chained.standard_error);
  CHECK(chained.value + 5 * chained.standard_error < 2048);
}

TEST_CASE("What a chain ran for is kept with the main results") {
  EnsembleSpec spec = chained_piles(3, 256);
  spec.load = Load::point;
  spec.record_profiles = true;
  spec.lattice = {16, 28};
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = 4;
  fit.last_layer = 7;
  fit.layer_step = 1;
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
