// What is estimated is held against the processor time of the same ensemble, drawn by the same program on the same
// core.
#include "ensemble/ensemble_runner.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "kit/sanitized.h"
#include "sampling/polytope.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

using enum EstimatorName;

EnsembleSpec ensemble(Law law, double mu, LatticeSpec lattice, std::uint64_t samples, EstimatorName estimator = point) {
  EnsembleSpec spec;
  spec.sampler.law = law;
  spec.sampler.mu = mu;
  spec.lattice = lattice;
  spec.response.samples = samples;
  spec.response.blocks = 8;
  spec.response.estimator = estimator;
  return spec;
}

double real_seconds(const EnsembleSpec& spec) {
  const double start = processor_seconds();
  const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
  REQUIRE_FALSE(record.sums.layers.empty());
  return processor_seconds() - start;
}

/// By which factor the forecast is off, upwards or downwards.
double off_by(const EnsembleSpec& spec, double seconds) {
  const TimeEstimate time = estimate_time(spec, seconds);
  CHECK_FALSE(time.at_least);
  const double estimated = time.on_threads(spec.response.samples, 1), real = real_seconds(spec);
  CAPTURE(name_of(spec.sampler.law), spec.sampler.mu, estimated, real);
  CHECK(estimated > 0);
  return std::exp(std::abs(std::log(estimated / real)));
}

TEST_CASE("the time of an ensemble is estimated within a factor of two, whatever the estimator and the friction",
          "[unsanitized]") {
  const LatticeSpec lattice{120, 60};
  CHECK(off_by(ensemble(Law::granusolve, 0.02, lattice, 512), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 1.5, lattice, 256), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 1.5, lattice, 96, paired), 0.1) < 2);
  CHECK(off_by(ensemble(Law::granusolve, 0.3, lattice, 256, multiplexed), 0.1) < 2);
  // Deeper than what is tried.
  CHECK(off_by(ensemble(Law::granusolve, 0.3, {64, 4000}, 64), 0.1) < 2);
  EnsembleSpec deep = ensemble(Law::granusolve, 0.05, {1632, 700}, 64, multiplexed);
  for (int layer = 0; layer < 100; ++layer) deep.layers.push_back(7 * layer);
  CHECK(off_by(deep, 0.1) < 2);
}

TEST_CASE("the time of the laws of tiny piles is estimated from piles that are given up early", "[unsanitized]") {
  CHECK(off_by(ensemble(Law::rejection, 0.3, {6, 6}, 8000), 0.1) < 2);
  CHECK(off_by(ensemble(Law::rejection, 0.3, {6, 12}, 256), 0.2) < 2);
  CHECK(off_by(ensemble(Law::eloy_clement, 0.3, {12, 12}, 512), 0.2) < 2);
}

TEST_CASE("the time of chains is estimated from their sweeps, stated or measured, and the pilot's", "[unsanitized]") {
  EnsembleSpec chains = ensemble(Law::polytope, 0.3, {16, 16}, 64);
  chains.sampler.burn_in = 300;
  chains.sampler.thinning = 40;
  CHECK(off_by(chains, 0.05) < 2);
  chains.response.estimator = multiplexed;
  chains.response.opposite = true;  // two chains for each pair
  CHECK(off_by(chains, 0.05) < 2);
  CHECK(estimate_time(chains, 0.05).once == 0);

  const EnsembleSpec measured = ensemble(Law::polytope, 0.3, {6, 6}, 64);
  const double enough = test::sanitized ? 5 : 0.2;  // seconds
  const TimeEstimate time = estimate_time(measured, enough);
  const std::vector<double> load(6, 1.0);
  CHECK(time.once > 0);
  CHECK(off_by(measured, enough) < 2.5);  // a pilot a fifth as long knows the time to less than a factor of two
}

TEST_CASE(
    "a pilot too short to see the slow waves says that it may take longer, and by the size of the pile how much") {
  const EnsembleSpec wide = ensemble(Law::polytope, 0.3, {32, 40}, 256);
  const double start = processor_seconds();
  const TimeEstimate time = estimate_time(wide, 0.05);
  CHECK(processor_seconds() - start < 2);
  CHECK(time.at_least);
  // From that pilot alone it would be some seconds.
  CHECK(time.on_threads(256, 1) > 60);
  CHECK(time.on_threads(256, 8) > time.once);
  CHECK(time.on_threads(256, 8) < time.on_threads(256, 1));
}

TEST_CASE("a law that completes nothing in the time given for the trial is estimated from below") {
  const EnsembleSpec unfinished = ensemble(Law::rejection, 1.0, {8, 16}, 256);
  const TimeEstimate time = estimate_time(unfinished, 0.1);
  CHECK(time.at_least);
  CHECK(time.per_sample > 0.01);  // of the tenth of a second the last trial took a good part, without one pile
}

}  // namespace
}  // namespace granuscope
