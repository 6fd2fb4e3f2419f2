// Source of the expected numbers: an independent implementation, 500 x 200 beads under a uniform load, layers 58 to
// 179, printed to four digits with errors below 1e-4: c_thrust = tan 30 deg sqrt(alpha), alpha averaged over the
// layers.
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "ensemble/ensemble_runner.h"

namespace granuscope {
namespace {

/// Half a unit of the last printed digit, and the largest standard error of the printed number.
constexpr double printed = 5e-5, error_of_source = 1e-4;

struct Measured {
  double value, error;
};

/// c_thrust from an ensemble, with its error from the spread over blocks.
Measured thrust_speed(double mu, std::uint64_t samples) {
  EnsembleSpec spec;
  spec.sampler.mu = mu;
  spec.sampler.seed = 5;
  spec.lattice = {.columns = 500, .layers = 200};
  spec.load = Load::uniform;
  spec.response.samples = samples;
  spec.response.blocks = 8;
  spec.layers.resize(122);
  std::iota(spec.layers.begin(), spec.layers.end(), 58);
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

void compare(std::uint64_t samples) {
  for (const auto& [mu, expected] : {std::pair{0.1, 0.5748}, {0.2, 0.5674}, {0.3, 0.5560}}) {
    const Measured c = thrust_speed(mu, samples);
    CAPTURE(mu, samples, c.value, c.error, expected);
    CHECK(std::abs(c.value - expected) <= printed + 5 * std::hypot(c.error, error_of_source));
    // So precise that a change of the law by a percent of c0 - c at mu = 0.3 could not hide behind the error.
    CHECK(c.error < 2e-4);
    CHECK(c.error > 0);
  }
}

TEST_CASE("c_thrust is that of an independent implementation") { compare(64); }

TEST_CASE("c_thrust is that of an independent implementation, with small errors", "[long]") { compare(1024); }

}  // namespace
}  // namespace granuscope
