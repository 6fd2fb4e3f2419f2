#pragma once
#include <array>
#include <vector>

#include "model/lattice.h"
#include "support/problem.h"

namespace granuscope {

/// Where and how the response is fitted. All layers must be usable (those of beads are 0 .. layers - 21).
struct FitSpec {
  int first_layer = 58;  ///< of the window over which the slopes c and D are taken
  int last_layer = 179;
  int layer_step = 3;      ///< an odd step alternates the two row parities
  int shallow_layer = 16;  ///< fits are also made, for the figures only, from this layer down to the window
  double min_identifiable_width = 0.5;                       ///< bead diameters; below it the bead width hides W
  std::array<double, 2> scaling_window{0.1, 0.3};            ///< of mu, inclusive: beta, gamma, alpha
  std::vector<std::array<double, 2>> other_scaling_windows;  ///< shown beside it
};

inline constexpr int least_window_depths = 3;  ///< fewest depths from which a slope is taken
inline constexpr double least_identifiable_width = 0.1, most_identifiable_width = 100;  ///< bead diameters

/// Layers recorded for a figure between the steps of the window take no part: drawing must not change a number.
bool at_step(const FitSpec& spec, int layer);
bool in_window(const FitSpec& spec, int layer);

/// The first number out of range on this lattice, of which so many layers at the bottom are not used.
Problem find_problem(const FitSpec& spec, const LatticeSpec& lattice, int unused = bottom_margin);

}  // namespace granuscope
