#include "analysis/precision.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granuscope {

std::uint64_t next_size(std::uint64_t rounds) { return rounds + (rounds + 1) / 2; }

std::uint64_t expected_size(std::uint64_t rounds, double rounds_needed, std::uint64_t most_rounds) {
  while (static_cast<double>(rounds) < rounds_needed && next_size(rounds) <= most_rounds) rounds = next_size(rounds);
  return rounds;
}

double stopped_scatter(int blocks) { return 1 + 1.2 / (blocks - 1); }

PrecisionLook look_at_precision(const PrecisionSpec& asked, const Transport& measured, std::uint64_t samples) {
  PrecisionLook look;
  double ratio = 0;
  const auto consider = [&](double target, const Estimate& number, const char* name) {
    if (target <= 0) return;
    if (!number.known()) {
      look.unattainable = true;
      if (look.reason.empty()) look.reason = std::string(name) + " is unknown: " + number.reason;
      return;
    }
    ratio = std::max(ratio, stopped_scatter(measured.spec.response.blocks) * number.standard_error / target);
  };
  consider(asked.c, measured.c, "c");
  consider(asked.D, measured.D, "D");
  look.reached = !look.unattainable && ratio <= 1;
  look.samples_needed =
      look.unattainable ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(samples) * ratio * ratio;
  return look;
}

ExpectedErrors expected_errors(double mu, bool multiplexed, double load, int columns, std::uint64_t samples) {
  constexpr double piles = 3461, wide = 500, worth_at_half = 90;
  double in_overloaded_piles = static_cast<double>(samples) * load * load;
  if (multiplexed) in_overloaded_piles *= worth_at_half * 4 * columns / wide;
  const double scale = std::sqrt(piles / in_overloaded_piles);
  return {(multiplexed ? 0.0045 : 0.011) * std::pow(mu, 1.7) * scale,
          (multiplexed ? 0.1 : 0.13) * std::pow(mu, 2.6) * scale};
}

}  // namespace granuscope
