// Source of the expected numbers: naive_granusolve.h, the law written a second time from its description, which draws
// its own piles of 500 x 200 beads under a uniform load. c_thrust = tan 30 deg sqrt(alpha), alpha averaged over layers
// 58 to 179.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "ensemble/ensemble_runner.h"
#include "kit/naive_granusolve.h"
#include "kit/sampling_statistics.h"

namespace granuscope {
namespace {

constexpr int first_layer = 58, last_layer = 179;

/// c_thrust from an ensemble, with its error from the spread over blocks.
test::Estimated thrust_speed(double mu, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = 5;
  spec.lattice = {.columns = 500, .layers = 200};
  spec.load = Load::uniform;
  spec.response.samples = samples;
  spec.response.blocks = 8;
  spec.layers.resize(last_layer - first_layer + 1);
  std::iota(spec.layers.begin(), spec.layers.end(), first_layer);
  spec.record_profiles = false;
  const EnsembleRecord record = run_ensemble(spec, 0, nullptr);
  const std::vector<double>& sum = record.sums.quantities.at("thrust").sum;
  std::vector<double> speeds;
  for (std::size_t block = 0; block < 8; ++block) {
    const auto from = sum.begin() + static_cast<std::ptrdiff_t>(block * 122);
    const double total = std::accumulate(from, from + 122, 0.0);
    speeds.push_back(std::sqrt(total / (122.0 * static_cast<double>(record.sums.count[block])) / 3));
  }
  const double mean = std::accumulate(speeds.begin(), speeds.end(), 0.0) / 8;
  double squares = 0;
  for (const double speed : speeds) squares += (speed - mean) * (speed - mean);
  return {mean, std::sqrt(squares / (8 * 7))};
}

/// The same from the second implementation.
test::Estimated naive_thrust_speed(double mu, std::uint64_t samples) {
  const Lattice lattice({.columns = 500, .layers = 200});
  const std::vector<double> load(500, 1.0);
  test::NaiveGranusolve law(lattice, mu, 12);
  Pile pile(lattice);
  test::RunningMean alpha;
  for (std::uint64_t sample = 0; sample < samples; ++sample) {
    REQUIRE(law.draw(load, pile));
    double sum = 0;
    for (std::size_t at = lattice.index(first_layer, 0); at < lattice.index(last_layer + 1, 0); ++at)
      sum += pile.H_R[at] - pile.H_L[at];
    alpha.add(std::sqrt(3.0) * sum / (500 * (last_layer - first_layer + 1)));
  }
  const double speed = std::sqrt(alpha.estimate().value / 3);
  return {speed, std::sqrt(alpha.variance() / static_cast<double>(samples)) / (6 * speed)};
}

void compare(std::uint64_t samples, std::uint64_t naive_samples) {
  for (const double mu : {0.1, 0.2, 0.3}) {
    const test::Estimated c = thrust_speed(mu, samples), expected = naive_thrust_speed(mu, naive_samples);
    CAPTURE(mu, samples, c.value, c.error, expected.value, expected.error);
    CHECK(std::abs(test::sigmas(c, expected)) <= 5);
    // So precise that a change of the law by a percent of c0 - c at mu = 0.3 could not hide behind the error.
    CHECK(c.error < 2e-4);
    CHECK(c.error > 0);
    CHECK(expected.error < 2e-4);
  }
}

TEST_CASE("c_thrust is that of a second implementation", "[unsanitized]") { compare(64, test::sanitized ? 16 : 32); }

TEST_CASE("c_thrust is that of a second implementation, with small errors", "[long]") { compare(1024, 512); }

}  // namespace
}  // namespace granuscope
