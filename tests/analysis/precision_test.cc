// Source of the expected numbers: the law of errors, 1/sqrt(N), and block means drawn from a normal distribution, for
// which the truth is 0.
#include "analysis/precision.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>

#include "analysis/jackknife.h"
#include "storage/block_sums.h"

using namespace granuscope;

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
