#include "analysis/jackknife.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace granuscope;

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
