#pragma once
#include <array>
#include <string>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/results.h"

namespace granuscope {

/// Fewest points from which an exponent is taken.
inline constexpr int min_power_law_points = 3;

/// A fitted power law with the replicates of its exponent; they are empty where it is unknown.
struct ReplicatedPowerLaw {
  ScalingFit fit;
  Replicated exponent;
};

/// ln y = intercept + exponent ln x through points with errors on both axes, given as logarithms with replicates over
/// the same blocks, all of one weight. `window` of mu is only noted. Unknown, with the reason, below three
/// points or where a logarithm is undefined.
ScalingFit fit_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                         std::array<double, 2> window);

/// The same with the replicates that are needed to compare exponents.
ReplicatedPowerLaw fit_replicated_power_law(const std::vector<Replicated>& log_x, const std::vector<Replicated>& log_y,
                                            std::array<double, 2> window);

/// "from 2.07(4) at μ = 0.014 to 1.94(1) at 0.1"; `of`: what the power is one of.
std::string in_words(const RunningExponent& running, const char* of);

}  // namespace granuscope
