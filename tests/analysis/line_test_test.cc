// chi^2 of points about a line: right on average whatever the points share, and honest about what it cannot tell.
#include "analysis/jackknife.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/scaling.h"

using namespace granuscope;

namespace {

/// Points on a line, or with a curvature, each the mean of `blocks` block means; neighbours are correlated by `shared`,
/// the further apart the less, and the last one scatters five times as much as the first.
std::vector<Replicated> noisy_line(const std::vector<double>& x, int blocks, double shared, std::mt19937_64& random,
                                   double curvature = 0) {
  std::normal_distribution<double> normal;
  const std::size_t points = x.size();
  std::vector<std::vector<double>> block_means(points);
  for (int b = 0; b < blocks; ++b) {
    double noise = normal(random);
    for (std::size_t i = 0; i < points; ++i) {
      if (i > 0) noise = shared * noise + std::sqrt(1 - shared * shared) * normal(random);
      const double size = 0.1 * (1 + 4 * static_cast<double>(i) / static_cast<double>(points - 1));
      block_means[i].push_back(1 + 2 * x[i] + curvature * x[i] * x[i] + size * noise);
    }
  }
  std::vector<Replicated> y(points);
  for (std::size_t i = 0; i < points; ++i) {
    double sum = 0;
    for (const double mean : block_means[i]) sum += mean;
    y[i].value = sum / blocks;
    for (const double mean : block_means[i]) y[i].without_block.push_back((sum - mean) / (blocks - 1));
  }
  return y;
}

/// The same for points of known x.
std::vector<Replicated> without_scatter(const std::vector<double>& x, std::size_t blocks) {
  std::vector<Replicated> known;
  for (const double at : x) known.push_back({at, std::vector<double>(blocks, at)});
  return known;
}

constexpr int repetitions = 3000;

}  // namespace

TEST_CASE("chi squared about a line is its degrees of freedom on average, however correlated the points are") {
  // The scaled T^2 of p = m - 2 directions from B blocks has the variance 2p (B - 3)/(B - m - 2): the mean of 3000 is
  // known to 0.026 sqrt(p) or better. With (B - m - 2)/(B - 1) for the inverse, 8 of 32 would come out 8 % low, 14
  // standard errors; with variances alone, a correlation of 0.6 gives half the degrees of freedom or less.
  std::mt19937_64 random(20240);
  const double shared = GENERATE(0.0, 0.6);
  const std::size_t points = GENERATE(4u, 8u);
  constexpr int blocks = 32;
  std::vector<double> x;
  for (std::size_t i = 0; i < points; ++i) x.push_back(std::log(0.1 + 0.05 * static_cast<double>(i)));
  double mean = 0, mean_of_law = 0;
  for (int r = 0; r < repetitions; ++r) {
    const std::vector<Replicated> y = noisy_line(x, blocks, shared, random);
    const LineTest test = test_line(x, y);
    REQUIRE(test.reason.empty());
    REQUIRE(test.degrees_of_freedom == static_cast<int>(points) - 2);
    mean += test.chi2 / repetitions;
    mean_of_law += fit_power_law(without_scatter(x, blocks), y, {0.1, 0.3}).scatter.chi2 / repetitions;
  }
  const double p = static_cast<double>(points) - 2, m = p + 2;
  const double error = std::sqrt(2 * p * (blocks - 3) / (blocks - m - 2) / repetitions);
  CAPTURE(shared, points, mean, error);
  CHECK(std::abs(mean - p) < 5 * error);
  CHECK(mean_of_law == Approx(mean).epsilon(1e-9));  // the law fitted does not matter, only what is across it
}

TEST_CASE("an exponent that changes steadily is found with its errors where no single power holds") {
  // x around 0.2, where the points of the fit are not centred: slope 2 + 2 curvature x at its ends.
  std::mt19937_64 random(20241);
  constexpr int blocks = 32, rounds = 1000;
  const std::vector<double> x{-1.0, -0.4, 0.1, 0.7, 1.1, 1.4};
  const double curvature = -0.4, at_low = 2 - 2 * curvature, at_high = 2 + 2 * 1.4 * curvature;
  double mean = 0, covered_low = 0, covered_high = 0, pull_low = 0, pull_high = 0;
  for (int r = 0; r < rounds; ++r) {
    const ScalingFit fit =
        fit_power_law(without_scatter(x, blocks), noisy_line(x, blocks, 0, random, curvature), {0.1, 0.3});
    REQUIRE(fit.running.at_low.known());
    REQUIRE(fit.running.scatter.degrees_of_freedom == 3);
    if (r == 0) {
      CHECK(fit.running.low == Approx(std::exp(-1.0)));
      CHECK(fit.running.high == Approx(std::exp(1.4)));
      CHECK(fit.misses_the_points());
      CHECK(fit.running.meets_the_points());
    }
    const double low = (fit.running.at_low.value - at_low) / fit.running.at_low.standard_error;
    const double high = (fit.running.at_high.value - at_high) / fit.running.at_high.standard_error;
    mean += fit.running.scatter.chi2 / rounds;
    covered_low += (std::abs(low) < 1 ? 1.0 : 0.0) / rounds;
    covered_high += (std::abs(high) < 1 ? 1.0 : 0.0) / rounds;
    pull_low += low / rounds;
    pull_high += high / rounds;
  }
  CAPTURE(mean, covered_low, covered_high, pull_low, pull_high);
  CHECK(std::abs(mean - 3) < 5 * std::sqrt(2 * 3.0 * (blocks - 3) / (blocks - 8) / rounds));
  // Student's t with 31 degrees of freedom has 67.5 % within one error; a share of 1000 is known to 1.5 %.
  CHECK(std::abs(covered_low - 0.675) < 0.075);
  CHECK(std::abs(covered_high - 0.675) < 0.075);
  CHECK(std::abs(pull_low) < 0.17);
  CHECK(std::abs(pull_high) < 0.17);
  // Three points lie on a parabola whatever they are.
  const std::vector<double> three{-1, 0, 1};
  const ScalingFit fit =
      fit_power_law(without_scatter(three, blocks), noisy_line(three, blocks, 0, random), {0.1, 0.3});
  CHECK(fit.exponent.known());
  CHECK(fit.running.at_low.reason == "an exponent that changes needs 4 friction coefficients");
}

TEST_CASE("chi squared about a line says why it is unknown") {
  std::mt19937_64 random(7);
  const std::vector<double> x{1, 2, 3, 4, 5};
  CHECK(test_line(std::vector<double>{1, 2}, noisy_line({1, 2}, 16, 0, random)).reason ==
        "a line goes through any two points");
  CHECK(test_line(x, noisy_line(x, 8, 0, random)).reason == "8 blocks give no reliable covariance of 5 points");
  CHECK(test_line(x, noisy_line(x, 10, 0, random)).reason.empty());
  CHECK(test_line(x, without_scatter(x, 16)).reason == "the joint covariance of the points cannot be inverted");
  std::vector<Replicated> in_step = noisy_line(x, 16, 0, random);
  for (Replicated& y : in_step) y.without_block = in_step.front().without_block;
  const LineTest test = test_line(x, in_step);
  CHECK(test.reason == "the joint covariance of the points cannot be inverted");
  CHECK(std::isnan(test.chi2));
  CHECK(test.degrees_of_freedom == 0);
}
