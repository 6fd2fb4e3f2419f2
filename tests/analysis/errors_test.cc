// Errors: jackknife, effective samples, error against time, precision, and what shared numbers do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "analysis/precision.h"
#include "analysis/scaling.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/estimator.h"
#include "kit/small_piles.h"
#include "sampling/sampler.h"
#include "storage/block_sums.h"

namespace granuscope {
namespace {

using Catch::Matchers::Contains;
using test::chained_piles;
using test::piles_of;

}  // namespace

namespace {

/// Replicates of a mean over blocks of equal size.
Replicated mean_of_blocks(const std::vector<double>& blocks) {
  double total = 0;
  for (double b : blocks) total += b;
  Replicated mean{total / static_cast<double>(blocks.size()), {}};
  for (double b : blocks) mean.without_block.push_back((total - b) / static_cast<double>(blocks.size() - 1));
  return mean;
}

}  // namespace

TEST_CASE("the jackknife error of a mean is the textbook one") {
  // s / sqrt(B) with s the sample standard deviation: algebra.
  const std::vector<double> blocks{1, 4, 2, 8, 5, 7, 1, 3};
  double mean = 0, square = 0;
  for (double b : blocks) mean += b / 8;
  for (double b : blocks) square += (b - mean) * (b - mean);
  const Estimate e = estimate(mean_of_blocks(blocks));
  CHECK(e.value == Approx(mean).epsilon(1e-14));
  CHECK(e.standard_error == Approx(std::sqrt(square / 7 / 8)).epsilon(1e-13));
}

TEST_CASE("an error knows that its arguments are correlated") {
  const Replicated a = mean_of_blocks({1, 4, 2, 8, 5, 7, 1, 3});
  const Replicated difference = transform([](double x, double y) { return x - y; }, a, a);
  CHECK(estimate(difference).standard_error == 0.0);
  const Replicated twice = transform([](double x, double y) { return x + y; }, a, a);
  CHECK(estimate(twice).standard_error == Approx(2 * estimate(a).standard_error).epsilon(1e-13));
}

TEST_CASE("equal replicates have an error of exactly zero") {
  const Replicated constant{0.57735026918962576, std::vector<double>(32, 0.57735026918962576)};
  CHECK(estimate(constant).standard_error == 0.0);
}

TEST_CASE("a replicate that is not finite makes the number unknown, with the reason") {
  Replicated a = mean_of_blocks({1, 4, 2, 8, 5, 7, 1, 3});
  a.without_block[3] = std::numeric_limits<double>::quiet_NaN();
  const Estimate e = estimate(a, "no such thing");
  CHECK_FALSE(e.known());
  CHECK(e.reason == "no such thing");
}

TEST_CASE("the jackknife error of a nonlinear function covers as stated") {
  // exp(mean) of 32 Gaussian blocks, 4000 times: the 68.3 % interval must hold 68.3 +- 5 %.
  std::mt19937_64 generator(20260101);
  std::normal_distribution<double> normal(0.0, 0.3);
  int covered = 0;
  constexpr int repetitions = 4000;
  for (int r = 0; r < repetitions; ++r) {
    std::vector<double> blocks(32);
    for (double& b : blocks) b = normal(generator);
    const Estimate e = estimate(transform([](double m) { return std::exp(m); }, mean_of_blocks(blocks)));
    covered += std::abs(e.value - 1) <= e.standard_error;
  }
  CHECK(covered / double{repetitions} == Approx(0.683).margin(0.05));
}

// Source: independent piles are worth as many as they are; a chain stopped after each sweep is worth fewer.

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

namespace {

/// Of each `blocks` blocks of an ensemble, its chance under the flat law.
std::vector<double> flat_chances(const BlockSums& sums, std::size_t blocks) {
  std::vector<double> chances;
  for (std::size_t first = 0; first + blocks <= sums.count.size(); first += blocks)
    chances.push_back(test_flat_law(take_blocks(sums, first, blocks)).chance);
  std::ranges::sort(chances);
  return chances;
}

EnsembleSpec flat_piles(LatticeSpec lattice, int blocks, std::uint64_t chains_of_block, std::uint64_t burn_in) {
  EnsembleSpec spec = piles_of(Law::polytope, 0.3, lattice, 8 * chains_of_block * static_cast<std::uint64_t>(blocks));
  spec.response.blocks = blocks;
  spec.sampler.lambda = 0;
  spec.sampler.burn_in = burn_in;
  spec.sampler.thinning = 3;
  return spec;
}

}  // namespace

// Source: the law of the test itself; the same piles, weighed otherwise or not yet forgetful, are another law's.

TEST_CASE("Chances of the flat law's test are uniform for its piles, though those of a chain depend on each other",
          "[unsanitized]") {
  constexpr int repetitions = 100;
  const std::vector<double> chances =
      flat_chances(run_ensemble(flat_piles({5, 5}, 16 * repetitions, 2, 100), 2, nullptr).sums, 16);
  REQUIRE(chances.size() == repetitions);
  double distance = 0;  // of Kolmogorov and Smirnov
  for (std::size_t i = 0; i < chances.size(); ++i) {
    const auto n = static_cast<double>(chances.size()), at = static_cast<double>(i);
    distance = std::max({distance, std::abs(chances[i] - at / n), std::abs(chances[i] - (at + 1) / n)});
  }
  CAPTURE(distance, chances.front(), chances.back());
  CHECK(distance * std::sqrt(1.0 * repetitions) < 1.63);  // 1 %
}

TEST_CASE("The flat law's test sees piles of another law, chains that drift, and an incomplete chain") {
  const EnsembleSpec spec = flat_piles({5, 5}, 16, 4, 100);
  SamplerSpec weighed = spec.sampler;  // by the lengths of its beads' intervals
  weighed.lambda = 1;
  const auto sampler = make_sampler(weighed, Lattice(spec.lattice));
  BlockSums sums = begin_ensemble(spec).sums;
  Pile pile{Lattice(spec.lattice)};
  for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
    const int block = static_cast<int>(sample / group_size) % 16;
    REQUIRE_FALSE(sampler->draw(sample, top_load(spec), pile));
    LayerObservables(spec, sums, block).add(pile);
    ++sums.count[static_cast<std::size_t>(block)];
  }
  const FlatTest other = test_flat_law(sums);
  CAPTURE(other.chance, other.means[0].value, other.means[0].standard_error);
  CHECK(other.chance < 1e-6);
  CHECK(other.all_zero.degrees_of_freedom == 5);
  // A ring whose longest wave takes some 40 sweeps to come up from the start.
  const FlatTest drifts = test_flat_law(run_ensemble(flat_piles({48, 40}, 16, 2, 1), 2, nullptr).sums);
  for (const Estimate& mean : drifts.means) UNSCOPED_INFO(mean.value << " +- " << mean.standard_error);
  CAPTURE(drifts.chance);
  CHECK(drifts.chance < 1e-4);
  EnsembleSpec incomplete = flat_piles({5, 5}, 16, 2, 10);
  incomplete.response.samples -= 3;
  CHECK(std::isnan(test_flat_law(run_ensemble(incomplete, 1, nullptr).sums).chance));
  CHECK(test_flat_law(run_ensemble(piles_of(Law::granusolve), 1, nullptr).sums).means.empty());
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

// Source of the expected numbers: the law of errors, 1/sqrt(N), and block means drawn from a normal distribution, for
// which the truth is 0.

namespace {

Transport with_errors(double c, double D) {
  Transport transport;
  transport.c = {0.55, c, ""};
  transport.D = {0.08, D, ""};
  return transport;
}

/// The delete-one jackknife of a mean of block means.
Estimate estimate_of(const std::vector<double>& sums, double rounds) {
  const auto blocks = static_cast<double>(sums.size());
  double total = 0;
  for (const double sum : sums) total += sum;
  Replicated mean{total / (blocks * rounds), {}};
  for (const double sum : sums) mean.without_block.push_back((total - sum) / ((blocks - 1) * rounds));
  return estimate(mean);
}

}  // namespace

TEST_CASE("an ensemble is precise once both errors are, and says how many piles that takes") {
  PrecisionSpec asked;
  CHECK_FALSE(asked.asked());
  asked.c = 1e-4;
  asked.D = 1e-3;
  CHECK(asked.asked());
  CHECK(look_at_precision(asked, with_errors(0.96e-4, 0.96e-3), 1000).reached);
  const PrecisionLook look = look_at_precision(asked, with_errors(2e-4, 3e-3), 1000);
  CHECK_FALSE(look.reached);
  CHECK_FALSE(look.unattainable);
  constexpr double square = 1.0387 * 1.0387;  // of the 32 blocks that a Transport has unless told otherwise
  CHECK(look.samples_needed == Approx(9000 * square).epsilon(1e-3));
  asked.D = 0;  // c alone
  CHECK(look_at_precision(asked, with_errors(2e-4, 3e-3), 1000).samples_needed == Approx(4000 * square).epsilon(1e-3));
  CHECK(look_at_precision(asked, with_errors(0.96e-4, 1), 1000).reached);
  Transport unknown = with_errors(1e-5, 1e-5);
  unknown.c = {};
  unknown.c.reason = "too narrow";
  const PrecisionLook unattainable = look_at_precision(asked, unknown, 1000);
  CHECK_FALSE(unattainable.reached);
  CHECK(unattainable.unattainable);
  CHECK(unattainable.reason == "c is unknown: too narrow");
}

TEST_CASE("the sizes at which an ensemble is looked at grow by half") {
  CHECK(next_size(1) == 2);
  CHECK(next_size(2) == 3);
  CHECK(next_size(3) == 5);
  CHECK(next_size(100) == 150);
}

TEST_CASE("an ensemble is expected to stop at the first step that is large enough, or at the last one allowed") {
  CHECK(expected_size(8, 8, 100) == 8);
  CHECK(expected_size(8, 8.1, 100) == 12);
  CHECK(expected_size(8, 18.5, 100) == 27);  // 8, 12, 18, 27
  CHECK(expected_size(8, 1e9, 100) == 93);   // 41, 62, 93, and 140 is too much
}

TEST_CASE("how many piles are needed is estimated from the fall of the error") {
  // Many small ensembles, each looked at once, estimate the size at which the error is a tenth of what it is.
  constexpr int blocks = 32, trials = 2000, rounds = 4;
  const std::uint64_t seed = 1961;
  CAPTURE(seed);
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  PrecisionSpec asked;
  asked.c = 0.1 / std::sqrt(blocks * rounds);  // of unit normal numbers: a hundred times as many
  double estimated = 0, squares = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> sums(blocks);
    for (double& one : sums) one = std::sqrt(rounds) * normal(generator);
    Transport measured = with_errors(0, 0);
    measured.c = estimate_of(sums, rounds);
    const double times = look_at_precision(asked, measured, rounds).samples_needed / (100.0 * rounds);
    estimated += times / trials;
    squares += times * times / trials;
  }
  // The variance from 32 blocks has a relative error of sqrt(2/31) = 0.254; five standard errors of 2000 trials.
  CHECK(estimated / std::pow(stopped_scatter(blocks), 2) == Approx(1).margin(5 * 0.254 / std::sqrt(trials)));
  CHECK(std::sqrt(squares - estimated * estimated) == Approx(0.254).margin(0.03));
}

TEST_CASE("expected errors fall with the root of the number of piles and of the load") {
  const ExpectedErrors point = expected_errors(0.3, false, 1, 500, 3461);
  CHECK(point.c == Approx(0.0010).epsilon(0.5));  // measured on 500 x 200 beads
  CHECK(point.D == Approx(0.0050).epsilon(0.5));
  CHECK(expected_errors(0.3, false, 0.5, 500, 4 * 3461).D == Approx(point.D));
  const ExpectedErrors multiplexed = expected_errors(0.3, true, 0.25, 500, 1500);
  CHECK(multiplexed.c < 0.5 * point.c);
  CHECK(expected_errors(0.3, true, 0.25, 250, 3000).c == Approx(multiplexed.c));
}

TEST_CASE("errors that were looked at until they were small are errors one can bet on") {
  constexpr int trials = 1000, sizes = 12;
  const std::uint64_t seed = 20021;
  CAPTURE(seed);
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  for (const int blocks : {8, 32}) {
    const double factor = stopped_scatter(blocks);
    double covered = 0, sum = 0, stated = 0;
    for (int size = 0; size < sizes; ++size) {
      const double rounds_needed = 4 * std::pow(9.0, static_cast<double>(size) / sizes);
      PrecisionSpec asked;
      asked.c = 1 / std::sqrt(blocks * rounds_needed);
      for (int trial = 0; trial < trials; ++trial) {
        std::vector<double> sums(static_cast<std::size_t>(blocks));
        std::uint64_t rounds = 0, next = 1;
        Transport measured = with_errors(0, 0);
        measured.spec.response.blocks = blocks;
        do {
          for (double& one : sums) one += std::sqrt(static_cast<double>(next - rounds)) * normal(generator);
          rounds = next;
          next = next_size(rounds);
          measured.c = estimate_of(sums, static_cast<double>(rounds));
        } while (!look_at_precision(asked, measured, rounds).reached);
        const double error = factor * measured.c.standard_error;
        covered += std::abs(measured.c.value) < error ? 1.0 / (trials * sizes) : 0;
        sum += measured.c.value / error / (trials * sizes);
        stated += error * std::sqrt(blocks * static_cast<double>(rounds)) / (trials * sizes);
      }
    }
    CAPTURE(blocks, covered, sum, stated);
    // 12 000 trials: 0.0042 of coverage, 0.009 of the mean. Student's distribution has 65 % and 67.5 % within one error
    // of 8 and 32 blocks, and a mean stated error that is the true one covers a little more than its median.
    CHECK(covered == Approx(blocks == 8 ? 0.658 : 0.680).margin(5 * 0.0042));
    CHECK(std::abs(sum) < 5 * 0.009);
    CHECK(stated == Approx(1).margin(0.01));
  }
}

TEST_CASE("blocks moved apart say the same with larger errors") {
  // Sums of 2, 4 and 2 samples of mean 3: 2.5, 3.25 and 3.
  BlockSums sums;
  sums.layers = {7};
  sums.count = {2, 4, 2};
  sums.quantities["thrust"] = {1, {5, 13, 6}, {0, 0, 0}};
  sums.scatter = 2;
  const LayerSums apart = sums.layer("thrust", 0);
  CHECK(*apart.block(0) == Approx(4));   // mean 2
  CHECK(*apart.block(1) == Approx(14));  // mean 3.5
  CHECK(*apart.block(2) == Approx(6));
}

// Source of the expectation: the thrust of a mean pile is homogeneous of degree one in the loads and every column
// counts the same, so that the thrust of the linear response is the thrust ratio of the piles, in any law that both
// piles of a pair follow. A law that does not repair has such pairs; granusolve has not.

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

// Friction coefficients of one experiment share their random numbers. Exponents are fitted across them, so what that
// does to their errors must be known.

namespace {

MeasuredTransport measured_by_seed(double mu, std::uint64_t seed) {
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
    const MeasuredTransport low = measured_by_seed(0.1, seed), high = measured_by_seed(0.15, seed),
                            other = measured_by_seed(0.15, 1000 + seed);
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

}  // namespace granuscope
