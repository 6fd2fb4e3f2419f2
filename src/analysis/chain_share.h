#pragma once
#include <vector>

#include "analysis/measured_ensemble.h"
#include "analysis/side_measurements.h"

namespace granuscope {

/// Distance from a ray within which a bead counts as part of its chain, in bead diameters.
inline constexpr double chain_half_width = 3;

/// The layers to record for it: all that are shown.
std::vector<int> chain_layers(int shown_layers);

/// The share of the mean response within chain_half_width of the rays x = +-c z, with c = c_thrust of the same piles. A
/// bead counts by the part of its width that lies inside. From the depth on where the two bands are as far apart as
/// each is wide. Unknown, with the reason, where the piles are too shallow for that.
ChainShare measure_chain_share(const MeasuredEnsemble& ensemble);

}  // namespace granuscope
