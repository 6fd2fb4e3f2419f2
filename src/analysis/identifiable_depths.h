#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace granuscope {

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
