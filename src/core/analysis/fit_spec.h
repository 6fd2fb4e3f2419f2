#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "model/lattice.h"
#include "support/error.h"
#include "support/key.h"

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

inline constexpr double least_identifiable_width = 0.1;  ///< bead diameters

/// [fit], bound to the spec.
std::vector<Key> keys_of(FitSpec& spec);

/// Layers recorded for a figure between the steps of the window take no part: drawing must not change a number.
bool at_step(const FitSpec& spec, int layer);
bool in_window(const FitSpec& spec, int layer);

/// The first number out of range on this lattice, of which so many layers at the bottom are not used.
Problem find_problem(const FitSpec& spec, const LatticeSpec& lattice, int unused = bottom_margin);

/// What a depth offers to a slope.
enum class DepthUse : std::uint8_t {
  fitted,
  other_shape,  ///< its response is no two Gaussians, as noise makes it seem now and then
  unidentified  ///< nothing, for any other reason
};

/// The depths that slopes are taken over, as indices in ascending order; `depths` are in the order of their layers. The
/// run reaches up from the deepest depth and ends at one that is unidentified, or at two neighbours of another shape. A
/// single one of these is left out: a run that ended there would have lost its depths to chance. Depths that are
/// unidentified are not left out one by one, since that would choose among those next to them by their noise.
std::vector<std::size_t> identifiable_depths(std::span<const DepthUse> depths);

}  // namespace granuscope
