#pragma once
#include <cstdint>
#include <vector>

#include "analysis/side_measurements.h"

namespace granuscope {

/// The piles of a stress test, drawn by the law "granusolve".
struct StressSpec {
  int layers = 0;  ///< of the deep piles; 0: no stress test
  int columns = 64;
};

/// Layers of the piles under uneven loads, and of those on the narrowest ring.
inline constexpr int uneven_stress_layers = 60, narrow_stress_layers = 1000;

/// Friction from next to none to next to sqrt(3), with 1/sqrt(3), where a contact may stand upright, and the numbers
/// before and after it.
std::vector<double> stress_friction();

/// At each friction: deep piles with an overload, the narrowest ring, loads over ten orders of magnitude side by side,
/// and half of the top unloaded. Every pile is either solved, and audited, or its outcome says by name why not.
std::vector<StressTrial> run_stress(const StressSpec& spec, std::uint64_t seed);

}  // namespace granuscope
