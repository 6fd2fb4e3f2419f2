#pragma once
#include "plot/gaps.h"

namespace granuscope {

/// The categorical colours of templates/palette.txt (Okabe and Ito) by name, as "#rrggbb": black, orange, sky_blue,
/// bluish_green, yellow, blue, vermilion, reddish_purple, and frame for furniture. Throws std::logic_error if the
/// palette lacks one.
const Gaps& plot_colours();

}  // namespace granuscope
